"""The XML of a CAS server: the answer about a ticket (CAS Protocol 3.0, 2.5), and the end of a session (2.3.3).

Documents are bounded, UTF-8, and without a document type: no entity is ever expanded.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from server.federation.errors import FederationRefused
from server.identity.models import SUBJECT_LENGTH
from server.text.lines import describe_forbidden_character

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

CAS, SAML = "{http://www.yale.edu/tp/cas}", "{urn:oasis:names:tc:SAML:2.0:protocol}"
MAX_ANSWER, MAX_LOGOUT = 64 * 1024, 8 * 1024  # bytes
MAX_ELEMENTS, MAX_TICKET, MAX_VALUE = 1000, 256, 4000
SERVICE_TICKET = re.compile(r"ST-[\x21-\x7e]{1,252}")
MALFORMED = "La réponse du système de votre établissement n’est pas celle d’un serveur CAS."
USED_TICKET = "Ce ticket de connexion a déjà servi, ou n’est plus valable : recommencez depuis la page de connexion."
UNKNOWN_SERVICE = (
    "Le serveur CAS de votre établissement ne connaît pas encore ce service : son administrateur doit y inscrire "
    "l’adresse de Balise."
)
FAILURES = {
    "INVALID_TICKET": ("ticket", USED_TICKET),
    "INVALID_TICKET_SPEC": ("ticket", USED_TICKET),
    "INVALID_SERVICE": ("service", UNKNOWN_SERVICE),
    "UNAUTHORIZED_SERVICE": ("service", UNKNOWN_SERVICE),
}


@dataclass(frozen=True)
class CasPerson:
    """A person as a CAS server names them; each attribute has one value or several, in the order of the answer."""

    user: str
    attributes: Mapping[str, Sequence[str]] = field(default_factory=dict)


def is_service_ticket(ticket: str) -> bool:
    return SERVICE_TICKET.fullmatch(ticket) is not None


def parse_validation_answer(content: bytes) -> CasPerson:
    """Return the person of an answer to `serviceValidate`. Raises FederationRefused for a failure, and for anything
    else."""
    root = _parse_safe_xml(content, MAX_ANSWER)
    children = list(root)
    if root.tag != f"{CAS}serviceResponse" or len(children) != 1:
        raise FederationRefused("malformed", MALFORMED)
    (outcome,) = children
    if outcome.tag == f"{CAS}authenticationFailure":
        code = str(outcome.get("code", ""))
        raise FederationRefused(
            *FAILURES.get(code, ("cas", f"Le serveur CAS a refusé ({code[:40] or 'sans raison'})."))
        )
    users = outcome.findall(f"{CAS}user")
    if outcome.tag != f"{CAS}authenticationSuccess" or len(users) != 1 or len(users[0]):
        raise FederationRefused("malformed", MALFORMED)
    user = (users[0].text or "").strip()
    if not 0 < len(user) <= SUBJECT_LENGTH or describe_forbidden_character(user) or "\n" in user or "\t" in user:
        raise FederationRefused("subject", MALFORMED)
    return CasPerson(user, _read_attributes(outcome.findall(f"{CAS}attributes")))


def _read_attributes(groups: Sequence[Element]) -> Mapping[str, Sequence[str]]:
    """Read attributes by name: each an element of its own, or `attribute` with a name and a value."""
    values: dict[str, list[str]] = {}
    for row in (row for group in groups for row in group if not len(row)):
        name, value = row.tag.rpartition("}")[2], (row.text or "").strip()
        if name == "attribute" and row.get("name"):
            name, value = str(row.get("name")), str(row.get("value", value)).strip()
        if value and len(value) <= MAX_VALUE:
            values.setdefault(name, []).append(value)
    return values


def parse_logout_ticket(text: str) -> str:
    """Return the ticket whose session has ended. Raises FederationRefused."""
    root = _parse_safe_xml(text.encode("utf-8", errors="replace"), MAX_LOGOUT)
    tickets = root.findall(f"{SAML}SessionIndex")
    if root.tag != f"{SAML}LogoutRequest" or len(tickets) != 1 or len(tickets[0]):
        raise FederationRefused("malformed", MALFORMED)
    ticket = (tickets[0].text or "").strip()
    if not is_service_ticket(ticket):
        raise FederationRefused("ticket", MALFORMED)
    return ticket


def _parse_safe_xml(content: bytes, max_bytes: int) -> Element:
    """Parse a document. It is read as UTF-8 whatever it declares, so that its declaration hides nothing."""
    from xml.etree.ElementTree import ParseError

    from defusedxml import ElementTree
    from defusedxml.common import DefusedXmlException

    if len(content) > max_bytes:
        raise FederationRefused("malformed", MALFORMED)
    try:
        root: Any = ElementTree.fromstring(content.decode("utf-8").strip(), forbid_dtd=True)
    except (ParseError, DefusedXmlException, ValueError) as error:
        raise FederationRefused("malformed", MALFORMED) from error
    if sum(1 for _ in root.iter()) > MAX_ELEMENTS:
        raise FederationRefused("malformed", MALFORMED)
    return root  # type: ignore[no-any-return]
