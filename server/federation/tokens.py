"""Signed tokens of other systems (JWT): strict algorithms, keys of their published list alone, strict times."""

from __future__ import annotations

import base64
import binascii
import json
import time
from collections.abc import Callable, Collection, Mapping
from typing import Any

from server.federation.errors import FederationRefused, OutgoingError
from server.federation.remote_keys import RemoteKeyCache

MAX_TOKEN = 48 * 1024  # characters
MAX_LIFETIME = 24 * 3600  # seconds between issue and end
LEEWAY = 60  # seconds by which clocks may differ
MAX_AGE = 15 * 60  # seconds since the issue
HEADER_MEMBERS = frozenset({"alg", "kid", "typ", "x5t", "x5t#S256"})
TOKEN_TYPES = frozenset({"jwt"})
#: What LTI and OpenID Connect need; each caller gives its own part of it.
ALGORITHMS = frozenset({"RS256", "PS256", "ES256"})
MALFORMED = "Ce qui a été reçu n’est pas un jeton signé comme il se doit."
UNKNOWN_KEY = "La signature ne peut pas être vérifiée : {reason}."
FORGED = "La signature n’est pas celle du système de l’établissement."
EXPIRED = "Ce lien de connexion n’est plus valable : recommencez depuis votre établissement."

Claims = Mapping[str, Any]


def read_header(token: str) -> Mapping[str, Any]:
    """Return the header of a token, unverified. Raises FederationRefused."""
    parts = token.split(".")
    if len(token) > MAX_TOKEN or len(parts) != 3 or not token.isascii():
        raise FederationRefused("malformed", MALFORMED)
    try:
        header = json.loads(base64.urlsafe_b64decode(parts[0] + "=" * (-len(parts[0]) % 4)))
    except (ValueError, binascii.Error, RecursionError):
        raise FederationRefused("malformed", MALFORMED) from None
    if not isinstance(header, dict):
        raise FederationRefused("malformed", MALFORMED)
    return header


def verify_token(
    token: str,
    keys: RemoteKeyCache,
    keys_url: str,
    *,
    algorithms: Collection[str],
    clock: Callable[[], float] = time.time,
    types: Collection[str] = TOKEN_TYPES,
) -> Claims:
    """Return the claims of a token with a valid signature and valid times. Raises FederationRefused.

    The key is the one of the published list that the header names by its id: no key of the header itself, nor of an
    address in it, is ever used.
    """
    from joserfc import jwt
    from joserfc.errors import JoseError

    header = read_header(token)
    algorithm, kid = header.get("alg"), header.get("kid")
    if algorithm not in set(algorithms) & ALGORITHMS:
        raise FederationRefused("algorithm", MALFORMED)
    if not header.keys() <= HEADER_MEMBERS or str(header.get("typ", "JWT")).lower() not in types:
        raise FederationRefused("header", MALFORMED)
    if not isinstance(kid, str) or not 0 < len(kid) <= 255:
        raise FederationRefused("key", UNKNOWN_KEY.format(reason="elle ne dit pas avec quelle clé elle est faite"))
    try:
        known = keys.find(keys_url, kid)
    except OutgoingError as error:
        raise FederationRefused("key", UNKNOWN_KEY.format(reason=error.reason)) from error
    if algorithm not in known.algorithms:
        raise FederationRefused("algorithm", MALFORMED)
    try:
        claims = jwt.decode(token, known.key, algorithms=[algorithm]).claims
    except (JoseError, ValueError, TypeError, RecursionError) as error:
        raise FederationRefused("signature", FORGED) from error
    if not isinstance(claims, dict):
        raise FederationRefused("malformed", MALFORMED)
    require_times(claims, clock())
    return claims


def require_times(claims: Claims, now: float) -> None:
    """Raise FederationRefused for a token that has ended, or was not issued lately."""
    issued, ends = _read_time_claim(claims, "iat"), _read_time_claim(claims, "exp")
    if not issued - LEEWAY <= now <= issued + MAX_AGE or now > ends + LEEWAY:
        raise FederationRefused("expired", EXPIRED)
    if not 0 < ends - issued <= MAX_LIFETIME:
        raise FederationRefused("times", MALFORMED)
    if "nbf" in claims and now < _read_time_claim(claims, "nbf") - LEEWAY:
        raise FederationRefused("expired", EXPIRED)


def _read_time_claim(claims: Claims, name: str) -> float:
    """Return a time of the claims, in seconds since 1970. Raises FederationRefused."""
    value = claims.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e11:
        raise FederationRefused("times", MALFORMED)
    return value


def require_audience(claims: Claims, client_id: str) -> None:
    """Raise FederationRefused for a token that is not for us alone, or is authorised for somebody else (OIDC Core,
    3.1.3.7)."""
    audience = claims.get("aud")
    names = [audience] if isinstance(audience, str) else audience
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise FederationRefused("audience", MALFORMED)
    if client_id not in names or (len(names) > 1 and "azp" not in claims):
        raise FederationRefused("audience", "Cette connexion est faite pour un autre service.")
    if "azp" in claims and claims["azp"] != client_id:
        raise FederationRefused("audience", "Cette connexion est faite pour un autre service.")
