"""The administrator's form of an LTI platform, typed by hand: a new one, or one that is there."""

from __future__ import annotations

from collections.abc import Mapping
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import ServiceError
from server.database.dependencies import DatabaseOf
from server.federation import providers
from server.federation.dependencies import FederationOf
from server.federation.extra import MISSING, is_installed
from server.federation.lti import registration
from server.federation.lti.schemas import lti_settings
from server.federation.models import IdentityProvider, Protocol
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.pages.school.platforms import (
    LIST_PATH,
    PLATFORM_PATH,
    form_problems,
    list_own_addresses,
)
from server.web.forms import FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)
NEW_PATH, EDIT_PATH = f"{LIST_PATH}/lti", f"{PLATFORM_PATH}/lti"


@router.get(NEW_PATH)
def show_new_platform_form(request: Request, account: OptionalAccount) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    return _render_form_page(request, account, {"enseignants": "oui"}, {}, action=NEW_PATH)


@router.get(EDIT_PATH)
def show_platform_settings(
    request: Request, account: OptionalAccount, database: DatabaseOf, provider_id: UUID
) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    with database.read() as db:
        values = _form_values(providers.find_provider(db, provider_id, Protocol.lti))
    return _render_form_page(request, account, values, {}, action=EDIT_PATH.format(provider_id=provider_id))


def _render_form_page(
    request: Request, account: Account, values: Mapping[str, str], problems: Mapping[str, str], *, action: str
) -> HTMLResponse:
    return render_page(
        request,
        "platforms/lti_form.html",
        account,
        status=422 if problems else 200,
        values=values,
        problems=problems,
        addresses=list_own_addresses(request),
        action=action,
        is_new=action == NEW_PATH,
        missing="" if is_installed() else MISSING,
    )


@router.post(NEW_PATH)
def create_platform(
    request: Request, account: SignedIn, database: DatabaseOf, federation: FederationOf, form: FormFields
) -> Response:
    providers.require_administrator(account)
    values = _read_text_fields(form)
    try:
        texts, settings = registration.parse_form(values, insecure=federation.insecure)
        with database.write() as db:
            trusts = values.get("enseignants") == "oui"
            provider = registration.add_platform(db, texts, settings, account.id, trusts=trusts)
            page = PLATFORM_PATH.format(provider_id=provider.id)
    except ServiceError as error:
        return _render_form_page(request, account, values, form_problems(error), action=NEW_PATH)
    return redirect(page)


@router.post(EDIT_PATH)
def change_platform_settings(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    federation: FederationOf,
    provider_id: UUID,
    form: FormFields,
) -> Response:
    """Issuer and client id stay: another one is another registration."""
    providers.require_administrator(account)
    with database.read() as db:
        provider = providers.find_provider(db, provider_id, Protocol.lti)
    values = {**_read_text_fields(form), "issuer": provider.issuer, "client_id": provider.client_id}
    try:
        texts, settings = registration.parse_form(values, insecure=federation.insecure)
        with database.write() as db:
            provider = providers.find_provider(db, provider_id, Protocol.lti)
            provider.trusts_teachers = values.get("enseignants") == "oui"
            registration.change_platform(db, provider, settings, texts["name"], account.id)
    except ServiceError as error:
        action = EDIT_PATH.format(provider_id=provider_id)
        return _render_form_page(request, account, values, form_problems(error), action=action)
    return redirect(PLATFORM_PATH.format(provider_id=provider_id))


def _read_text_fields(form: FormFields) -> dict[str, str]:
    return {name: value for name, value in form.items() if isinstance(value, str)}


def _form_values(provider: IdentityProvider) -> Mapping[str, str]:
    """Return the values of the form of a platform that there is."""
    settings = lti_settings(provider)
    return {
        "name": provider.name,
        "issuer": provider.issuer,
        "client_id": provider.client_id,
        "authorization_url": settings.authorization_url,
        "token_url": settings.token_url,
        "keys_url": settings.keys_url,
        "token_audience": settings.token_audience,
        "deployments": " ".join(settings.deployments),
        "frames": " ".join(settings.frames),
        "enseignants": "oui" if provider.trusts_teachers else "",
    }
