"""The administrator's forms of a CAS server and of an OpenID Connect server: a new one, or one that is there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.errors import InvalidFields, NotFound, ServiceError
from server.base.root_path import service_url
from server.database.dependencies import DatabaseOf
from server.federation import providers, registration
from server.federation.dependencies import FederationOf
from server.federation.extra import MISSING, is_installed
from server.federation.models import IdentityProvider, Protocol
from server.federation.oidc.schemas import oidc_settings
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.pages.school.platforms import LIST_PATH, PLATFORM_PATH, form_problems
from server.pages.school.rules import RULE_PATH
from server.web.forms import FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)
NEW_PATH, EDIT_PATH = f"{LIST_PATH}/serveur/{{protocol}}", f"{PLATFORM_PATH}/serveur"
FIELDS = ("name", "issuer", "client_id", "client_secret", "sans_secret", "scopes", "service", "enseignants")
NO_PROTOCOL = "Ce protocole n’existe pas."


@dataclass(frozen=True)
class ServerForm:
    """A protocol's part of the form: its heading, and how it is read (`insecure` and the secret of before)."""

    heading: str
    parse: Callable[[Mapping[str, str], bool, str], tuple[dict[str, str], Any]]


FORMS: Mapping[str, ServerForm] = {
    Protocol.cas: ServerForm("un serveur CAS", lambda form, http, _: registration.parse_cas(form, insecure=http)),
    Protocol.oidc: ServerForm(
        "un serveur OpenID Connect",
        lambda form, http, secret: registration.parse_oidc(form, insecure=http, secret=secret),
    ),
}


def _find_server_form(protocol: str) -> ServerForm:
    """Raises NotFound."""
    if protocol not in FORMS:
        raise NotFound(NO_PROTOCOL)
    return FORMS[protocol]


def _render_form_page(
    request: Request,
    account: Account,
    protocol: str,
    values: Mapping[str, str],
    problems: Mapping[str, str] | None = None,
    *,
    provider: IdentityProvider | None = None,
) -> HTMLResponse:
    return render_page(
        request,
        "platforms/server_form.html",
        account,
        status=422 if problems else 200,
        values=values,
        problems=problems or {},
        protocol=protocol,
        form=FORMS[protocol],
        provider=provider,
        has_secret=provider is not None and bool(provider.settings.get("client_secret")),
        missing="" if is_installed() else MISSING,
    )


@router.get(NEW_PATH)
def show_new_server(request: Request, account: OptionalAccount, protocol: str) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    _find_server_form(protocol)
    start = {"service": service_url(request), "scopes": "openid profile", "enseignants": "oui"}
    return _render_form_page(request, account, protocol, start)


@router.post(NEW_PATH)
def add_server(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    federation: FederationOf,
    protocol: str,
    form: FormFields,
) -> Response:
    providers.require_administrator(account)
    values = _read_text_fields(form)
    try:
        texts, settings = _find_server_form(protocol).parse(values, federation.insecure, "")
        with database.write() as db:
            trusts = values.get("enseignants") == "oui"
            provider = registration.add_server(db, Protocol(protocol), texts, settings, account.id, trusts=trusts)
            page = RULE_PATH.format(provider_id=provider.id)
    except NotFound:
        raise
    except ServiceError as error:
        return _render_form_page(request, account, protocol, values, form_problems(error))
    return redirect(page)


@router.get(EDIT_PATH)
def show_server(request: Request, account: OptionalAccount, database: DatabaseOf, provider_id: UUID) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    with database.read() as db:
        provider = providers.find_provider(db, provider_id)
        _find_server_form(provider.protocol)
        return _render_form_page(request, account, provider.protocol, _form_values(provider), provider=provider)


@router.post(EDIT_PATH)
def change_server(
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
        provider = providers.find_provider(db, provider_id)
        server_form = _find_server_form(provider.protocol)
    values = {**_read_text_fields(form), "issuer": provider.issuer, "client_id": provider.client_id}
    secret = oidc_settings(provider).client_secret if provider.protocol == Protocol.oidc else ""
    try:
        texts, settings = server_form.parse(values, federation.insecure, secret)
    except InvalidFields as error:
        return _render_form_page(request, account, provider.protocol, values, error.problems, provider=provider)
    with database.write() as db:
        provider = providers.find_provider(db, provider_id)
        provider.trusts_teachers = values.get("enseignants") == "oui"
        registration.change_server(db, provider, texts, settings, account.id)
    return redirect(PLATFORM_PATH.format(provider_id=provider_id))


def _read_text_fields(form: FormFields) -> dict[str, str]:
    return {name: value for name in FIELDS if isinstance(value := form.get(name), str)}


def _form_values(provider: IdentityProvider) -> Mapping[str, str]:
    """Return the values of the form of a server that there is: never its secret."""
    settings = provider.settings
    return {
        "name": provider.name,
        "issuer": provider.issuer,
        "client_id": provider.client_id,
        "service": settings["service"],
        "scopes": " ".join(settings.get("scopes", ())),
        "enseignants": "oui" if provider.trusts_teachers else "",
    }
