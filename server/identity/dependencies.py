"""Dependencies that authenticate a request, each in a short transaction, and return a detached account."""

from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import Depends, Request, Response, Security
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.app_services import app_service, get_service
from server.base.counters import REFUSED_LOGINS
from server.base.errors import Unauthorised
from server.base.http import client_address, framed_token, is_framed_session, session_token
from server.base.security_headers import FRAMES_STATE
from server.database import Database
from server.database.dependencies import DatabaseOf
from server.identity import service, tokens
from server.identity.models import Account
from server.identity.opened_sessions import OpenedSession, frames_of_session
from server.identity.service import AccountService

_bearer = HTTPBearer(
    auto_error=False,
    description="Un jeton créé sur la page « Mon compte », avec le mot de passe. Il prend fin avec lui ; seul, il "
    "n’efface pas le compte, ne change pas le mot de passe et ne crée pas de jeton.",
)

AccountServiceOf = Annotated[AccountService, Depends(app_service(AccountService))]


def set_session_cookie(request: Request, opened: OpenedSession) -> None:
    """Set the cookies of a new session on the response (by `server.base.middleware.SessionCookieMiddleware`)."""
    if opened.is_framed:
        request.state.framed_token = opened.token
        request.state.session_token = ""
        return
    request.state.session_token = opened.token
    if framed_token(request):
        request.state.framed_token = ""
    if opened.device:
        request.state.device_token = opened.device


def clear_session_cookie(request: Request) -> None:
    request.state.session_token = ""
    if framed_token(request):
        request.state.framed_token = ""


def load_session_account(request: Request, database: Database) -> Account | None:
    """Return the account of the browser's session, if any; no guest is created."""
    if not session_token(request):
        return None
    with database.read() as db:
        return load_session_account_in(db, request)


def load_session_account_in(db: Session, request: Request) -> Account | None:
    """Return the account of the browser's session within an open read transaction.

    The answer to a session of a frame may be shown by the platform that opened it.
    """
    token = session_token(request)
    if token and is_framed_session(request):
        setattr(request.state, FRAMES_STATE, frames_of_session(db, token))
    return service.find_account_by_session_token(db, token) if token else None


def _optional_account(request: Request, database: DatabaseOf) -> Account | None:
    return load_session_account(request, database)


OptionalAccount = Annotated[Account | None, Depends(_optional_account)]


def account_or_guest(request: Request, account: OptionalAccount, accounts: AccountServiceOf) -> Account:
    """Return the account of the browser's session; a visitor without one becomes a guest."""
    if account is not None:
        return account
    opened = accounts.create_guest(client_address(request))
    set_session_cookie(request, opened)
    return opened.account


BrowserAccount = Annotated[Account, Depends(account_or_guest)]


def _require_signed_in(account: OptionalAccount) -> Account:
    if account is None:
        raise Unauthorised("Connectez-vous d’abord.")
    return account


SignedIn = Annotated[Account, Depends(_require_signed_in)]


async def _bearer_token(credentials: Annotated[HTTPAuthorizationCredentials | None, Security(_bearer)]) -> str:
    if credentials is None:
        raise Unauthorised("Un jeton est attendu dans l’en-tête « Authorization: Bearer … ».")
    return credentials.credentials


#: The token of the request, for routes that call `account_of_token` in a worker thread of their own.
BearerToken = Annotated[str, Depends(_bearer_token)]


def account_of_token(token: BearerToken, database: DatabaseOf) -> Account:
    """Return the owner of a token. Raises Unauthorised."""
    account = tokens.find_token_owner(database, token)
    if account is None:
        REFUSED_LOGINS.add("token")
        raise Unauthorised("Ce jeton n’est pas valable, n’est plus valable ou a été révoqué.")
    return account


ApiAccount = Annotated[Account, Depends(account_of_token)]


class TokenFirstRoute(APIRoute):
    """A route with a `BearerToken` that checks the token before it reports validation errors of the request."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        handle = super().get_route_handler()

        async def authenticate_first(request: Request) -> Response:
            try:
                return await handle(request)
            except RequestValidationError:
                token = await _bearer_token(await _bearer(request))
                await run_in_threadpool(account_of_token, token, get_service(request.app, Database))
                raise

        return authenticate_first
