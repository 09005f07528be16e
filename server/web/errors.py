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

from server.base.app_services import provided_to
from server.base.errors import Away, Invalid, ServiceError
from server.base.http import TITLES, as_json, of_error, place, problem
from server.base.middleware import SECURITY_HEADERS, route_of
from server.database import Database, is_away
from server.identity.dependencies import load_session_account
from server.identity.models import Account
from server.web.rendering import page

log = logging.getLogger(__name__)

AWAY = (
    "La base de données ne répond pas en ce moment. Rien de ce qui était enregistré n’est perdu : réessayez dans "
    "quelques secondes."
)
AWAY_SECONDS = 2


def refusal(request: Request, error: ServiceError, account: Account | None = None) -> Response:
    return answer(request, of_error(request, error), error.headers, account)


def answer(
    request: Request, body: dict[str, Any], headers: Mapping[str, str] | None = None, account: Account | None = None
) -> Response:
    """The problem, in the form that fits who asks."""
    if request.url.path.startswith("/api/") or "application/json" in request.headers.get("accept", ""):
        return as_json(body, headers)
    context = {"code": body["status"], "title": body["title"], "detail": body["detail"]}
    return page(request, "error.html", account, status=body["status"], headers=headers, **context)


def _asker(request: Request) -> Account | None:
    return load_session_account(request, provided_to(request.app, Database))


def _service_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, ServiceError)
    return refusal(request, error, _asker(request))


def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    title, detail = TITLES.get(error.status_code, (HTTPStatus(error.status_code).phrase, str(error.detail)))
    body = problem(request, error.status_code, title, detail)
    return answer(request, body, error.headers, _asker(request))


def _validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    title, detail = TITLES[422]
    places = [place(fault) for fault in error.errors()]
    body = problem(request, 422, title, detail, slug=Invalid.slug, errors=places)
    return answer(request, body, None, _asker(request))


def _database_error(request: Request, error: Exception) -> Response:
    """That the database is away is told in a line, and to nobody by name: who asks is written there."""
    if isinstance(error, DBAPIError) and not is_away(error):
        raise error
    why = str(getattr(error, "orig", error)).partition("\n")[0]
    log.error("the database does not answer %s %s: %s", request.method, route_of(request.scope), why)
    return refusal(request, Away(AWAY, retry_after=AWAY_SECONDS))


def _unexpected(request: Request, error: Exception) -> Response:
    """Told by its route: addresses hold one-time links. No middleware adds anything to this answer."""
    log.error("unexpected error on %s %s", request.method, route_of(request.scope), exc_info=error)
    return answer(request, problem(request, 500, *TITLES[500]), SECURITY_HEADERS)


def install(app: FastAPI) -> None:
    app.add_exception_handler(ServiceError, _service_error)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(RequestValidationError, _validation_error)
    app.add_exception_handler(DBAPIError, _database_error)
    app.add_exception_handler(PoolTimeout, _database_error)
    app.add_exception_handler(Exception, _unexpected)
