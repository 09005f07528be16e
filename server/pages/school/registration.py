"""The one-time address at which a platform registers itself, and the administrator's page that makes it."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response
from starlette.concurrency import run_in_threadpool

from server.base.root_path import service_url
from server.base.security_headers import FRAMES_STATE
from server.database import utc_now
from server.database.dependencies import DatabaseOf
from server.federation import providers, repository
from server.federation.dependencies import FederationOf
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.lti import dynamic
from server.federation.models import ActivityKind
from server.federation.outgoing import origin_of_url
from server.identity.dependencies import SignedIn
from server.pages.school.keys import KEYS_PATH
from server.pages.school.platforms import LIST_PATH
from server.web.forms import Field
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)
#: The administrator's own: a form that names its account.
link_router = APIRouter(include_in_schema=False)

REGISTRATION_PATH = "/lti/inscription/{token}"
MAX_TOKEN = 8000  # characters
Address = Annotated[str, Query(max_length=2000)]
NOT_A_PLATFORM = (
    "Donnez cette adresse à votre plateforme, qui l’ouvre elle-même en disant comment s’inscrire : rien ne s’inscrit "
    "en l’ouvrant à la main."
)


@link_router.post(f"{LIST_PATH}/lien")
def create_registration_link(request: Request, account: SignedIn, database: DatabaseOf) -> HTMLResponse:
    """Show a new one-time address, once."""
    providers.require_administrator(account)
    with database.write() as db:
        token = dynamic.create_registration_link(db, account)
    address = service_url(request) + REGISTRATION_PATH.format(token=token)
    return render_page(request, "platforms/link.html", account, address=address, headers={"Cache-Control": "no-store"})


@router.get(REGISTRATION_PATH)
async def begin_registration(
    request: Request,
    database: DatabaseOf,
    federation: FederationOf,
    token: str,
    openid_configuration: Address = "",
    registration_token: Annotated[str, Query(max_length=2000)] = "",
) -> Response:
    """Show which platform wants to register itself."""
    await run_in_threadpool(_require_registration_link, database, token)
    if not openid_configuration:
        raise FederationRefused("registration", NOT_A_PLATFORM)
    try:
        found = await federation.threads.run(
            REGISTRATION_PATH, lambda: dynamic.read_configuration(federation.outgoing, openid_configuration)
        )
    except OutgoingError as error:
        raise FederationRefused("registration", f"L’inscription est impossible : {error.reason}.") from error
    setattr(request.state, FRAMES_STATE, origin_of_url(found.issuer))
    return await run_in_threadpool(
        render_page,
        request,
        "platforms/register.html",
        None,
        issuer=found.issuer,
        token=token,
        configuration=openid_configuration,
        registration_token=registration_token,
    )


def _require_registration_link(database: DatabaseOf, token: str) -> None:
    with database.read() as db:
        dynamic.require_registration_link(db, token)


@router.post(REGISTRATION_PATH)
async def register_platform(
    request: Request,
    database: DatabaseOf,
    federation: FederationOf,
    token: str,
    openid_configuration: Field = "",
    registration_token: Field = "",
) -> Response:
    """Use the address up, register Balise in the platform, and add the platform."""
    service = service_url(request)

    def work() -> tuple[str, bool]:
        with database.write() as db:
            maker = dynamic.consume_registration_link(db, token)
        found = dynamic.read_configuration(federation.outgoing, openid_configuration[:2000])
        given = registration_token[:MAX_TOKEN]
        tool = dynamic.register_tool(federation.outgoing, found, given, service, service + KEYS_PATH)
        with database.write() as db:
            provider = dynamic.add_registered_platform(db, found, tool, maker)
            repository.record_activity(db, provider.id, ActivityKind.registration, utc_now())
        return found.issuer, bool(tool.deployments)

    try:
        issuer, is_complete = await federation.threads.run(REGISTRATION_PATH, work)
    except OutgoingError as error:
        reason = f"L’inscription a échoué : {error.reason}. Faites une autre adresse, et recommencez."
        raise FederationRefused("registration", reason) from error
    setattr(request.state, FRAMES_STATE, origin_of_url(issuer))
    return await run_in_threadpool(
        render_page, request, "platforms/registered.html", None, issuer=issuer, is_complete=is_complete
    )
