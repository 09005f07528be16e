"""Pages by which one comes and goes: sign up, log in, log out, one-time links."""

from fastapi import Request
from fastapi.responses import HTMLResponse, Response
from starlette.concurrency import run_in_threadpool

from server.base.request import client_address, session_token
from server.base.routing import Room
from server.database.dependencies import Db
from server.identity import links, service
from server.identity.dependencies import AccountsOf, OptionalAccount, forget, remember
from server.identity.models import Account
from server.identity.schemas import RefusedForm, new_account
from server.identity.service import Accounts, Opened
from server.web.forms import Field, form, go, local

router = Room(include_in_schema=False)


@router.get("/inscription")
def sign_up_form(request: Request, account: OptionalAccount, suite: str = "/") -> HTMLResponse:
    return form(request, "inscription.html", account, after=local(suite))


@router.post("/inscription")
async def sign_up(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    name: Field = "",
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
) -> Response:
    try:
        opened = await _opened(request, accounts, account, (name, login, password))
    except RefusedForm as refused:
        return form(request, "inscription.html", account, refused, name=name, login=login, after=local(suite))
    remember(request, opened)
    return go(local(suite))


async def _opened(
    request: Request,
    accounts: Accounts,
    visitor: Account | None,
    fields: tuple[str, str, str],
    invitation: str | None = None,
) -> Opened:
    wanted = await run_in_threadpool(new_account, *fields)
    return await accounts.sign_up(wanted, visitor=visitor, address=client_address(request), invitation=invitation)


@router.get("/bienvenue/{token}")
def welcome_form(request: Request, account: OptionalAccount, db: Db, token: str) -> HTMLResponse:
    links.check_invitation(db, token)
    return form(request, "bienvenue.html", account)


@router.post("/bienvenue/{token}")
async def welcome(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    token: str,
    name: Field = "",
    login: Field = "",
    password: Field = "",
) -> Response:
    try:
        opened = await _opened(request, accounts, account, (name, login, password), token)
    except RefusedForm as refused:
        return form(request, "bienvenue.html", account, refused, name=name, login=login)
    remember(request, opened)
    return go("/")


@router.get("/connexion")
def log_in_form(request: Request, account: OptionalAccount, suite: str = "/") -> HTMLResponse:
    return form(request, "connexion.html", account, after=local(suite))


@router.post("/connexion")
async def log_in(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
) -> Response:
    try:
        opened = await accounts.log_in(login, password, visitor=account, address=client_address(request))
    except RefusedForm as refused:
        return form(request, "connexion.html", account, refused, login=login, after=local(suite))
    remember(request, opened)
    return go(local(suite))


@router.get("/nouveau-mot-de-passe/{token}")
def new_password_form(request: Request, account: OptionalAccount, db: Db, token: str) -> HTMLResponse:
    return form(request, "nouveau_mot_de_passe.html", account, login=links.owner(db, token).login)


@router.post("/nouveau-mot-de-passe/{token}")
async def new_password(
    request: Request,
    account: OptionalAccount,
    accounts: AccountsOf,
    token: str,
    login: Field = "",
    new_password: Field = "",
) -> Response:
    try:
        opened = await accounts.choose_password(token, new_password, visitor=account, address=client_address(request))
    except RefusedForm as refused:
        return form(request, "nouveau_mot_de_passe.html", account, refused, login=login)
    remember(request, opened)
    return go("/")


@router.post("/deconnexion")
def log_out(request: Request, db: Db) -> Response:
    service.close_session(db, session_token(request))
    forget(request)
    return go("/")
