"""Errors as answers: RFC 9457 problem documents under /api and for whoever asks for JSON, pages in French elsewhere."""

import logging
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from server.base.errors import Invalid, ServiceError
from server.identity.dependencies import current_account
from server.identity.models import Account

log = logging.getLogger(__name__)

PROBLEM_TYPE = "urn:balise:probleme:"
TITLES = {
    400: ("Demande illisible", "Cette demande ne peut pas être lue."),
    404: ("Introuvable", "Il n’y a rien à cette adresse."),
    405: ("Méthode refusée", "Cette adresse n’accepte pas cette méthode."),
    422: ("Données refusées", "Les données envoyées ne conviennent pas."),
    500: ("Erreur du serveur", "Une erreur est survenue de notre côté ; elle a été notée. Votre travail est conservé."),
}
VALIDATION = {
    "missing": "valeur manquante",
    "string_type": "une chaîne de caractères est attendue",
    "extra_forbidden": "nom inconnu",
    "json_invalid": "JSON mal formé",
    "model_attributes_type": "un objet est attendu",
    "float_parsing": "un nombre est attendu",
    "finite_number": "un nombre fini est attendu",
    "greater_than_equal": "valeur trop petite",
    "literal_error": "valeur inconnue",
    "enum": "valeur inconnue",
}


def problem(
    request: Request, status: int, title: str, detail: str, *, slug: str = "", **members: Any
) -> dict[str, Any]:
    """The members of a problem document; extension members are added as they are."""
    kind = PROBLEM_TYPE + slug if slug else "about:blank"
    detail = detail.encode("utf-8", "replace").decode()  # a lone surrogate of the request's cannot be sent back
    return {
        "type": kind, "title": title, "status": status, "detail": detail, "instance": request.url.path, **members
    }  # fmt: skip


def refusal(request: Request, error: ServiceError, account: Account | None = None) -> Response:
    body = problem(request, int(error.status), error.title, error.detail, slug=error.slug)
    return answer(request, body, error.headers, account)


def answer(
    request: Request, body: dict[str, Any], headers: Mapping[str, str] | None = None, account: Account | None = None
) -> Response:
    """The problem, in the form that fits who asks."""
    if request.url.path.startswith("/api/") or "application/json" in request.headers.get("accept", ""):
        return JSONResponse(body, body["status"], dict(headers or {}), "application/problem+json")
    from server.web.rendering import page

    shown = {"code": body["status"], "title": body["title"], "detail": body["detail"]}
    return page(request, "error.html", account, status=body["status"], headers=headers, **shown)


def _service_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, ServiceError)
    return refusal(request, error, current_account(request))


def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    title, detail = TITLES.get(error.status_code, (HTTPStatus(error.status_code).phrase, str(error.detail)))
    body = problem(request, error.status_code, title, detail)
    return answer(request, body, error.headers, current_account(request))


def _validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    title, detail = TITLES[422]
    places = [_place(one) for one in error.errors()]
    body = problem(request, 422, title, detail, slug=Invalid.slug, errors=places)
    return answer(request, body, None, current_account(request))


def _place(error: Mapping[str, Any]) -> dict[str, Any]:
    """Where and why: a JSON pointer in the body, or the name of a parameter."""
    source, *path = error["loc"]
    detail = VALIDATION.get(error["type"], "valeur refusée")
    if source == "body":
        return {"detail": detail, "pointer": _pointer([] if error["type"] == "json_invalid" else path)}
    return {"detail": detail, "parameter": ".".join(str(part) for part in path)}


def _pointer(path: Sequence[object]) -> str:
    return "#" + "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in path)


def _unexpected(request: Request, error: Exception) -> Response:
    log.error("unexpected error on %s %s", request.method, request.url.path, exc_info=error)
    return answer(request, problem(request, 500, *TITLES[500]))


def install(app: FastAPI) -> None:
    app.add_exception_handler(ServiceError, _service_error)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(RequestValidationError, _validation_error)
    app.add_exception_handler(Exception, _unexpected)
