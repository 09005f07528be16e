"""Pages of one's account: sign up, log in, log out, API tokens, one-time link."""

from typing import Annotated, Any
from urllib.parse import urlsplit
from uuid import UUID

from fastapi import APIRouter, Form, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from server.base.errors import Unauthorised
from server.base.request import COOKIE, client_address
from server.database.dependencies import Db
from server.identity import service
from server.identity.dependencies import AccountsOf, OptionalAccount, forget, remember
from server.identity.models import Account
from server.identity.schemas import RefusedForm, new_account
from server.web.rendering import page

router = APIRouter(include_in_schema=False)

Field = Annotated[str, Form()]
SEE_OTHER = 303


def _form(
    request: Request, template: str, account: Account | None, refused: RefusedForm | None = None, **context: Any
) -> HTMLResponse:
    problems = refused.problems if refused else {}
    values = {"name": "", "login": "", "after": "/", **context}
    return page(request, f"accounts/{template}", account, status=422 if refused else 200, problems=problems, **values)


def _local(address: str) -> str:
    """Where to go afterwards: a path of this site, whatever was asked for."""
    parts = urlsplit(address)
    safe = address.startswith("/") and not address.startswith(("//", "/\\")) and not parts.netloc
    return address if safe and address.isprintable() else "/"


def _go(address: str) -> RedirectResponse:
    return RedirectResponse(address, SEE_OTHER)


@router.get("/inscription")
def sign_up_form(request: Request, account: OptionalAccount, suite: str = "/") -> HTMLResponse:
    return _form(request, "inscription.html", account, after=_local(suite))


@router.post("/inscription")
def sign_up(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    name: Field = "",
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
) -> Response:
    try:
        wanted = new_account(name, login, password)
        opened = accounts.sign_up(wanted, visitor=account)
    except RefusedForm as refused:
        return _form(request, "inscription.html", account, refused, name=name, login=login, after=_local(suite))
    remember(request, opened)
    return _go(_local(suite))


@router.get("/bienvenue/{token}")
def welcome_form(request: Request, account: OptionalAccount, db: Db, token: str) -> HTMLResponse:
    service.check_invitation(db, token)
    return _form(request, "bienvenue.html", account)


@router.post("/bienvenue/{token}")
def welcome(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    token: str,
    name: Field = "",
    login: Field = "",
    password: Field = "",
) -> Response:
    try:
        wanted = new_account(name, login, password)
        opened = accounts.sign_up(wanted, visitor=account, invitation=token)
    except RefusedForm as refused:
        return _form(request, "bienvenue.html", account, refused, name=name, login=login)
    remember(request, opened)
    return _go("/")


@router.get("/connexion")
def log_in_form(request: Request, account: OptionalAccount, suite: str = "/") -> HTMLResponse:
    return _form(request, "connexion.html", account, after=_local(suite))


@router.post("/connexion")
def log_in(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
) -> Response:
    try:
        opened = accounts.log_in(login, password, visitor=account, address=client_address(request))
    except RefusedForm as refused:
        return _form(request, "connexion.html", account, refused, login=login, after=_local(suite))
    remember(request, opened)
    return _go(_local(suite))


@router.post("/deconnexion")
def log_out(request: Request, db: Db) -> Response:
    service.close_session(db, request.cookies.get(COOKIE, ""))
    forget(request)
    return _go("/")


def _signed_in(account: Account | None) -> Account:
    if account is None:
        raise Unauthorised("Connectez-vous d’abord.")
    return account


@router.get("/compte")
def account_page(request: Request, account: OptionalAccount, db: Db) -> Response:
    if account is None:
        return _go("/connexion?suite=/compte")
    return _account_page(request, account, db)


def _account_page(
    request: Request, account: Account, db: Db, secret: str | None = None, refused: RefusedForm | None = None
) -> HTMLResponse:
    tokens = service.api_tokens(db, account)
    return _form(request, "compte.html", account, refused, person=account, tokens=tokens, secret=secret)


@router.post("/compte/jetons")
def create_token(request: Request, account: OptionalAccount, db: Db, label: Field = "") -> Response:
    person = _signed_in(account)
    try:
        _, secret = service.new_api_token(db, person, label)
    except RefusedForm as refused:
        return _account_page(request, person, db, refused=refused)
    return _account_page(request, person, db, secret=secret)


@router.post("/compte/jetons/{token_id}/revoquer")
def revoke_token(account: OptionalAccount, db: Db, token_id: UUID) -> Response:
    service.revoke_api_token(db, _signed_in(account), token_id)
    return _go("/compte")
