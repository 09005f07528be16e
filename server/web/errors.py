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
from server.web.form_identity import FormRefusal, build_refusal_context, referring_page_path, refusal_problem_members
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


def render_service_error(request: Request, error: ServiceError, account: Account | None = None) -> Response:
    return render_problem_document(request, error_document(request, error), error.headers, account)


def does_client_want_json(request: Request) -> bool:
    return request.url.path.startswith("/api/") or "application/json" in request.headers.get("accept", "")


def render_problem_document(
    request: Request, body: dict[str, Any], headers: Mapping[str, str] | None = None, account: Account | None = None
) -> Response:
    """The problem, in the form that fits who asks."""
    if does_client_want_json(request):
        return problem_response(body, headers)
    context = {"code": body["status"], "title": body["title"], "detail": body["detail"]}
    context["form_page"] = "/" if request.method == "GET" else referring_page_path(request)
    return render_page(request, "error.html", account, status=body["status"], headers=headers, **context)


def _load_account_of_request(request: Request) -> Account | None:
    return load_session_account(request, get_service(request.app, Database))


def _handle_form_refusal(request: Request, error: Exception) -> Response:
    """What was typed, and the ways to go on; programs get the problem document."""
    assert isinstance(error, FormRefusal)
    if does_client_want_json(request):
        document = {**error_document(request, error), **refusal_problem_members(request, error)}
        return problem_response(document, error.headers)
    context = build_refusal_context(request, error)
    return render_page(request, "resend.html", error.account, status=int(error.status), **context)


def _handle_service_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, ServiceError)
    return render_service_error(request, error, _load_account_of_request(request))


def _handle_http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    if error.status_code == HTTPStatus.BAD_REQUEST and str(error.detail).startswith("Too many f"):
        return _handle_service_error(request, TooLarge(TOO_MANY_FIELDS))
    title, detail = TITLES.get(error.status_code, (HTTPStatus(error.status_code).phrase, str(error.detail)))
    body = problem_document(request, error.status_code, title, detail)
    return render_problem_document(request, body, error.headers, _load_account_of_request(request))


def _handle_validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    title, detail = TITLES[422]
    places = [error_location(fault) for fault in error.errors()]
    body = problem_document(request, 422, title, detail, slug=Invalid.slug, errors=places)
    return render_problem_document(request, body, None, _load_account_of_request(request))


def _handle_database_error(request: Request, error: Exception) -> Response:
    """Refuse for a while where the database is away or its disk is full; the log names nobody."""
    why = str(getattr(error, "orig", error)).partition("\n")[0]
    if isinstance(error, DBAPIError) and is_storage_full(error):
        log.error("the database cannot write for %s %s: %s", request.method, route_path(request.scope), why)
        return render_service_error(request, StorageFull(FULL, retry_after=FULL_SECONDS))
    if isinstance(error, DBAPIError) and not is_unavailable(error):
        raise error
    log.error("the database does not answer %s %s: %s", request.method, route_path(request.scope), why)
    return render_service_error(request, Unavailable(AWAY, retry_after=AWAY_SECONDS))


def _handle_unexpected_error(request: Request, error: Exception) -> Response:
    """Told by its route: addresses hold one-time links. No middleware adds anything to this answer."""
    log.error("unexpected error on %s %s", request.method, route_path(request.scope), exc_info=error)
    return render_problem_document(request, problem_document(request, 500, *TITLES[500]), SECURITY_HEADERS)


def install_error_handlers(app: FastAPI) -> None:
    app.add_exception_handler(FormRefusal, _handle_form_refusal)
    app.add_exception_handler(ServiceError, _handle_service_error)
    app.add_exception_handler(HTTPException, _handle_http_error)
    app.add_exception_handler(RequestValidationError, _handle_validation_error)
    app.add_exception_handler(DBAPIError, _handle_database_error)
    app.add_exception_handler(PoolTimeout, _handle_database_error)
    app.add_exception_handler(Exception, _handle_unexpected_error)
