"""What is read of any request, whoever asks."""

from __future__ import annotations

import re
from collections.abc import Sequence
from ipaddress import IPv6Address, ip_address, ip_network

from starlette.requests import HTTPConnection

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
COOKIE = "balise_session"


UNKNOWN = "inconnue"
HOUSEHOLD = 64  # bits of an IPv6 address that are one subscriber's: the others are its own to choose


#: The weight by which `Accept-Encoding` says of an encoding that it is not taken.
REFUSED = re.compile(r"q=0(\.0*)?")


def encodings(header: str) -> Sequence[str]:
    """The encodings that an `Accept-Encoding` names and takes."""
    named = (one.lower().replace(" ", "").partition(";") for one in header.split(","))
    return [name for name, _, weight in named if name and not REFUSED.fullmatch(weight)]


def session_token(connection: HTTPConnection) -> str:
    """The session that a browser shows, or nothing. Of several the first: it is that of the nearest path, the others
    were set when the service stood elsewhere on its site."""
    pairs = (pair.partition("=") for pair in connection.headers.get("cookie", "").split(";"))
    return next((value.strip() for name, _, value in pairs if name.strip() == COOKIE), "")


def client_address(connection: HTTPConnection) -> str:
    """Whom the limits count as one visitor: an IPv4 address, or the network of an IPv6 one.

    It is what is at the other end, or what a trusted proxy says is behind it (`balise serve --trusted-proxy`).
    """
    return visitor_of(connection.client.host) if connection.client else UNKNOWN


def visitor_of(host: str) -> str:
    try:
        address = ip_address(host)
    except ValueError:
        return UNKNOWN
    if not isinstance(address, IPv6Address):
        return str(address)
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ip_network((int(address), HOUSEHOLD), strict=False))
