"""The administrator's pages of the systems of schools: list, one platform with what it did last, its test."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response
from pydantic import BaseModel
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.errors import Invalid, InvalidFields, ServiceError
from server.base.http import LTI_BEGIN_PATH, LTI_LAUNCH_PATH
from server.base.root_path import service_url
from server.database import Database, utc_now
from server.database.dependencies import DatabaseOf
from server.federation import providers, repository
from server.federation import registration as servers
from server.federation.cas.schemas import cas_settings
from server.federation.dependencies import FederationOf
from server.federation.errors import OutgoingError
from server.federation.extra import MISSING, is_installed
from server.federation.lti import registration
from server.federation.lti.schemas import lti_settings
from server.federation.lti.testing import check_platform
from server.federation.models import ActivityKind, IdentityProvider, Protocol
from server.federation.oidc.schemas import oidc_settings
from server.federation.service import Federation
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.pages.school.keys import KEYS_PATH
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

LIST_PATH, PLATFORM_PATH = "/administration/plateformes", "/administration/plateforme/{provider_id}"
ACTIVITY_LABELS: Mapping[str, str] = {
    ActivityKind.registration: "inscription",
    ActivityKind.sign_in: "entrée d’une personne",
    ActivityKind.keys: "lecture de ses clés",
    ActivityKind.roster: "liste d’un cours",
    ActivityKind.content: "choix d’un contenu",
    ActivityKind.marks: "envoi de notes",
    ActivityKind.logout: "déconnexion demandée",
    ActivityKind.test: "essai depuis cette page",
}
Check = Callable[[Database, Federation, IdentityProvider, str], str]


@dataclass(frozen=True)
class ProtocolPageParts:
    """A protocol's part of the pages: its name, its template beside the common one, its settings, and its test.

    The test gets our own address, returns a sentence about the success, and raises OutgoingError.
    """

    label: str
    template: str
    settings: Callable[[IdentityProvider], BaseModel]
    check: Check
    addresses: Callable[[Request, IdentityProvider], Mapping[str, str]]


SERVER_PART = "platforms/server_part.html"


def _list_addresses(_request: Request, provider: IdentityProvider) -> Mapping[str, str]:
    return servers.list_own_addresses(provider, KEYS_PATH)


PROTOCOLS: Mapping[str, ProtocolPageParts] = {
    Protocol.lti: ProtocolPageParts(
        "LTI 1.3",
        "platforms/lti_part.html",
        lti_settings,
        check_platform,
        lambda request, _: list_own_addresses(request),
    ),
    Protocol.cas: ProtocolPageParts("CAS", SERVER_PART, cas_settings, servers.check_cas_server, _list_addresses),
    Protocol.oidc: ProtocolPageParts(
        "OpenID Connect", SERVER_PART, oidc_settings, servers.check_oidc_server, _list_addresses
    ),
}


def form_problems(error: ServiceError) -> Mapping[str, str]:
    """Return the problems of a form by field; those of no field are told at the issuer's."""
    return error.problems if isinstance(error, InvalidFields) else {"issuer": error.detail}


@router.get(LIST_PATH)
def show_platforms(request: Request, account: OptionalAccount, database: DatabaseOf) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    with database.read() as db:
        rows = repository.load_providers(db)
        return render_page(
            request,
            "platforms/list.html",
            account,
            platforms=rows,
            accounts=repository.count_identities_by_issuer(db),
            latest=_load_latest_activity(db, rows),
            labels=ACTIVITY_LABELS,
            protocols=PROTOCOLS,
            missing="" if is_installed() else MISSING,
        )


def _load_latest_activity(db: Session, rows: Any) -> Mapping[UUID, Any]:
    """Return the newest activity of each provider."""
    latest: dict[UUID, Any] = {}
    for activity in repository.load_activity(db, [row.id for row in rows]):
        latest.setdefault(activity.provider_id, activity)
    return latest


@router.get(PLATFORM_PATH)
def show_platform(request: Request, account: OptionalAccount, database: DatabaseOf, provider_id: UUID) -> Response:
    if account is None:
        return redirect_to_login(request)
    providers.require_administrator(account)
    return render_platform_page(request, account, database, provider_id)


def render_platform_page(
    request: Request, account: Account, database: Database, provider_id: UUID, *, result: str = "", problem: str = ""
) -> HTMLResponse:
    with database.read() as db:
        provider = providers.find_provider(db, provider_id)
        page = PROTOCOLS[provider.protocol]
        return render_page(
            request,
            "platforms/platform.html",
            account,
            status=422 if problem else 200,
            platform=provider,
            page=page,
            settings=page.settings(provider),
            activity=repository.load_activity(db, [provider.id]),
            labels=ACTIVITY_LABELS,
            result=result,
            problem=problem,
            addresses=page.addresses(request, provider),
        )


def list_own_addresses(request: Request) -> Mapping[str, str]:
    """Return our own addresses, which a platform's administrator types there."""
    service = service_url(request)
    return {
        "Adresse de l’outil (Tool URL, Target link URI)": f"{service}{LTI_LAUNCH_PATH}",
        "Adresse de début de connexion (Initiate login URL)": f"{service}{LTI_BEGIN_PATH}",
        "Adresse de retour (Redirection URI)": f"{service}{LTI_LAUNCH_PATH}",
        "Adresse de nos clés (Public keyset URL)": f"{service}{KEYS_PATH}",
        "Adresse du choix de contenu (Content selection URL)": f"{service}{LTI_LAUNCH_PATH}",
    }


@router.post(PLATFORM_PATH)
async def change_platform(
    request: Request,
    account: SignedIn,
    database: DatabaseOf,
    federation: FederationOf,
    provider_id: UUID,
    action: Field = "",
    deploiement: Field = "",
) -> Response:
    providers.require_administrator(account)
    if action == "tester":
        return await _test_connection(request, account, database, federation, provider_id)
    return await run_in_threadpool(_apply_action, database, account, provider_id, action, deploiement)


def _apply_action(database: Database, account: Account, provider_id: UUID, action: str, deployment: str) -> Response:
    page = PLATFORM_PATH.format(provider_id=provider_id)
    with database.write() as db:
        provider = providers.find_provider(db, provider_id)
        if action == "suspendre":
            providers.pause_provider(db, provider, account.id)
        elif action == "reprendre":
            providers.resume_provider(db, provider, account.id)
        elif action == "retirer":
            providers.remove_provider(db, provider, account.id)
            page = LIST_PATH
        elif action == "deploiement" and provider.protocol == Protocol.lti:
            registration.accept_deployment(db, provider, deployment, account.id)
        else:
            raise Invalid(UNKNOWN_ACTION)
    return redirect(page)


async def _test_connection(
    request: Request, account: Account, database: Database, federation: Federation, provider_id: UUID
) -> Response:
    """Ask the platform what its protocol needs, and say what came of it."""

    def check() -> tuple[str, str]:
        with database.read() as db:
            provider = providers.find_provider(db, provider_id)
        result, problem = "", ""
        try:
            result = PROTOCOLS[provider.protocol].check(database, federation, provider, service_url(request))
        except OutgoingError as error:
            problem = f"L’essai a échoué : {error.reason}."
        with database.write() as db:
            repository.record_activity(
                db, provider_id, ActivityKind.test, utc_now(), result or problem, succeeded=not problem
            )
        return result, problem

    result, problem = await federation.threads.run(provider_id, check)
    return await run_in_threadpool(
        render_platform_page, request, account, database, provider_id, result=result, problem=problem
    )
