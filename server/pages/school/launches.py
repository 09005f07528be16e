"""Launches of LTI platforms: their begin, the look whether the browser keeps cookies, and the signed token's arrival.

A launch is the one cross-site form that is let in: it proves itself.
"""

from __future__ import annotations

from typing import Annotated
from urllib.parse import urlencode

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import HTMLResponse, Response
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.app_services import SettingsOf
from server.base.http import LTI_BEGIN_PATH, LTI_LAUNCH_PATH, client_address
from server.base.root_path import service_url
from server.base.security_headers import FRAMES_STATE
from server.database import Database, utc_now
from server.database.dependencies import DatabaseOf
from server.federation import arrivals, outbox, pending
from server.federation.dependencies import FederationOf
from server.federation.entries import record_failure
from server.federation.errors import FederationRefused
from server.federation.lti import deep_linking, sign_in
from server.federation.lti.launch import Launch
from server.federation.lti.schemas import lti_settings
from server.federation.lti.sign_in import LaunchInitiation
from server.federation.models import ActivityKind, IdentityProvider, PendingSignIn
from server.identity.dependencies import AccountServiceOf, OptionalAccount, set_session_cookie
from server.identity.models import Account
from server.identity.service import AccountService
from server.limits import service as limits
from server.pages.school import landing
from server.pages.school.content import CONTENT_PATH
from server.pages.school.cookies import clear_state_cookie, read_state_cookie, set_state_cookie
from server.web.forms import Field, redirect
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

CHECK_PATH = "/lti/suite"
Hint = Annotated[str, Query(max_length=2000)]
State = Annotated[str, Query(max_length=100)]
TOO_MANY = "Trop d’entrées à la fois depuis cette adresse : réessayez dans {seconds} s."
NO_TOKEN = "La plateforme n’a pas laissé entrer ({error}) : recommencez depuis le cours."
FRAMES = frozenset({"iframe", "frame", "embed", "object"})


def _read_initiation_query(
    iss: Hint = "",
    login_hint: Hint = "",
    target_link_uri: Hint = "",
    client_id: Hint = "",
    lti_message_hint: Hint = "",
    lti_deployment_id: Hint = "",
) -> LaunchInitiation:
    return LaunchInitiation(iss, login_hint, target_link_uri, client_id, lti_message_hint, lti_deployment_id)


def _read_initiation_form(
    iss: Field = "",
    login_hint: Field = "",
    target_link_uri: Field = "",
    client_id: Field = "",
    lti_message_hint: Field = "",
    lti_deployment_id: Field = "",
) -> LaunchInitiation:
    fields = (iss, login_hint, target_link_uri, client_id, lti_message_hint, lti_deployment_id)
    if any(len(field) > 2000 for field in fields):
        raise FederationRefused("claims", "Le début du lancement est trop long.")
    return LaunchInitiation(*fields)


@router.get(LTI_BEGIN_PATH)
def begin_launch_by_query(
    request: Request,
    database: DatabaseOf,
    settings: SettingsOf,
    initiation: Annotated[LaunchInitiation, Depends(_read_initiation_query)],
) -> Response:
    return _begin_launch(request, database, settings, initiation)


@router.post(LTI_BEGIN_PATH)
def begin_launch_by_form(
    request: Request,
    database: DatabaseOf,
    settings: SettingsOf,
    initiation: Annotated[LaunchInitiation, Depends(_read_initiation_form)],
) -> Response:
    return _begin_launch(request, database, settings, initiation)


def _begin_launch(request: Request, database: Database, settings: SettingsOf, initiation: LaunchInitiation) -> Response:
    with database.write() as db:
        limits.take_token(db, f"lti:{client_address(request)}", settings.guest_bucket, TOO_MANY)
        launch = sign_in.begin_launch(db, initiation, service_url(request))
    response = redirect(f"{CHECK_PATH}?{urlencode({'state': launch.begun.state})}")
    set_state_cookie(response, launch.begun)
    return response


