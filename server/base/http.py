"""What this service reads of any HTTP request, the problem documents of its answers, and how it is served."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from ipaddress import IPv6Address, ip_address, ip_network
from typing import TYPE_CHECKING, Any

from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, Response
from starlette.types import ASGIApp

from server.base import root_path
from server.base.errors import InvalidFields, ServiceError
from server.base.validation import french_reason

if TYPE_CHECKING:
    import uvicorn


SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
SESSION_COOKIE = "balise_session"


UNKNOWN_ADDRESS = "inconnue"
IPV6_NETWORK_BITS = 64  # bits of an IPv6 address that are one subscriber's: the others are its own to choose


#: The weight by which `Accept-Encoding` says of an encoding that it is not taken.
REFUSED = re.compile(r"q=0(\.0*)?")


def accepted_encodings(header: str) -> Sequence[str]:
    """The encodings that an `Accept-Encoding` names and takes."""
    named = (one.lower().replace(" ", "").partition(";") for one in header.split(","))
    return [name for name, _, weight in named if name and not REFUSED.fullmatch(weight)]


def session_token(connection: HTTPConnection) -> str:
    """The session that a browser shows, or nothing. Of several the first: it is that of the nearest path, the others
    were set when the service stood elsewhere on its site."""
    pairs = (pair.partition("=") for pair in connection.headers.get("cookie", "").split(";"))
    return next((value.strip() for name, _, value in pairs if name.strip() == SESSION_COOKIE), "")


def client_address(connection: HTTPConnection) -> str:
    """Whom the limits count as one visitor: an IPv4 address, or the network of an IPv6 one.

    It is what is at the other end, or what a trusted proxy says is behind it (`balise serve --trusted-proxy`).
    """
    return visitor_key(connection.client.host) if connection.client else UNKNOWN_ADDRESS


def visitor_key(host: str) -> str:
    try:
        address = ip_address(host)
    except ValueError:
        return UNKNOWN_ADDRESS
    if not isinstance(address, IPv6Address):
        return str(address)
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ip_network((int(address), IPV6_NETWORK_BITS), strict=False))


PROBLEM_TYPE = "urn:balise:probleme:"
TITLES = {
    400: ("Demande illisible", "Cette demande ne peut pas être lue."),
    404: ("Introuvable", "Il n’y a rien à cette adresse."),
    405: ("Méthode refusée", "Cette adresse n’accepte pas cette méthode."),
    422: ("Données refusées", "Les données envoyées ne conviennent pas."),
    500: ("Erreur du serveur", "Une erreur est survenue de notre côté ; elle a été notée. Votre travail est conservé."),
}


def problem_document(
    request: Request, status: int, title: str, detail: str, *, slug: str = "", **members: Any
) -> dict[str, Any]:
    """The members of a problem document; extension members are added as they are."""
    kind = PROBLEM_TYPE + slug if slug else "about:blank"
    told = {"type": kind, "title": title, "status": status, "detail": _sendable(detail)}
    return {**told, "instance": root_path.external_path(request.url.path), **members}


def _sendable(text: str) -> str:
    """A lone surrogate of the request's cannot be sent back."""
    return text.encode("utf-8", "replace").decode()


def error_document(request: Request, error: ServiceError) -> dict[str, Any]:
    members: dict[str, Any] = {}
    if isinstance(error, InvalidFields):
        told = error.problems.items()
        members["errors"] = [{"detail": _sendable(why), "pointer": _pointer(field.split("/"))} for field, why in told]
    return problem_document(request, int(error.status), error.title, error.detail, slug=error.slug, **members)


def problem_response(body: dict[str, Any], headers: Mapping[str, str] | None = None) -> Response:
    return JSONResponse(body, body["status"], dict(headers or {}), "application/problem+json")


def error_location(error: Mapping[str, Any]) -> dict[str, Any]:
    """Where and why: a JSON pointer in the body, or the name of a parameter."""
    source, *path = error["loc"]
    detail = french_reason(error)
    if source == "body":
        return {"detail": detail, "pointer": _pointer([] if error["type"] == "json_invalid" else path)}
    return {"detail": detail, "parameter": ".".join(str(part) for part in path)}


def _pointer(path: Sequence[object]) -> str:
    return "#" + "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in path)


#: Bytes of a request without its body; and of what comes without anything of a body, or a request, being ended by it.
MAX_HEAD_BYTES = 64 * 1024


def uvicorn_config(app: ASGIApp, *, grace: int, proxies: Sequence[str] = ()) -> uvicorn.Config:
    """How the application is served. `grace`: seconds left to open connections when it stops; `proxies`: whose word is
    taken for where a request comes from.

    Parser and loop are said, whatever is installed. That of httptools passes the body of a request that asks for an
    upgrade on as the next request, and bounds nothing; the loop of uvloop starts no process in a group of its own, and
    leaves those that it starts descriptors which are not theirs.
    """
    import uvicorn

    return uvicorn.Config(
        app,
        loop="asyncio",
        http="h11",
        h11_max_incomplete_event_size=MAX_HEAD_BYTES,
        ws="none",
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=grace,
        server_header=False,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=list(proxies),
    )
