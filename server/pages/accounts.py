"""Pages by which one comes and goes: sign up, log in, log out, one-time links."""

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response
from starlette.concurrency import run_in_threadpool

from server.base.http import MAX_ADDRESS, client_address, device_token, local_path, session_token
from server.base.validation import TruncateTo
from server.database.dependencies import Db
from server.federation.repository import load_sign_in_providers
from server.identity import links, secrets, service
from server.identity.dependencies import AccountServiceOf, OptionalAccount, clear_session_cookie, set_session_cookie
from server.identity.models import Account
from server.identity.opened_sessions import OpenedSession
from server.identity.schemas import RefusedForm, validate_new_account
from server.identity.service import AccountService
from server.text.plain import show_invisible_characters
from server.web.form_identity import SEND_AS, build_resend_context, decode_resent_fields
from server.web.forms import Field, redirect, render_account_form
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

CodeQuery = Annotated[str, Query(max_length=100)]
NextAddress = Annotated[str, TruncateTo(MAX_ADDRESS)]


@router.get("/inscription")
def show_sign_up_form(request: Request, account: OptionalAccount, suite: NextAddress = "/") -> HTMLResponse:
    return render_account_form(request, "inscription.html", account, after=local_path(suite))


@router.post("/inscription")
async def sign_up(
    request: Request,
    account: OptionalAccount,
    accounts: AccountServiceOf,
    name: Field = "",
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
) -> Response:
    try:
        opened = await _sign_up_from_form(request, accounts, account, (name, login, password))
    except RefusedForm as refused:
        return await run_in_threadpool(
            render_account_form,
            request,
            "inscription.html",
            account,
            refused,
            name=name,
            login=login,
            after=local_path(suite),
        )
    set_session_cookie(request, opened)
    return redirect(local_path(suite))


async def _sign_up_from_form(
    request: Request,
    accounts: AccountService,
    visitor: Account | None,
    fields: tuple[str, str, str],
    invitation: str | None = None,
) -> OpenedSession:
    wanted = await run_in_threadpool(validate_new_account, *fields)
    return await accounts.sign_up(
        wanted,
        visitor=visitor,
        address=client_address(request),
        invitation=invitation,
        device=device_token(request),
    )


@router.get("/bienvenue/{token}")
def show_invitation_form(request: Request, account: OptionalAccount, db: Db, token: str) -> HTMLResponse:
    links.find_open_invitation(db, token)
    return render_account_form(request, "bienvenue.html", account)


@router.post("/bienvenue/{token}")
async def sign_up_by_invitation(
    request: Request,
    account: OptionalAccount,
    accounts: AccountServiceOf,
    token: str,
    name: Field = "",
    login: Field = "",
    password: Field = "",
) -> Response:
    try:
        opened = await _sign_up_from_form(request, accounts, account, (name, login, password), token)
    except RefusedForm as refused:
        return await run_in_threadpool(
            render_account_form, request, "bienvenue.html", account, refused, name=name, login=login
        )
    set_session_cookie(request, opened)
    return redirect("/")


@router.get("/connexion")
def show_login_form(request: Request, account: OptionalAccount, db: Db, suite: NextAddress = "/") -> HTMLResponse:
    return render_account_form(
        request,
        "connexion.html",
        account,
        after=local_path(suite),
        action="/",
        resend="",
        schools=load_sign_in_providers(db),
    )


def _render_refused_login(
    request: Request, accounts: AccountService, account: Account | None, refused: RefusedForm, **context: str
) -> HTMLResponse:
    with accounts.database.read() as db:
        schools = load_sign_in_providers(db)
        return render_account_form(request, "connexion.html", account, refused, schools=schools, **context)


@router.post("/connexion")
async def log_in(
    request: Request,
    account: OptionalAccount,
    accounts: AccountServiceOf,
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
    action: Field = "/",
    reprise: Field = "",
) -> Response:
    """`reprise` holds the fields of a form that was refused for its identity: it is offered again after the log-in."""
    form = {"after": local_path(suite), "action": local_path(action), "resend": reprise}
    try:
        opened = await accounts.log_in(
            login, password, visitor=account, address=client_address(request), device=device_token(request)
        )
    except RefusedForm as refused:
        return await run_in_threadpool(_render_refused_login, request, accounts, account, refused, login=login, **form)
    set_session_cookie(request, opened)
    fields = decode_resent_fields(reprise)
    if fields is None:
        return redirect(form["after"])
    button = SEND_AS.format(name=show_invisible_characters(opened.account.name))
    context = build_resend_context(fields, form["action"], form["after"], opened.account, button=button)
    return await run_in_threadpool(render_page, request, "resend.html", opened.account, **context)


@router.get("/nouveau-mot-de-passe")
def open_password_slip(request: Request, account: OptionalAccount, code: CodeQuery = "") -> Response:
    """Asks for the code of a slip, and leads to its page."""
    letters = "".join(letter for letter in secrets.normalise_typed_token(code) if letter.isalnum())
    if letters:
        return redirect(f"/nouveau-mot-de-passe/{letters}")
    return render_account_form(request, "billet.html", account)


@router.get("/nouveau-mot-de-passe/{token}")
def show_new_password_form(
    request: Request, account: OptionalAccount, accounts: AccountServiceOf, token: str
) -> HTMLResponse:
    owner = accounts.find_link_owner(token, client_address(request))
    return render_account_form(request, "nouveau_mot_de_passe.html", account, login=owner.login)


@router.post("/nouveau-mot-de-passe/{token}")
async def choose_new_password(
    request: Request,
    account: OptionalAccount,
    accounts: AccountServiceOf,
    token: str,
    login: Field = "",
    new_password: Field = "",
) -> Response:
    try:
        opened = await accounts.choose_password(
            token, new_password, visitor=account, address=client_address(request), device=device_token(request)
        )
    except RefusedForm as refused:
        return await run_in_threadpool(
            render_account_form, request, "nouveau_mot_de_passe.html", account, refused, login=login
        )
    set_session_cookie(request, opened)
    return redirect("/")


@router.post("/deconnexion")
def log_out(request: Request, db: Db) -> Response:
    service.close_session(db, session_token(request))
    clear_session_cookie(request)
    return redirect("/")