@router.get(CHECK_PATH)
def continue_launch(request: Request, database: DatabaseOf, state: State = "") -> Response:
    """Send a browser that keeps cookies to its platform; another one gets a button that opens a tab."""
    with database.write() as db:
        begun, provider = sign_in.find_begun_launch(db, state)
        setattr(request.state, FRAMES_STATE, sign_in.format_frame_origins(lti_settings(provider)))
        browser = read_state_cookie(request, state)
        if browser:
            pending.require_browser(begun, browser)
            return redirect(sign_in.authorization_url(db, begun, provider, state, service_url(request)))
        query = sign_in.restart_query(begun.details, provider, service_url(request) + begun.target)
    return _render_no_cookies_page(request, provider, f"{LTI_BEGIN_PATH}?{query}")


def _render_no_cookies_page(request: Request, provider: IdentityProvider, retry_url: str) -> HTMLResponse:
    is_framed = request.headers.get("sec-fetch-dest", "") in FRAMES
    return render_page(
        request, "platforms/no_cookies.html", None, platform=provider.name, again=retry_url, is_framed=is_framed
    )


@router.get(LTI_LAUNCH_PATH)
def explain_launch_address(request: Request, account: OptionalAccount) -> HTMLResponse:
    """Say to whoever opens the address of a tool by hand how one enters."""
    return render_page(request, "platforms/from_platform.html", account)


@router.post(LTI_LAUNCH_PATH)
async def complete_launch(
    request: Request,
    database: DatabaseOf,
    accounts: AccountServiceOf,
    federation: FederationOf,
    visitor: OptionalAccount,
    id_token: Field = "",
    state: Field = "",
    error: Field = "",
) -> Response:
    """Verify a launch, and open the session of its person."""
    begun, provider = await run_in_threadpool(_find_expected_launch, request, database, state[:100])
    service = service_url(request)
    try:
        if not id_token:
            raise FederationRefused("platform", NO_TOKEN.format(error=error[:60] or "sans dire pourquoi"))
        launch = await federation.threads.run(
            provider.id, lambda: sign_in.read_launch(begun, provider, id_token, federation.keys, service)
        )
        response = await run_in_threadpool(_open_launch_session, request, database, accounts, visitor, state, launch)
    except FederationRefused as refused:
        await run_in_threadpool(record_failure, database, provider.id, ActivityKind.sign_in, refused.detail)
        raise
    clear_state_cookie(response, state)
    return response


def _find_expected_launch(request: Request, database: Database, state: str) -> tuple[PendingSignIn, IdentityProvider]:
    """Return a launch that this browser has begun, with its platform. Raises FederationRefused."""
    with database.read() as db:
        begun, provider = sign_in.find_begun_launch(db, state)
        setattr(request.state, FRAMES_STATE, sign_in.format_frame_origins(lti_settings(provider)))
        pending.require_browser(begun, read_state_cookie(request, state))
    return begun, provider


def _open_launch_session(
    request: Request,
    database: Database,
    accounts: AccountService,
    visitor: Account | None,
    state: str,
    launch: Launch,
) -> Response:
    """Use the launch up, and open its session, in one transaction. Raises FederationRefused or Forbidden."""
    destination = request.headers.get("sec-fetch-dest", "")
    is_framed = destination in FRAMES or (not destination and launch.is_framed)
    with database.write() as db:
        begun, provider = sign_in.find_begun_launch(db, state)
        target, _ = pending.consume_sign_in(db, begun, launch.nonce)
        frames = sign_in.format_frame_origins(lti_settings(provider)) if is_framed else ""
        arrival = arrivals.open_session(db, accounts, provider, launch.person, visitor, frames=frames)
        for context, arrived in zip(arrival.contexts, launch.person.contexts, strict=True):
            outbox.adopt_launch_line_item(db, context, launch.target, arrived.line_item_url, utc_now())
        choosing = _begin_content_choice(db, provider, arrival, launch)
        if choosing is None:
            page = landing.choose_landing_page(db, arrival, launch.person.role, launch.target or target, visitor)
        else:
            page = f"{CONTENT_PATH}?etat={choosing.state}"
    set_session_cookie(request, arrival.opened)
    response = redirect(page)
    if choosing is not None:
        set_state_cookie(response, choosing)
    return response


def _begin_content_choice(
    db: Session, provider: IdentityProvider, arrival: arrivals.Arrival, launch: Launch
) -> pending.BegunSignIn | None:
    """Begin the choice of a content, where the launch asks for one."""
    if launch.linking is None:
        return None
    context = arrival.contexts[0] if arrival.contexts else None
    return deep_linking.begin_content_choice(
        db, provider, context, arrival.opened.account, launch.linking, launch.deployment
    )
