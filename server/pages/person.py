"""Pages of what is one's own: password, API tokens, data to take away or to erase, and what is kept."""

from collections.abc import Callable
from functools import partial
from typing import Annotated
from urllib.parse import urlsplit
from uuid import UUID

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import HTMLResponse, Response, StreamingResponse
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.app_services import app_service
from server.base.bulk import OneAtATimeStream
from server.base.http import MAX_ADDRESS, client_address, local_path, session_token
from server.base.root_path import service_url
from server.base.settings import Settings
from server.base.validation import TruncateTo
from server.calendars import repository as calendar_addresses
from server.calendars import service as calendars
from server.database import Database, roll_back_then_read, utc_now
from server.database.dependencies import DatabaseOf, Db
from server.identity import identities, joining, tokens
from server.identity.dependencies import (
    AccountServiceOf,
    OptionalAccount,
    SignedIn,
    clear_session_cookie,
    set_session_cookie,
)
from server.identity.models import Account
from server.identity.schemas import RefusedForm
from server.identity.service import BUCKET_RETENTION
from server.pages import retention
from server.personal import erasures
from server.personal.dependencies import PersonalDataOf
from server.personal.service import export_archive_headers
from server.web.forms import Field, redirect, render_account_form

router = APIRouter(include_in_schema=False)

#: The page asks for the password in two forms: the problems of the second one stand beside its own field.
TOKEN_FIELDS = {"password": "token_password"}

NextAddress = Annotated[str, TruncateTo(MAX_ADDRESS)]
ShortQuery = Annotated[str, Query(max_length=100)]
SettingsOf = Annotated[Settings, Depends(app_service(Settings))]


async def _render_in_read_session(database: Database, build: Callable[[Session], HTMLResponse]) -> HTMLResponse:
    """Return the page that `build` makes in a thread, of a session that reads."""

    def read() -> HTMLResponse:
        with database.read() as db:
            return build(db)

    return await run_in_threadpool(read)


@router.get("/donnees-personnelles")
def show_stored_data(request: Request, account: OptionalAccount, settings: SettingsOf) -> HTMLResponse:
    return render_account_form(
        request,
        "donnees.html",
        account,
        settings=settings,
        kept_days=BUCKET_RETENTION.days,
        kept=tuple(retention.list_retention_rows(settings)),
    )


@router.get("/compte")
def show_account(
    request: Request, account: OptionalAccount, db: Db, settings: SettingsOf, change: ShortQuery = ""
) -> Response:
    if account is None:
        return redirect("/connexion?suite=/compte")
    return _render_account_page(request, account, db, settings, changed=change == "mot-de-passe")


def _render_account_page(
    request: Request,
    account: Account,
    db: Db,
    settings: Settings,
    secret: str | None = None,
    refused: RefusedForm | None = None,
    *,
    label: str = "",
    name: str = "",
    changed: bool = False,
    calendar_token: str | None = None,
) -> HTMLResponse:
    return render_account_form(
        request,
        "compte.html",
        account,
        refused,
        person=account,
        name=name,
        identities=identities.load_identities(db, account.id),
        tokens=tokens.load_tokens(db, account),
        secret=secret,
        label="" if secret else label,
        changed=changed,
        settings=settings,
        server=service_url(request),
        calendar=calendar_addresses.find_calendar_address(db, account.id),
        calendar_token=calendar_token,
        standing=erasures.find_pending_erasure(db, account.id, None, settings, utc_now()),
    )


@router.post("/compte/nom")
def name_pseudonymous_account(
    request: Request, person: SignedIn, db: Db, settings: SettingsOf, name: Field = ""
) -> Response:
    """Names an account of which no name is known."""
    try:
        identities.replace_pseudonym(db, person, name)
    except RefusedForm as refused:
        roll_back_then_read(db)
        return _render_account_page(request, person, db, settings, refused=refused, name=name)
    return redirect("/compte")


@router.get("/compte/rejoindre")
def show_join_form(
    request: Request, account: OptionalAccount, db: Db, identifiant: ShortQuery = "", suite: NextAddress = "/"
) -> Response:
    if account is None:
        return redirect("/connexion?suite=/compte/rejoindre")
    return _render_join_page(request, account, db, login=identifiant, after=local_path(suite))


def _render_join_page(
    request: Request, account: Account, db: Db, refused: RefusedForm | None = None, *, login: str, after: str
) -> HTMLResponse:
    own = identities.load_identities(db, account.id)
    systems = [urlsplit(identity.issuer).netloc or identity.issuer for identity in own]
    return render_account_form(
        request, "rejoindre_compte.html", account, refused, person=account, systems=systems, login=login, after=after
    )


