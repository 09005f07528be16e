"""What this service reads of any HTTP request, the problem documents of its answers, and how it is served."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from ipaddress import IPv6Address, ip_address, ip_network
from typing import Any
from urllib.parse import SplitResult, urlsplit

from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, Response

from server.base import root_path
from server.base.errors import InvalidFields, ServiceError
from server.base.validation import french_reason

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
API = "/api/"
#: Who asks there watches the service, and is no visitor.
MONITORING_PATHS = frozenset({"/healthz", "/readyz", "/metrics", "/statusz"})
#: Where platforms of schools have a browser send a form of theirs, which proves itself (LTI).
LTI_BEGIN_PATH, LTI_LAUNCH_PATH = "/lti/connexion", "/lti/lancement"
LAUNCH_PATHS = frozenset({LTI_BEGIN_PATH, LTI_LAUNCH_PATH})
SESSION_COOKIE = "balise_session"
DEVICE_COOKIE = "balise_device"
#: The session of a page that another site's page shows in a frame, where a browser does not send the other one.
FRAMED_COOKIE = "balise_cadre"


UNKNOWN_ADDRESS = "inconnue"
IPV6_NETWORK_BITS = 64  # bits: a subscriber has a whole /64 network


#: The weight of a refused encoding in `Accept-Encoding`.
REFUSED_WEIGHT = re.compile(r"q=0(\.0*)?")


def accepted_encodings(header: str) -> Sequence[str]:
    """Return the encodings that an `Accept-Encoding` header accepts by name."""
    named = (part.lower().replace(" ", "").partition(";") for part in header.split(","))
    return [name for name, _, weight in named if name and not REFUSED_WEIGHT.fullmatch(weight)]


def session_token(connection: HTTPConnection) -> str:
    """Return the token of the session cookie, else of a frame's, or an empty string."""
    return cookie_value(connection, SESSION_COOKIE) or framed_token(connection)


def framed_token(connection: HTTPConnection) -> str:
    """Return the token of the session of a frame, or an empty string."""
    return cookie_value(connection, FRAMED_COOKIE)


def is_framed_session(connection: HTTPConnection) -> bool:
    """Whether the session of this request is that of a frame."""
    return not cookie_value(connection, SESSION_COOKIE) and bool(framed_token(connection))


def device_token(connection: HTTPConnection) -> str:
    """Return the token by which this browser is recognised at a log-in, or an empty string."""
    return cookie_value(connection, DEVICE_COOKIE)


def bearer_token(connection: HTTPConnection) -> str:
    """Return the token of the `Authorization` header, or an empty string."""
    scheme, _, token = connection.headers.get("authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else ""


def cookie_value(connection: HTTPConnection, cookie: str) -> str:
    """Return the first of several: browsers send the cookie of the longest path first, the others are of an earlier
    root path."""
    pairs = (pair.partition("=") for pair in connection.headers.get("cookie", "").split(";"))
    return next((value.strip() for name, _, value in pairs if name.strip() == cookie), "")


def client_address(connection: HTTPConnection) -> str:
    """Return the key of a visitor for the rate limits: the peer's address, or that which a trusted proxy forwards."""
    return visitor_key(connection.client.host) if connection.client else UNKNOWN_ADDRESS


def visitor_key(host: str) -> str:
    """Return an IPv4 address, or the /64 network of an IPv6 address."""
    try:
        address = ip_address(host)
    except ValueError:
        return UNKNOWN_ADDRESS
    if not isinstance(address, IPv6Address):
        return str(address)
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ip_network((int(address), IPV6_NETWORK_BITS), strict=False))


#: Characters of a path of this site to go to, more than the longest has.
MAX_ADDRESS = 2000


def split_address(address: str) -> SplitResult:
    """Return the parts of an address that somebody has written: empty ones where it is none (`http://[`)."""
    try:
        return urlsplit(address)
    except ValueError:
        return urlsplit("")


def local_path(address: str) -> str:
    """Return a path of this site to go to afterwards: the address itself, or `/` where it is of another site."""
    parts = split_address(address)
    safe = address.startswith("/") and not address.startswith(("//", "/\\")) and not parts.netloc
    return address if safe and address.isprintable() else "/"


PROBLEM_TYPE = "urn:balise:probleme:"
TITLES = {
    400: ("Demande illisible", "Cette demande ne peut pas être lue."),
    404: ("Introuvable", "Il n’y a rien à cette adresse."),
    405: ("Méthode refusée", "Cette adresse n’accepte pas cette méthode."),
    422: ("Données refusées", "Les données envoyées ne conviennent pas."),
    500: (
        "Erreur du serveur",
        "Une erreur est survenue de notre côté ; elle a été notée. Si vous veniez d’envoyer quelque chose, vérifiez "
        "que c’est bien enregistré.",
    ),
}


def problem_document(
    request: Request, status: int, title: str, detail: str, *, slug: str = "", **members: Any
) -> dict[str, Any]:
    """Return a problem document (RFC 9457) with these extension members."""
    kind = PROBLEM_TYPE + slug if slug else "about:blank"
    document = {"type": kind, "title": title, "status": status, "detail": _replace_lone_surrogates(detail)}
    return {**document, "instance": root_path.external_path(request.url.path), **members}


def _replace_lone_surrogates(text: str) -> str:
    """Replace lone surrogates, which a request may hold and JSON in UTF-8 cannot."""
    return text.encode("utf-8", "replace").decode()


def error_document(request: Request, error: ServiceError) -> dict[str, Any]:
    """Return the problem document of an error."""
    members: dict[str, Any] = {}
    if isinstance(error, InvalidFields):
        members["errors"] = [
            {"detail": _replace_lone_surrogates(why), "pointer": _json_pointer(field.split("/"))}
            for field, why in error.problems.items()
        ]
    return problem_document(request, int(error.status), error.title, error.detail, slug=error.slug, **members)


def problem_response(body: dict[str, Any], headers: Mapping[str, str] | None = None) -> Response:
    return JSONResponse(body, body["status"], dict(headers or {}), "application/problem+json")


def error_location(error: Mapping[str, Any]) -> dict[str, Any]:
    """Return the reason of one pydantic error, with its JSON pointer in the body or the name of its parameter."""
    source, *path = error["loc"]
    detail = french_reason(error)
    if source == "body":
        return {"detail": detail, "pointer": _json_pointer([] if error["type"] == "json_invalid" else path)}
    return {"detail": detail, "parameter": ".".join(str(part) for part in path)}


def _json_pointer(path: Sequence[object]) -> str:
    return "#" + "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in path)
