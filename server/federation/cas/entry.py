"""CAS among the ways to sign in from our own page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from urllib.parse import urlencode

from server.database import Database
from server.federation.cas.messages import CasPerson
from server.federation.cas.sign_in import login_url, validate_ticket
from server.federation.models import IdentityProvider
from server.federation.proofs import BrowserAnswer, ProvenPerson
from server.federation.service import Federation

#: The name of the principal among the attributes, for a rule.
USER = "user"


def build_service_url(return_url: str, state: str) -> str:
    return f"{return_url}?{urlencode({'etat': state})}"


def start_cas_sign_in(
    _federation: Federation, provider: IdentityProvider, return_url: str, state: str, _details: Mapping[str, Any]
) -> str:
    return login_url(provider.issuer, build_service_url(return_url, state))


def prove_cas_person(
    federation: Federation,
    _database: Database,
    provider: IdentityProvider,
    return_url: str,
    answer: BrowserAnswer,
    _details: Mapping[str, Any],
) -> ProvenPerson:
    """Raises FederationRefused or OutgoingError."""
    service = build_service_url(return_url, answer.state)
    person = validate_ticket(federation.outgoing, provider.issuer, answer.ticket, service)
    return ProvenPerson(person.user, answer.ticket, read_claims(person))


def read_claims(person: CasPerson) -> Mapping[str, Any]:
    return {USER: person.user, **person.attributes}
