"""OpenID Connect among the ways to sign in from our own page; and the end of sessions that its server asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from server.database import Database
from server.federation import signing
from server.federation.models import IdentityProvider
from server.federation.oidc.schemas import oidc_settings
from server.federation.oidc.sign_in import OidcClient, authorization_url, fetch_claims, require_own_code
from server.federation.oidc.tokens import LogoutClaims, verify_logout_token
from server.federation.proofs import BrowserAnswer, ProvenPerson
from server.federation.service import Federation
from server.identity.secrets import draw_secret_token

ASSERTION_SECONDS = 60


def _build_client(provider: IdentityProvider, return_url: str) -> OidcClient:
    return OidcClient(provider.issuer, provider.client_id, oidc_settings(provider), return_url)


def start_oidc_sign_in(
    federation: Federation, provider: IdentityProvider, return_url: str, state: str, details: Mapping[str, Any]
) -> str:
    """Raises OutgoingError."""
    metadata = federation.discovery.find(provider.issuer)
    return authorization_url(
        metadata, _build_client(provider, return_url), state, details["nonce"], details["verifier"]
    )


def prove_oidc_person(
    federation: Federation,
    database: Database,
    provider: IdentityProvider,
    return_url: str,
    answer: BrowserAnswer,
    details: Mapping[str, Any],
) -> ProvenPerson:
    """Raises FederationRefused or OutgoingError."""
    metadata = federation.discovery.find(provider.issuer)
    require_own_code(metadata, answer)

    def prove_ourselves(audience: str) -> str:
        own = {"iss": provider.client_id, "sub": provider.client_id, "aud": audience, "jti": draw_secret_token()}
        return signing.sign_claims(database, own, ASSERTION_SECONDS)

    claims = fetch_claims(
        federation.outgoing,
        federation.keys,
        metadata,
        _build_client(provider, return_url),
        answer.code,
        nonce=details["nonce"],
        verifier=details["verifier"],
        assertion=prove_ourselves,
    )
    return ProvenPerson(claims["sub"], claims.get("sid", ""), claims)


def read_logout(federation: Federation, provider: IdentityProvider, token: str) -> LogoutClaims:
    """Return what a server says has ended. Raises FederationRefused or OutgoingError."""
    metadata = federation.discovery.find(provider.issuer)
    return verify_logout_token(
        token, federation.keys, metadata.jwks_uri, issuer=provider.issuer, client_id=provider.client_id
    )
