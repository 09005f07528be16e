"""Sign-in by CAS: the address to which a browser goes, and the question whether its ticket is valid.

The service's address has the state of the sign-in, so that a ticket is valid for the browser that asked for it alone.
"""

from __future__ import annotations

from urllib.parse import urlencode

from server.federation.cas.messages import (
    MAX_ANSWER,
    USED_TICKET,
    CasPerson,
    is_service_ticket,
    parse_validation_answer,
)
from server.federation.errors import FederationRefused
from server.federation.outgoing import Outgoing


def login_url(server: str, service: str) -> str:
    """Return the address at which a person signs in, and is led back to `service`."""
    return f"{server.rstrip('/')}/login?{urlencode({'service': service})}"


def validation_url(server: str, ticket: str, service: str) -> str:
    """Return the address that says whose ticket this is."""
    return f"{server.rstrip('/')}/p3/serviceValidate?{urlencode({'service': service, 'ticket': ticket})}"


def validate_ticket(outgoing: Outgoing, server: str, ticket: str, service: str) -> CasPerson:
    """Ask the server whose ticket this is: it answers once. Raises FederationRefused or OutgoingError."""
    if not is_service_ticket(ticket):
        raise FederationRefused("ticket", USED_TICKET)
    url = validation_url(server, ticket, service)
    return parse_validation_answer(
        outgoing.request("GET", url, most=MAX_ANSWER, accept="application/xml, text/xml").content
    )
