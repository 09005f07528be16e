"""The tokens of an OpenID Connect server: the proof of a sign-in (Core 1.0, 3.1.3.7), and of the end of a session
(Back-Channel Logout 1.0, 2.6)."""

from __future__ import annotations

import base64
import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hmac import compare_digest
from typing import Any

from server.federation.errors import FederationRefused
from server.federation.models import ID_LENGTH
from server.federation.remote_keys import RemoteKeyCache
from server.federation.tokens import MALFORMED, require_audience, verify_token
from server.identity.models import SUBJECT_LENGTH
from server.text.lines import describe_forbidden_character

#: HMAC is not among them: a public key would be its secret.
ALGORITHMS = frozenset({"RS256", "PS256", "ES256"})
LOGOUT_EVENT = "http://schemas.openid.net/event/backchannel-logout"
LOGOUT_TYPES = frozenset({"jwt", "logout+jwt"})
OTHER_ISSUER = "Cette connexion vient d’un autre système que celui où vous l’avez commencée."
OTHER_SIGN_IN = "Cette connexion est la réponse à une autre demande : recommencez depuis la page de connexion."
OTHER_PERSON = "Le système de votre établissement a nommé deux personnes différentes."


@dataclass(frozen=True)
class LogoutClaims:
    """A session that has ended, of this name (`session`), or all of a person (`subject`).

    `issued_at` is in seconds since the epoch.
    """

    session: str
    subject: str
    issued_at: float


def verify_id_token(
    token: str,
    keys: RemoteKeyCache,
    keys_url: str,
    *,
    issuer: str,
    client_id: str,
    nonce: str,
    access_token: str = "",
    clock: Callable[[], float] = time.time,
) -> Mapping[str, Any]:
    """Return the claims of a person who has signed in now, for us, in answer to our request. Raises
    FederationRefused."""
    claims = verify_token(token, keys, keys_url, algorithms=ALGORITHMS, clock=clock)
    _require_issuer_and_audience(claims, issuer, client_id)
    _require_subject(claims)
    told = claims.get("nonce")
    if not isinstance(told, str) or not nonce or not compare_digest(told.encode(), nonce.encode()):
        raise FederationRefused("nonce", OTHER_SIGN_IN)
    if "at_hash" in claims and claims["at_hash"] != _access_token_hash(access_token):
        raise FederationRefused("at_hash", MALFORMED)
    if "sid" in claims and not _is_clean_name(claims["sid"], ID_LENGTH):
        raise FederationRefused("sid", MALFORMED)
    if LOGOUT_EVENT in _read_events(claims):
        raise FederationRefused("events", MALFORMED)
    return claims


def merge_userinfo(claims: Mapping[str, Any], document: Any) -> Mapping[str, Any]:
    """Return the claims of a token with those of its userinfo that it lacks. Raises FederationRefused for another
    person's."""
    if not isinstance(document, dict) or document.get("sub") != claims["sub"]:
        raise FederationRefused("userinfo", OTHER_PERSON)
    return {**document, **claims}


def verify_logout_token(
    token: str,
    keys: RemoteKeyCache,
    keys_url: str,
    *,
    issuer: str,
    client_id: str,
    clock: Callable[[], float] = time.time,
) -> LogoutClaims:
    """Return what has ended. Raises FederationRefused, also for the token of a sign-in."""
    claims = verify_token(token, keys, keys_url, algorithms=ALGORITHMS, clock=clock, types=LOGOUT_TYPES)
    _require_issuer_and_audience(claims, issuer, client_id)
    if "nonce" in claims or not isinstance(_read_events(claims).get(LOGOUT_EVENT), dict):
        raise FederationRefused("events", MALFORMED)
    if not _is_clean_name(claims.get("jti"), ID_LENGTH):
        raise FederationRefused("jti", MALFORMED)
    if "sid" not in claims and "sub" not in claims:
        raise FederationRefused("subject", MALFORMED)
    if "sub" in claims:
        _require_subject(claims)
    if "sid" in claims and not _is_clean_name(claims["sid"], ID_LENGTH):
        raise FederationRefused("sid", MALFORMED)
    return LogoutClaims(claims.get("sid", ""), claims.get("sub", ""), float(claims["iat"]))


def _require_issuer_and_audience(claims: Mapping[str, Any], issuer: str, client_id: str) -> None:
    if claims.get("iss") != issuer:
        raise FederationRefused("issuer", OTHER_ISSUER)
    require_audience(claims, client_id)


def _require_subject(claims: Mapping[str, Any]) -> None:
    if not _is_clean_name(claims.get("sub"), SUBJECT_LENGTH):
        raise FederationRefused("subject", MALFORMED)


def _is_clean_name(value: Any, longest: int) -> bool:
    return (
        isinstance(value, str)
        and 0 < len(value) <= longest
        and value.strip() == value
        and not _has_odd_character(value)
    )


def _has_odd_character(value: str) -> bool:
    return bool(describe_forbidden_character(value)) or "\n" in value or "\t" in value


def _read_events(claims: Mapping[str, Any]) -> Mapping[str, Any]:
    events = claims.get("events")
    return events if isinstance(events, dict) else {}


def _access_token_hash(access_token: str) -> str:
    """Return the hash of an access token that stands beside it: that of algorithms with SHA-256."""
    digest = hashlib.sha256(access_token.encode()).digest()
    return base64.urlsafe_b64encode(digest[:16]).rstrip(b"=").decode()
