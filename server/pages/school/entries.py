"""Sign-in by a school's system from our own page (CAS, OpenID Connect): away, back, and logout from there."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeVar
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response
from starlette.concurrency import run_in_threadpool

from server.base.errors import NotFound, Unavailable
from server.base.http import MAX_ADDRESS, client_address, local_path
from server.base.root_path import root_path
from server.base.validation import TruncateTo
from server.database import Database
from server.database.dependencies import DatabaseOf
from server.federation import arrivals, entries, pending, providers
from server.federation.cas.messages import parse_logout_ticket
from server.federation.dependencies import FederationOf
from server.federation.entries import ENTRY_PATH, LOGOUT_PATH, RETURN_PATH, TRIAL
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.extra import MISSING, is_installed
from server.federation.models import ActivityKind, IdentityProvider, Protocol
from server.federation.oidc.entry import read_logout
from server.federation.proofs import BrowserAnswer, ProvenPerson
from server.federation.rules import apply_rule
from server.federation.service import Federation
from server.identity.dependencies import AccountServiceOf, OptionalAccount, set_session_cookie
from server.identity.models import Account
from server.identity.opened_sessions import OpenedSession
from server.identity.service import AccountService
from server.limits import service as limits
from server.pages.school.landing import choose_landing_page
from server.pages.school.platforms import PLATFORM_PATH
from server.pages.school.rules import show_trial
from server.web.forms import Field, redirect, redirect_to_login

router = APIRouter(include_in_schema=False)
log = logging.getLogger(__name__)
T = TypeVar("T")

MAX_TEXT = 2000  # characters of a member of an answer
Text = Annotated[str, Query(max_length=MAX_TEXT)]
Target = Annotated[str, TruncateTo(MAX_ADDRESS)]
TRIAL_PATH = f"{PLATFORM_PATH}/essai"
NO_STORE = {"Cache-Control": "no-store"}
TOO_MANY_ENTRIES = "Trop de connexions commencées d’ici : réessayez dans {seconds} s."
AWAY = (
    "« {name} » ne répond pas comme il faut en ce moment ({reason}). Réessayez dans quelques instants ; si cela dure, "
    "prévenez votre établissement."
)
AWAY_SECONDS = 10


def find_active_provider(database: Database, provider_id: UUID, *, paused: bool = False) -> IdentityProvider:
    """Return a system by which one signs in here. Raises NotFound, or FederationRefused where it is paused."""
    if not is_installed():
        raise NotFound(MISSING)
    with database.read() as db:
        provider = providers.find_provider(db, provider_id)
        entries.find_entry(provider)
        if not paused:
            providers.require_active(provider)
        return provider


async def ask_provider(
    database: Database, federation: Federation, provider: IdentityProvider, kind: ActivityKind, work: Callable[[], T]
) -> T:
    """Return the result of `work`, which asks a system; its failures are written to the activity. Raises
    FederationRefused or Unavailable."""
    try:
        return await federation.threads.run(provider.id, work)
    except FederationRefused as refused:
        await run_in_threadpool(entries.record_failure, database, provider.id, kind, refused.code)
        raise
    except OutgoingError as error:
        await run_in_threadpool(entries.record_failure, database, provider.id, kind, error.reason)
        away = AWAY.format(name=provider.name, reason=error.reason)
        raise Unavailable(away, retry_after=AWAY_SECONDS) from error


def redirect_to_provider(request: Request, begun: pending.BegunSignIn, address: str) -> Response:
    """Lead the browser to the system's address, with the cookie by which it is known when it comes back."""
    answer = redirect(address)
    answer.headers.update(NO_STORE)
    answer.set_cookie(
        pending.cookie_name(begun.state),
        begun.browser,
        max_age=int(pending.LIFETIME.total_seconds()),
        path=f"{root_path()}/connexion/etablissement",
        secure=request.url.scheme == "https",
        httponly=True,
        samesite="lax",
    )
    return answer


async def begin_provider_sign_in(
    request: Request,
    database: Database,
    federation: Federation,
    provider: IdentityProvider,
    target: str,
    *,
    trial_by: UUID | None = None,
) -> Response:
    """Begin a sign-in, or an administrator's trial of one. Raises FederationRefused or Unavailable."""

    def begin() -> tuple[pending.BegunSignIn, str]:
        return entries.begin_sign_in(database, federation, provider, target, trial_by=trial_by)

    if provider.protocol == Protocol.cas:  # which asks nobody
        begun, address = await run_in_threadpool(begin)
    else:
        begun, address = await ask_provider(database, federation, provider, ActivityKind.sign_in, begin)
    return redirect_to_provider(request, begun, address)


@router.get(ENTRY_PATH)
async def sign_in_by_provider(
    request: Request,
    database: DatabaseOf,
    federation: FederationOf,
    accounts: AccountServiceOf,
    provider_id: UUID,
    suite: Target = "/",
) -> Response:
    """Leads to the system's own page of sign-in."""

    def prepare() -> IdentityProvider:
        provider = find_active_provider(database, provider_id)
        with database.write() as db:
            key = f"entry:{client_address(request)}"
            limits.take_token(db, key, accounts.settings.guest_bucket, TOO_MANY_ENTRIES)
        return provider

    provider = await run_in_threadpool(prepare)
    return await begin_provider_sign_in(request, database, federation, provider, local_path(suite))


