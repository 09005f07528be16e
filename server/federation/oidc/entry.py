"""OpenID Connect among the ways to sign in from our own page; and the end of sessions that its server asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from server.database import Database
from server.federation import signing
from server.federation.models import IdentityProvider
from server.federation.oidc.schemas import oidc_settings
from server.federation.oidc.sign_in import Client, authorization_url, fetch_claims, require_answer
from server.federation.oidc.tokens import EndedSession, verify_logout_token
from server.federation.proofs import BrowserAnswer, ProvenPerson
from server.federation.service import Federation
from server.identity.secrets import new_token

ASSERTION_SECONDS = 60


def _client(provider: IdentityProvider, back: str) -> Client:
    return Client(provider.issuer, provider.client_id, oidc_settings(provider), back)


def start(federation: Federation, provider: IdentityProvider, back: str, state: str, details: Mapping[str, Any]) -> str:
    """Raises OutgoingError."""
    metadata = federation.discovery.find(provider.issuer)
    return authorization_url(metadata, _client(provider, back), state, details["nonce"], details["verifier"])


def prove(
    federation: Federation,
    database: Database,
    provider: IdentityProvider,
    back: str,
    answer: BrowserAnswer,
    details: Mapping[str, Any],
) -> ProvenPerson:
    """Raises Refused or OutgoingError."""
    metadata = federation.discovery.find(provider.issuer)
    require_answer(metadata, answer)

    def prove_ourselves(audience: str) -> str:
        own = {"iss": provider.client_id, "sub": provider.client_id, "aud": audience, "jti": new_token()}
        return signing.sign_claims(database, own, ASSERTION_SECONDS)

    claims = fetch_claims(
        federation.outgoing,
        federation.keys,
        metadata,
        _client(provider, back),
        answer.code,
        nonce=details["nonce"],
        verifier=details["verifier"],
        assertion=prove_ourselves,
    )
    return ProvenPerson(claims["sub"], claims.get("sid", ""), claims)


def read_logout(federation: Federation, provider: IdentityProvider, token: str) -> EndedSession:
    """Return what a server says has ended. Raises Refused or OutgoingError."""
    metadata = federation.discovery.find(provider.issuer)
    return verify_logout_token(
        token, federation.keys, metadata.jwks_uri, issuer=provider.issuer, client_id=provider.client_id
    )
