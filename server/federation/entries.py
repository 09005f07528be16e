"""Sign-ins from our own page by a school's system (CAS, OpenID Connect): begun, and proved once.

A protocol is a row of `ENTRIES`: the address to which a browser goes, and the proof with which it comes back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from server.database import Database, utc_now
from server.federation import pending, repository
from server.federation.cas import entry as cas
from server.federation.cas.schemas import cas_settings
from server.federation.errors import FederationRefused
from server.federation.models import ActivityKind, IdentityProvider, Protocol
from server.federation.oidc import entry as oidc
from server.federation.oidc.schemas import oidc_settings
from server.federation.pending import BegunSignIn
from server.federation.proofs import BrowserAnswer, ProvenPerson
from server.federation.rules import Rule
from server.federation.service import Federation
from server.identity.secrets import draw_secret_token

ENTRY_PATH = "/connexion/etablissement/{provider_id}"
RETURN_PATH, LOGOUT_PATH = f"{ENTRY_PATH}/retour", f"{ENTRY_PATH}/deconnexion"
TRIAL = "trial"
NOT_HERE = "On n’entre pas par cette plateforme depuis cette page : partez de la plateforme elle-même."


@dataclass(frozen=True)
class ProtocolFunctions:
    """A protocol's functions.

    `start` gets our return address, the state and the details of the sign-in, and returns the address of the system;
    `prove` gets the same, and what the browser brings back. Both raise FederationRefused or OutgoingError.
    """

    start: Callable[[Federation, IdentityProvider, str, str, Mapping[str, Any]], str]
    prove: Callable[[Federation, Database, IdentityProvider, str, BrowserAnswer, Mapping[str, Any]], ProvenPerson]
    rule: Callable[[IdentityProvider], Rule]
    service: Callable[[IdentityProvider], str]


ENTRIES: Mapping[str, ProtocolFunctions] = {
    Protocol.cas: ProtocolFunctions(
        cas.start_cas_sign_in,
        cas.prove_cas_person,
        lambda row: cas_settings(row).rule,
        lambda row: cas_settings(row).service,
    ),
    Protocol.oidc: ProtocolFunctions(
        oidc.start_oidc_sign_in,
        oidc.prove_oidc_person,
        lambda row: oidc_settings(row).rule,
        lambda row: oidc_settings(row).service,
    ),
}


def find_entry(provider: IdentityProvider) -> ProtocolFunctions:
    """Return the functions of a provider's protocol. Raises FederationRefused for a platform that one enters from
    itself."""
    entry = ENTRIES.get(provider.protocol)
    if entry is None:
        raise FederationRefused("protocol", NOT_HERE)
    return entry


def return_url(provider: IdentityProvider) -> str:
    """Return the address of ours to which the system leads a browser back."""
    service = find_entry(provider).service(provider).rstrip("/")
    return service + RETURN_PATH.format(provider_id=provider.id)


def begin_sign_in(
    database: Database, federation: Federation, provider: IdentityProvider, target: str, *, trial_by: UUID | None = None
) -> tuple[BegunSignIn, str]:
    """Begin a sign-in, and return it with the address to which the browser goes. `trial_by`: an administrator tries the
    rule, and no session will be opened. Raises FederationRefused or OutgoingError."""
    entry = find_entry(provider)
    details = {"verifier": draw_secret_token(), **({TRIAL: str(trial_by)} if trial_by else {})}
    with database.write() as db:
        begun, nonce = pending.begin_own_sign_in(db, provider.id, target, details)
    address = entry.start(federation, provider, return_url(provider), begun.state, {**details, pending.NONCE: nonce})
    return begun, address


def prove_person(
    database: Database,
    federation: Federation,
    provider: IdentityProvider,
    answer: BrowserAnswer,
    details: Mapping[str, Any],
) -> ProvenPerson:
    """Return who has signed in; `details` are of a sign-in that has been used up. Raises FederationRefused or
    OutgoingError."""
    return find_entry(provider).prove(federation, database, provider, return_url(provider), answer, details)


def record_failure(database: Database, provider_id: UUID, kind: ActivityKind, reason: str) -> None:
    """Write to the activity of a provider, unless it has been removed meanwhile."""
    with database.write() as db:
        if repository.find_provider(db, provider_id) is not None:
            repository.record_activity(db, provider_id, kind, utc_now(), reason, succeeded=False)
