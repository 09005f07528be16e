"""The list of a course of a platform: what it would change in the class, then the seats that it gives."""

from __future__ import annotations

from typing import Any
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from server.classes.service import require_not_archived
from server.course.dependencies import CourseOf
from server.database import Database, utc_now
from server.database.dependencies import DatabaseOf
from server.desk.school.routes import SCHOOL_PATH, find_context
from server.desk.views import class_head
from server.federation import repository, roster_plan
from server.federation.arrivals import ROLE_WORDS
from server.federation.dependencies import FederationOf
from server.federation.errors import OutgoingError
from server.federation.lti.access_tokens import AccessTokenCache
from server.federation.lti.memberships import fetch_people
from server.federation.models import ActivityKind, IdentityProvider, ProviderContext
from server.federation.roster_plan import RosterPlan
from server.federation.schemas import SignedPerson
from server.federation.service import Federation
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.web.forms import Field, redirect
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

ROSTER_PATH = f"{SCHOOL_PATH}/liste"


@router.post(ROSTER_PATH)
async def import_roster(
    request: Request,
    class_id: str,
    account: SignedIn,
    database: DatabaseOf,
    course: CourseOf,
    federation: FederationOf,
    cours: Field = "",
    attendu: Field = "",
) -> Response:
    """Shows what the list would change; with `attendu`, the digest of what was shown, gives the seats."""
    context, provider = await run_in_threadpool(_require_course, database, account, class_id, cours)
    people, problem = await federation.threads.run(
        provider.id, lambda: _fetch_roster(database, federation, provider, context)
    )

    def answer() -> Response:
        if attendu and not problem:
            with database.write() as db:
                access = rights.require_right(db, account, Right.manage_roster, class_id)
                plan = roster_plan.plan_roster(db, provider, access.school_class, people)
                if plan.digest == attendu:
                    roster_plan.enrol_planned_people(db, provider, access.school_class, plan, account)
                    return redirect(f"/classes/{access.school_class.id}/eleves")
        with database.read() as db:
            access = rights.require_right(db, account, Right.manage_roster, class_id)
            plan = roster_plan.plan_roster(db, provider, access.school_class, people)
            head = class_head(course, access, "/reglages")
        page = _render_roster_page(head, context, provider, plan, problem, is_again=bool(attendu))
        return render_page(request, "classes/school_list.html", account, status=422 if problem else 200, page=page)

    return await run_in_threadpool(answer)


def _require_course(
    database: Database, account: Account, class_id: str, name: str
) -> tuple[ProviderContext, IdentityProvider]:
    """Return a course that is tied to the class, with its platform. Raises Forbidden, NotFound or Conflict."""
    with database.read() as db:
        access = rights.require_right(db, account, Right.manage_roster, class_id)
        require_not_archived(access.school_class)
        context = find_context(db, access.school_class, name)
        provider = repository.find_provider(db, context.provider_id)
        assert provider is not None, "a course has its platform"
        return context, provider


def _fetch_roster(
    database: Database, federation: Federation, provider: IdentityProvider, context: ProviderContext
) -> tuple[list[SignedPerson], str]:
    """Return the people of a course, or the reason why the platform does not list them."""
    people, problem = list[SignedPerson](), ""
    try:
        people = list(fetch_people(AccessTokenCache(database, federation.outgoing), provider, context))
    except OutgoingError as error:
        problem = error.reason
    with database.write() as db:
        _record_roster_reading(db, provider.id, len(people), problem)
    return people, problem


def _record_roster_reading(db: Any, provider_id: UUID, people: int, problem: str) -> None:
    detail = problem or f"{people} personnes"
    repository.record_activity(db, provider_id, ActivityKind.roster, utc_now(), detail, succeeded=not problem)


def _render_roster_page(
    head: Any, context: ProviderContext, provider: IdentityProvider, plan: RosterPlan, problem: str, *, is_again: bool
) -> dict[str, Any]:
    rows = [(person.name or person.given_name or "sans nom", ROLE_WORDS[person.role]) for person in plan.entering]
    return {
        "head": head,
        "course": context,
        "platform": provider.name,
        "rows": sorted(rows),
        "plan": plan,
        "problem": problem,
        "again": is_again,
    }
