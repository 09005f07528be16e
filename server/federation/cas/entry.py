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


def service_address(back: str, state: str) -> str:
    return f"{back}?{urlencode({'etat': state})}"


def start(
    _federation: Federation, provider: IdentityProvider, back: str, state: str, _details: Mapping[str, Any]
) -> str:
    return login_url(provider.issuer, service_address(back, state))


def prove(
    federation: Federation,
    _database: Database,
    provider: IdentityProvider,
    back: str,
    answer: BrowserAnswer,
    _details: Mapping[str, Any],
) -> ProvenPerson:
    """Raises Refused or OutgoingError."""
    service = service_address(back, answer.state)
    person = validate_ticket(federation.outgoing, provider.issuer, answer.ticket, service)
    return ProvenPerson(person.user, answer.ticket, read_claims(person))


def read_claims(person: CasPerson) -> Mapping[str, Any]:
    return {USER: person.user, **person.attributes}
