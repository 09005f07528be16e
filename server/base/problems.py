"""Problem documents (RFC 9457): what an error tells a program."""

from collections.abc import Mapping, Sequence
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from server.base import root
from server.base.errors import FieldsRefused, ServiceError
from server.base.refused import reason

PROBLEM_TYPE = "urn:balise:probleme:"
TITLES = {
    400: ("Demande illisible", "Cette demande ne peut pas être lue."),
    404: ("Introuvable", "Il n’y a rien à cette adresse."),
    405: ("Méthode refusée", "Cette adresse n’accepte pas cette méthode."),
    422: ("Données refusées", "Les données envoyées ne conviennent pas."),
    500: ("Erreur du serveur", "Une erreur est survenue de notre côté ; elle a été notée. Votre travail est conservé."),
}


def problem(
    request: Request, status: int, title: str, detail: str, *, slug: str = "", **members: Any
) -> dict[str, Any]:
    """The members of a problem document; extension members are added as they are."""
    kind = PROBLEM_TYPE + slug if slug else "about:blank"
    told = {"type": kind, "title": title, "status": status, "detail": _sendable(detail)}
    return {**told, "instance": root.address(request.url.path), **members}


def _sendable(text: str) -> str:
    """A lone surrogate of the request's cannot be sent back."""
    return text.encode("utf-8", "replace").decode()


def of_error(request: Request, error: ServiceError) -> dict[str, Any]:
    members: dict[str, Any] = {}
    if isinstance(error, FieldsRefused):
        told = error.problems.items()
        members["errors"] = [{"detail": _sendable(why), "pointer": _pointer(field.split("/"))} for field, why in told]
    return problem(request, int(error.status), error.title, error.detail, slug=error.slug, **members)


def as_json(body: dict[str, Any], headers: Mapping[str, str] | None = None) -> Response:
    return JSONResponse(body, body["status"], dict(headers or {}), "application/problem+json")


def place(error: Mapping[str, Any]) -> dict[str, Any]:
    """Where and why: a JSON pointer in the body, or the name of a parameter."""
    source, *path = error["loc"]
    detail = reason(error)
    if source == "body":
        return {"detail": detail, "pointer": _pointer([] if error["type"] == "json_invalid" else path)}
    return {"detail": detail, "parameter": ".".join(str(part) for part in path)}


def _pointer(path: Sequence[object]) -> str:
    return "#" + "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in path)
