"""Pages of regrades: what was sent is graded anew, shown, then applied or undone."""

import json
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Form, Query, Request
from fastapi.responses import Response, StreamingResponse
from starlette.concurrency import run_in_threadpool

from server.base.errors import NotFound, ServiceError
from server.classes.service import require_not_archived
from server.course.dependencies import CourseOf
from server.database import Database, roll_back_then_read
from server.database.dependencies import DatabaseOf, Db
from server.desk.regrades.views import build_regrade_page, build_regrades_page, progress_text, regrade_href
from server.identity.dependencies import OptionalAccount, SignedIn
from server.identity.models import Account
from server.regrades import applying, service
from server.regrades.dependencies import RegradeServiceOf
from server.regrades.models import Regrade, RegradePolicy
from server.regrades.schemas import RegradeInput, RegradeProgress
from server.rights import service as rights
from server.rights.models import Right
from server.submissions.dependencies import JobEventsOf
from server.submissions.job_events import REFRESH_SECONDS, STREAM_HEADERS, stream_sse
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

NOT_OFFERED = "Ce choix n’est pas proposé."


@dataclass(frozen=True)
class RegradeFormValues:
    """The values of the form, and why it is refused."""

    exercise: str = ""
    policy: str = "keep_best"
    assignment: str = ""
    student: str = ""
    problem: str = ""


ShortQuery = Annotated[str, Query(max_length=200)]


@router.get("/classes/{class_id}/recalculs")
def list_regrades(
    request: Request, class_id: str, reader: CurrentReader, store: RegradeServiceOf, exercice: ShortQuery = ""
) -> Response:
    """`exercice` is chosen in the form, for who comes from a page about it."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.regrade, class_id)
    view = build_regrades_page(reader.db, reader.course, access, store)
    return render_page(request, "classes/regrades.html", reader.account, page=view, chosen=RegradeFormValues(exercice))


@router.post("/classes/{class_id}/recalculs")
def prepare_regrade(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, store: RegradeServiceOf,
    exercice: Field = "",
    regle: Field = "keep_best",
    devoir: Field = "",
    eleve: Field = "",
) -> Response:  # fmt: skip
    access = rights.require_right(db, account, Right.regrade, class_id)
    try:
        if regle not in set(RegradePolicy):
            raise NotFound(NOT_OFFERED)
        wanted = RegradeInput(exercice, RegradePolicy(regle), _parse_optional_id(devoir), _parse_optional_id(eleve))
        made = store.start_regrade(db, access.school_class, account.id, wanted)
    except ServiceError as refused:
        roll_back_then_read(db)
        chosen = RegradeFormValues(exercice, regle, devoir, eleve, refused.detail)
        view, status = build_regrades_page(db, course, access, store), int(refused.status)
        return render_page(request, "classes/regrades.html", account, status=status, page=view, chosen=chosen)
    return redirect(regrade_href(made))


def _parse_optional_id(name: str) -> UUID | None:
    """Raises NotFound."""
    try:
        return UUID(name) if name else None
    except ValueError as error:
        raise NotFound(NOT_OFFERED) from error


@router.get("/classes/{class_id}/recalculs/{regrade_id}")
def show_regrade(request: Request, class_id: str, regrade_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.regrade, class_id)
    regrade = service.find_regrade(reader.db, access.school_class.id, regrade_id)
    view = build_regrade_page(reader.db, reader.course, access, regrade)
    return render_page(request, "classes/regrade.html", reader.account, page=view, problem="")


@router.post("/classes/{class_id}/recalculs/{regrade_id}")
def change_regrade(
    request: Request, class_id: str, regrade_id: str, account: SignedIn, db: Db, course: CourseOf,
    action: Annotated[str, Form()] = "",
) -> Response:  # fmt: skip
    """Applies it, undoes it, or stops it."""
    access = rights.require_right(db, account, Right.regrade, class_id)
    regrade = service.find_regrade(db, access.school_class.id, regrade_id)
    try:
        require_not_archived(access.school_class)
        _perform_action(action, db, course, regrade, account)
    except ServiceError as refused:
        if isinstance(refused, NotFound):
            raise
        roll_back_then_read(db)
        view, status = build_regrade_page(db, course, access, regrade), int(refused.status)
        return render_page(request, "classes/regrade.html", account, status=status, page=view, problem=refused.detail)
    return redirect(regrade_href(regrade))


def _perform_action(action: str, db: Db, course: CourseOf, regrade: Regrade, account: Account) -> None:
    """Raises NotFound or Conflict."""
    if action == "appliquer":
        applying.apply_regrade(db, course, regrade.id, account.id)
    elif action == "annuler":
        applying.undo_regrade(db, course, regrade.id, account.id)
    elif action == "arreter":
        service.stop_regrade(db, regrade.id)
    else:
        raise NotFound(UNKNOWN_ACTION)


@router.get("/classes/{class_id}/recalculs/{regrade_id}/evenements")
async def stream_progress(
    class_id: str, regrade_id: str, account: OptionalAccount, database: DatabaseOf, hub: JobEventsOf
) -> StreamingResponse:
    """How far it is, until it is over."""

    def read() -> RegradeProgress:
        return _load_progress(database, account, class_id, regrade_id)

    await run_in_threadpool(read)  # a refusal must come before the stream begins
    snapshots = hub.follow(str(UUID(regrade_id)), read, also_watches_all_jobs=True, find_rest=lambda: REFRESH_SECONDS)
    lines: AsyncIterator[str] = stream_sse(snapshots, _progress_json, name="progress")
    return StreamingResponse(lines, media_type="text/event-stream", headers=STREAM_HEADERS)


def _load_progress(database: Database, account: Account | None, class_id: str, regrade_id: str) -> RegradeProgress:
    if account is None:
        raise NotFound(service.UNKNOWN)
    with database.read() as db:
        access = rights.require_right(db, account, Right.regrade, class_id)
        return service.load_regrade_progress(db, service.find_regrade(db, access.school_class.id, regrade_id))


def _progress_json(advance: RegradeProgress) -> str:
    return json.dumps(
        {
            "done": advance.done,
            "graded": advance.graded,
            "total": advance.total,
            "text": progress_text(advance),
        }
    )
