"""Marks of a class: set, taken away as files, and the log of what was changed."""

from dataclasses import asdict
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Response
from fastapi.responses import JSONResponse

from server.api.documentation import Responses, problems
from server.api.mark_schemas import EventOut, GradebookOut, LogOut, MarkOut, NewMark
from server.audit import repository as audit
from server.audit.models import AuditAction
from server.audit.schemas import AuditEntry, AuditFilter
from server.base.validation import parse_uuid
from server.classes.service import NOT_A_MEMBER
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import Db
from server.identity.dependencies import ApiAccount
from server.marks import files, service
from server.marks.downloads import GradebookFormat, render_download
from server.marks.files import MoodleIdentifier
from server.marks.loading import load_gradebook
from server.rights import service as rights
from server.rights.models import Right
from server.web.words import short_moment

router = APIRouter(tags=["marks"])

MOST_EVENTS = 500
BINARY = {"schema": {"type": "string", "format": "binary"}}
FILES: Responses = {
    200: {
        "description": "The gradebook.",
        "content": dict.fromkeys(("text/csv", GradebookFormat.xlsx.media_type), BINARY),
    }
}  # fmt: skip


@router.put(
    "/classes/{class_id}/marks/{student}/{module}/{slug}", responses=problems(400, 401, 403, 404, 409, 413, 422)
)
def set_mark(
    class_id: str, student: str, module: str, slug: str, body: NewMark, account: ApiAccount, course: CourseOf, db: Db
) -> MarkOut:
    """Sets a student's mark at an exercise in place of the automatic one, which is kept beside it."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    who, exercise = parse_uuid(student, NOT_A_MEMBER), f"{module}/{slug}"
    service.set_override(
        db,
        course,
        place.school_class,
        account,
        who,
        exercise,
        points=body.points,
        excused=body.excused,
        reason=body.reason,
    )
    mark = service.load_exercise_marks(db, course, place.school_class, who, exercise)[0]
    return MarkOut.model_validate({"student": who, "mark": files.exercise_mark_json(mark)})


@router.delete(
    "/classes/{class_id}/marks/{student}/{module}/{slug}",
    status_code=204,
    response_class=Response,
    responses=problems(401, 403, 404, 409),
)
def withdraw_mark(
    class_id: str, student: str, module: str, slug: str, account: ApiAccount, course: CourseOf, db: Db
) -> Response:
    """Puts the automatic mark in force again."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    service.withdraw_override(
        db, course, place.school_class, account, parse_uuid(student, NOT_A_MEMBER), f"{module}/{slug}"
    )
    return Response(status_code=204)


@router.get(
    "/classes/{class_id}/gradebook",
    response_model=GradebookOut,
    responses={**FILES, **problems(401, 403, 404, 422)},
)
def gradebook(
    class_id: str,
    account: ApiAccount,
    course: CourseOf,
    db: Db,
    format: Annotated[
        GradebookFormat, Query(description="`csv` is for a French Excel, `moodle` for Moodle's import.")
    ] = (GradebookFormat.json),
    identifier: Annotated[
        MoodleIdentifier, Query(description="By what Moodle knows its students.")
    ] = MoodleIdentifier.email,
) -> Response:
    """The marks of all students. Moodle's file has those that are final alone, and leaves out who has no identifier:
    `X-Balise-Left-Out` says how many."""
    place = rights.require_right(db, account, Right.read_marks, class_id)
    made = load_gradebook(db, course, place.school_class, utc_now())
    if format is GradebookFormat.json:
        content = GradebookOut.model_validate(files.gradebook_json(made))
        return JSONResponse(
            content.model_dump(mode="json", by_alias=True), headers={"Cache-Control": "private, no-store"}
        )
    file = render_download(made, format, identifier, short_moment)
    return Response(file.content, media_type=file.media_type, headers=file.headers)


@router.get("/classes/{class_id}/audit", responses=problems(401, 403, 404, 422))
def log(
    class_id: str,
    account: ApiAccount,
    db: Db,
    student: Annotated[UUID | None, Query(description="Of one student alone.")] = None,
    what: Annotated[AuditAction | None, Query(description="Of one kind alone.")] = None,
    skip: Annotated[int, Query(ge=0, le=10**9, description="Leaves out so many of the newest.")] = 0,
    limit: Annotated[int, Query(ge=1, le=MOST_EVENTS, description="How many at most.")] = MOST_EVENTS,
) -> LogOut:
    """Every change of a mark, a date or a right, newest first: who, when, what, before and after."""
    place = rights.require_right(db, account, Right.read_audit_log, class_id)
    wanted = AuditFilter(student, what)
    some = audit.load_entries(db, place.school_class.id, wanted, limit=limit, offset=skip)
    total = audit.count_entries(db, place.school_class.id, wanted)
    return LogOut(total=total, events=[_event(entry) for entry in some])


def _event(entry: AuditEntry) -> EventOut:
    return EventOut.model_validate({**asdict(entry), "words": entry.words})