@router.get(TRIAL_PATH)
async def begin_trial(
    request: Request, account: OptionalAccount, database: DatabaseOf, federation: FederationOf, provider_id: UUID
) -> Response:
    """Leads an administrator through a sign-in that opens no session: what the system says is shown with the rule."""
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    provider = await run_in_threadpool(lambda: find_active_provider(database, provider_id, paused=True))
    return await begin_provider_sign_in(request, database, federation, provider, "/", trial_by=account.id)


@router.get(RETURN_PATH)
async def complete_provider_sign_in(
    request: Request,
    visitor: OptionalAccount,
    accounts: AccountServiceOf,
    database: DatabaseOf,
    federation: FederationOf,
    provider_id: UUID,
    etat: Text = "",
    state: Text = "",
    ticket: Text = "",
    code: Text = "",
    iss: Text = "",
    error: Text = "",
) -> Response:
    """The sign-in is used up before anybody is asked: an address that is sent twice asks, and enters, once."""
    answer = BrowserAnswer(etat or state, ticket, code, iss, error)
    cookie = pending.cookie_name(answer.state)
    browser = request.cookies.get(cookie, "")

    def take() -> tuple[IdentityProvider, str, Mapping[str, Any]]:
        provider = find_active_provider(database, provider_id, paused=True)
        with database.write() as db:
            target, details = pending.consume_own_sign_in(db, provider_id, answer.state, browser)
        if TRIAL not in details:
            providers.require_active(provider)
        return provider, target, details

    provider, target, details = await run_in_threadpool(take)

    def prove() -> ProvenPerson:
        return entries.prove_person(database, federation, provider, answer, details)

    proof = await ask_provider(database, federation, provider, ActivityKind.sign_in, prove)
    if TRIAL in details:
        return await run_in_threadpool(show_trial, request, visitor, database, provider_id, proof, details[TRIAL])
    opened, target = await run_in_threadpool(
        _open_provider_session, accounts, database, provider_id, proof, visitor, target
    )
    set_session_cookie(request, opened)
    away = redirect(target)
    away.headers.update(NO_STORE)
    away.delete_cookie(cookie, path=f"{root_path()}/connexion/etablissement")
    return away


def _open_provider_session(
    accounts: AccountService,
    database: Database,
    provider_id: UUID,
    proof: ProvenPerson,
    visitor: Account | None,
    target: str,
) -> tuple[OpenedSession, str]:
    """Return the session, and the page to go to. Raises FederationRefused or Forbidden."""
    try:
        with database.write() as db:
            provider = providers.find_provider(db, provider_id)
            providers.require_active(provider)
            person = apply_rule(entries.find_entry(provider).rule(provider), proof.claims, proof.subject, proof.session)
            arrival = arrivals.open_session(db, accounts, provider, person, visitor)
            page = choose_landing_page(db, arrival, person.role, local_path(target), visitor)
    except FederationRefused as refused:
        entries.record_failure(database, provider_id, ActivityKind.sign_in, refused.code)
        raise
    return arrival.opened, page


@router.post(RETURN_PATH)
async def end_session_by_cas_ticket(database: DatabaseOf, provider_id: UUID, logoutRequest: Field = "") -> Response:
    """The single logout of CAS: whoever knows a ticket that has opened a session may end it, and nobody else."""

    def end() -> None:
        provider = find_active_provider(database, provider_id, paused=True)
        if provider.protocol != Protocol.cas:
            raise FederationRefused("protocol", entries.NOT_HERE)
        ticket = parse_logout_ticket(logoutRequest)
        with database.write() as db:
            arrivals.end_sessions(db, provider, ticket)

    await run_in_threadpool(end)
    return Response(status_code=200, headers=NO_STORE)


@router.post(LOGOUT_PATH)
async def end_session_by_logout_token(
    database: DatabaseOf, federation: FederationOf, provider_id: UUID, logout_token: Field = ""
) -> Response:
    """The back-channel logout of OpenID Connect (1.0, 2.8)."""
    provider = await run_in_threadpool(find_active_provider, database, provider_id, paused=True)
    if provider.protocol != Protocol.oidc:
        raise FederationRefused("protocol", entries.NOT_HERE)

    def end() -> None:
        ended = read_logout(federation, provider, logout_token)
        with database.write() as db:
            if ended.session:
                arrivals.end_sessions(db, provider, ended.session)
            else:
                arrivals.end_person_sessions(db, provider, ended.subject, ended.issued_at)

    try:
        await federation.threads.run(provider.id, end)
    except FederationRefused as refused:
        log.info("a logout token was refused: %s", refused.code)
        document = {"error": "invalid_request", "error_description": refused.code}
        return JSONResponse(document, status_code=400, headers=NO_STORE)
    except OutgoingError as error:
        raise Unavailable(AWAY.format(name=provider.name, reason=error.reason), retry_after=AWAY_SECONDS) from error
    return Response(status_code=200, headers=NO_STORE)
