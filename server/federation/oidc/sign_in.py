"""Sign-in by OpenID Connect: the authorization code flow with PKCE (RFC 7636) and the issuer's check (RFC 9207)."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote_plus, urlencode

from server.federation.discovery import Metadata, preferred_authentication
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.oidc.schemas import OidcSettings
from server.federation.oidc.tokens import OTHER_ISSUER, merge_userinfo, verify_id_token
from server.federation.outgoing import Outgoing, with_query
from server.federation.proofs import BrowserAnswer
from server.federation.remote_keys import RemoteKeyCache

MAX_CODE, MAX_ACCESS_TOKEN = 4000, 16_000  # characters
ASSERTION = "urn:ietf:params:oauth:client-assertion-type:jwt-bearer"
CANCELLED = "La connexion n’a pas abouti dans le système de votre établissement ({reason})."
NO_TOKEN = "Le système de votre établissement n’a pas répondu comme un serveur OpenID Connect."

#: Returns our signed proof for a token endpoint of this address.
Assertion = Callable[[str], str]


@dataclass(frozen=True)
class OidcClient:
    """We, as a server of this issuer knows us."""

    issuer: str
    client_id: str
    settings: OidcSettings
    redirect_uri: str


def code_challenge(verifier: str) -> str:
    """Return the S256 challenge of a verifier (RFC 7636, 4.2)."""
    return base64.urlsafe_b64encode(hashlib.sha256(verifier.encode()).digest()).rstrip(b"=").decode()


def authorization_url(metadata: Metadata, client: OidcClient, state: str, nonce: str, verifier: str) -> str:
    """Return the server's address to which a browser goes to sign in."""
    query = {
        "response_type": "code",
        "client_id": client.client_id,
        "redirect_uri": client.redirect_uri,
        "scope": " ".join(dict.fromkeys(("openid", *client.settings.scopes))),
        "state": state,
        "nonce": nonce,
        "code_challenge": code_challenge(verifier),
        "code_challenge_method": "S256",
    }
    return with_query(metadata.authorization_endpoint, query)


def require_own_code(metadata: Metadata, answer: BrowserAnswer) -> None:
    """Raise FederationRefused for the answer of another server, and for one without a code."""
    if answer.issuer != metadata.issuer and (answer.issuer or metadata.answers_with_issuer):
        raise FederationRefused("issuer", OTHER_ISSUER)
    if answer.error:
        reason = answer.error[:40] if answer.error.isascii() and answer.error.isprintable() else "refusée"
        raise FederationRefused("cancelled", CANCELLED.format(reason=reason))
    if not 0 < len(answer.code) <= MAX_CODE:
        raise FederationRefused("code", NO_TOKEN)


def fetch_claims(
    outgoing: Outgoing,
    keys: RemoteKeyCache,
    metadata: Metadata,
    client: OidcClient,
    code: str,
    *,
    nonce: str,
    verifier: str,
    assertion: Assertion,
) -> Mapping[str, Any]:
    """Exchange a code for the claims of a person. Raises FederationRefused or OutgoingError."""
    document = _exchange_code_for_tokens(outgoing, metadata, client, code, verifier, assertion)
    token, access_token = document.get("id_token"), document.get("access_token")
    if not isinstance(token, str) or not isinstance(access_token, str) or len(access_token) > MAX_ACCESS_TOKEN:
        raise FederationRefused("token", NO_TOKEN)
    claims = verify_id_token(
        token,
        keys,
        metadata.jwks_uri,
        issuer=client.issuer,
        client_id=client.client_id,
        nonce=nonce,
        access_token=access_token,
    )
    if not metadata.userinfo_endpoint:
        return claims
    if not access_token.isascii() or not access_token.isprintable():
        raise FederationRefused("token", NO_TOKEN)
    headers = {"Authorization": f"Bearer {access_token}"}
    return merge_userinfo(claims, outgoing.get_json(metadata.userinfo_endpoint, headers=headers))


def _exchange_code_for_tokens(
    outgoing: Outgoing, metadata: Metadata, client: OidcClient, code: str, verifier: str, assertion: Assertion
) -> Mapping[str, Any]:
    form = {
        "grant_type": "authorization_code",
        "code": code,
        "redirect_uri": client.redirect_uri,
        "code_verifier": verifier,
    }
    headers = {"Content-Type": "application/x-www-form-urlencoded"}
    secret = client.settings.client_secret
    method = preferred_authentication(metadata, bool(secret))
    if method == "client_secret_basic":
        pair = f"{quote_plus(client.client_id)}:{quote_plus(secret)}"
        headers["Authorization"] = f"Basic {base64.b64encode(pair.encode()).decode()}"
    else:
        form["client_id"] = client.client_id
    if method == "client_secret_post":
        form["client_secret"] = secret
    if method == "private_key_jwt":
        form |= {"client_assertion_type": ASSERTION, "client_assertion": assertion(metadata.token_endpoint)}
    try:
        answer = outgoing.request("POST", metadata.token_endpoint, headers=headers, content=urlencode(form).encode())
    except OutgoingError as error:
        if error.status in {400, 401}:
            raise FederationRefused("code", CANCELLED.format(reason=f"code refusé, réponse {error.status}")) from error
        raise
    document = answer.json()
    if not isinstance(document, dict):
        raise FederationRefused("token", NO_TOKEN)
    return document