@router.post("/compte/rejoindre")
async def join_account(
    request: Request,
    person: SignedIn,
    accounts: AccountServiceOf,
    database: DatabaseOf,
    login: Field = "",
    password: Field = "",
    suite: Field = "/",
) -> Response:
    """Joins this account, which another system has just opened, to the one of this login and password."""
    try:
        opened = await joining.join_newcomer_to_account(
            accounts, person, login, password, session=session_token(request), address=client_address(request)
        )
    except RefusedForm as refused:
        page = partial(_render_join_page, request, person, refused=refused, login=login, after=local_path(suite))
        return await _render_in_read_session(database, page)
    set_session_cookie(request, opened)
    return redirect(local_path(suite))


@router.post("/compte/jetons")
async def create_api_token(
    request: Request,
    person: SignedIn,
    accounts: AccountServiceOf,
    database: DatabaseOf,
    settings: SettingsOf,
    label: Field = "",
    password: Field = "",
) -> Response:
    session, address = session_token(request), client_address(request)
    secret, refused = None, None
    try:
        _, secret = await accounts.create_token(person, label, password, session=session, address=address)
    except RefusedForm as error:
        refused = RefusedForm({TOKEN_FIELDS.get(field, field): why for field, why in error.problems.items()})
    page = partial(
        _render_account_page, request, person, settings=settings, secret=secret, refused=refused, label=label
    )
    return await _render_in_read_session(database, page)


@router.post("/compte/jetons/{token_id}/revoquer")
def revoke_api_token(person: SignedIn, db: Db, token_id: UUID) -> Response:
    tokens.revoke_token(db, person, token_id)
    return redirect("/compte")


@router.post("/compte/agenda")
def renew_calendar_address(request: Request, person: SignedIn, database: DatabaseOf, settings: SettingsOf) -> Response:
    with database.write() as db:
        token = calendars.renew_calendar_address(db, person)
    with database.read() as db:
        return _render_account_page(request, person, db, settings, calendar_token=token)


@router.post("/compte/mot-de-passe")
async def change_password(
    request: Request,
    person: SignedIn,
    accounts: AccountServiceOf,
    database: DatabaseOf,
    settings: SettingsOf,
    password: Field = "",
    new_password: Field = "",
) -> Response:
    session, address = session_token(request), client_address(request)
    try:
        await accounts.change_password(person, password, new_password, session=session, address=address)
    except RefusedForm as refused:
        return await _render_in_read_session(
            database, partial(_render_account_page, request, person, settings=settings, refused=refused)
        )
    return redirect("/compte?change=mot-de-passe")


@router.get("/compte/donnees")
def export_personal_data(person: SignedIn, personal: PersonalDataOf) -> StreamingResponse:
    return OneAtATimeStream(
        personal.export(person), headers=export_archive_headers(utc_now()), media_type="application/zip"
    )


@router.get("/compte/supprimer")
def show_erasure_form(request: Request, account: OptionalAccount, db: Db, settings: SettingsOf) -> Response:
    if account is None:
        return redirect("/connexion?suite=/compte/supprimer")
    return _render_erasure_page(request, account, db, settings)


def _render_erasure_page(
    request: Request, account: Account, db: Db, settings: Settings, refused: RefusedForm | None = None
) -> HTMLResponse:
    now = utc_now()
    return render_account_form(
        request,
        "supprimer.html",
        account,
        refused,
        login=account.login,
        has_password=account.password_hash is not None,
        preview=erasures.preview_erasure(db, account, None, now),
        standing=erasures.find_pending_erasure(db, account.id, None, settings, now),
        days=settings.erasure_days,
    )


@router.post("/compte/supprimer")
async def erase_own_account(
    request: Request,
    person: SignedIn,
    accounts: AccountServiceOf,
    personal: PersonalDataOf,
    database: DatabaseOf,
    settings: SettingsOf,
    password: Field = "",
) -> Response:
    """Who sits or has sat a test that is not published is erased when it is, and sees so on the page."""
    try:
        await accounts.require_password(
            person, password, credential=session_token(request), address=client_address(request)
        )
    except RefusedForm as refused:
        return await _render_in_read_session(
            database, partial(_render_erasure_page, request, person, settings=settings, refused=refused)
        )
    if not await run_in_threadpool(personal.erase_on_request, person.id):
        return redirect("/compte/supprimer")
    clear_session_cookie(request)
    return redirect("/compte/efface")


@router.post("/compte/supprimer/annuler")
def cancel_erasure(person: SignedIn, db: Db) -> Response:
    erasures.cancel_erasure(db, person, None, person)
    return redirect("/compte/supprimer")


@router.get("/compte/efface")
def show_erasure_done(request: Request, account: OptionalAccount) -> HTMLResponse:
    return render_account_form(request, "efface.html", account)
