"""Errors as answers: problem documents under /api and for whoever asks for JSON, pages in French elsewhere."""

import logging
from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from server.base.app_services import get_service
from server.base.errors import Invalid, ServiceError, StorageFull, TooLarge, Unavailable
from server.base.forms import TOO_MANY_FIELDS
from server.base.http import TITLES, error_document, error_location, problem_document, problem_response
from server.base.middleware import route_path
from server.base.security_headers import SECURITY_HEADERS
from server.database import Database, is_storage_full, is_unavailable
from server.identity.dependencies import load_session_account
from server.identity.models import Account
from server.web.form_identity import FormRefusal, referring_page, refusal_context, refusal_members
from server.web.rendering import render_page

log = logging.getLogger(__name__)

AWAY = (
    "La base de données ne répond pas en ce moment. Rien de ce qui était enregistré n’est perdu : réessayez dans "
    "quelques secondes."
)
AWAY_SECONDS = 2
FULL = (
    "Le disque du serveur est plein : ce que vous venez d’envoyer n’est pas enregistré. Gardez-le, et renvoyez-le dans "
    "quelques minutes ; prévenez la personne qui administre ce serveur."
)
FULL_SECONDS = 60


def error_response(request: Request, error: ServiceError, account: Account | None = None) -> Response:
    return problem_answer(request, error_document(request, error), error.headers, account)


def wants_json(request: Request) -> bool:
    return request.url.path.startswith("/api/") or "application/json" in request.headers.get("accept", "")


def problem_answer(
    request: Request, body: dict[str, Any], headers: Mapping[str, str] | None = None, account: Account | None = None
) -> Response:
    """The problem, in the form that fits who asks."""
    if wants_json(request):
        return problem_response(body, headers)
    context = {"code": body["status"], "title": body["title"], "detail": body["detail"]}
    context["form_page"] = "/" if request.method == "GET" else referring_page(request)
    return render_page(request, "error.html", account, status=body["status"], headers=headers, **context)


def _asker(request: Request) -> Account | None:
    return load_session_account(request, get_service(request.app, Database))


def _form_refusal(request: Request, error: Exception) -> Response:
    """What was typed, and the ways to go on; programs get the problem document."""
    assert isinstance(error, FormRefusal)
    if wants_json(request):
        document = {**error_document(request, error), **refusal_members(request, error)}
        return problem_response(document, error.headers)
    context = refusal_context(request, error)
    return render_page(request, "resend.html", error.account, status=int(error.status), **context)


def _service_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, ServiceError)
    return error_response(request, error, _asker(request))


def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    if error.status_code == HTTPStatus.BAD_REQUEST and str(error.detail).startswith("Too many f"):
        return _service_error(request, TooLarge(TOO_MANY_FIELDS))
    title, detail = TITLES.get(error.status_code, (HTTPStatus(error.status_code).phrase, str(error.detail)))
    body = problem_document(request, error.status_code, title, detail)
    return problem_answer(request, body, error.headers, _asker(request))


def _validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    title, detail = TITLES[422]
    places = [error_location(fault) for fault in error.errors()]
    body = problem_document(request, 422, title, detail, slug=Invalid.slug, errors=places)
    return problem_answer(request, body, None, _asker(request))


def _database_error(request: Request, error: Exception) -> Response:
    """Refuse for a while where the database is away or its disk is full; the log names nobody."""
    why = str(getattr(error, "orig", error)).partition("\n")[0]
    if isinstance(error, DBAPIError) and is_storage_full(error):
        log.error("the database cannot write for %s %s: %s", request.method, route_path(request.scope), why)
        return error_response(request, StorageFull(FULL, retry_after=FULL_SECONDS))
    if isinstance(error, DBAPIError) and not is_unavailable(error):
        raise error
    log.error("the database does not answer %s %s: %s", request.method, route_path(request.scope), why)
    return error_response(request, Unavailable(AWAY, retry_after=AWAY_SECONDS))


def _unexpected(request: Request, error: Exception) -> Response:
    """Told by its route: addresses hold one-time links. No middleware adds anything to this answer."""
    log.error("unexpected error on %s %s", request.method, route_path(request.scope), exc_info=error)
    return problem_answer(request, problem_document(request, 500, *TITLES[500]), SECURITY_HEADERS)


def install_error_handlers(app: FastAPI) -> None:
    app.add_exception_handler(FormRefusal, _form_refusal)
    app.add_exception_handler(ServiceError, _service_error)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(RequestValidationError, _validation_error)
    app.add_exception_handler(DBAPIError, _database_error)
    app.add_exception_handler(PoolTimeout, _database_error)
    app.add_exception_handler(Exception, _unexpected)
