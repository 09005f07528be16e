"""Marks of a class: set, taken away as files, and the log of what was changed."""

from dataclasses import asdict, replace
from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Query, Response
from fastapi.responses import JSONResponse

from server.api.documentation import Responses, problem_responses
from server.api.mark_schemas import (
    EventOut,
    GradebookOut,
    LogOut,
    MarkingIn,
    MarkingOut,
    MarkOut,
    NewDecision,
    NewMark,
    StudentDecision,
)
from server.audit import repository as audit
from server.audit.models import AuditAction
from server.audit.schemas import AuditEntry, AuditFilter
from server.base.validation import parse_uuid
from server.classes.service import NOT_A_MEMBER
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import Db
from server.identity.dependencies import ApiAccount
from server.marks import decisions, plain_values, service
from server.marks import repository as marks
from server.marks.downloads import GradebookFormat, render_download
from server.marks.files import MoodleIdentifier
from server.marks.loading import load_gradebook, load_unassigned_mark
from server.marks.schemas import Gradebook
from server.marks.states import ClassMarking, Counting
from server.rights import service as rights
from server.rights.models import Right
from server.web.words import format_short_time

router = APIRouter(tags=["marks"])

MOST_EVENTS = 500
DECISION = "/classes/{class_id}/assignments/{aid}/decisions/{student}"
MARKING = "/classes/{class_id}/marking"
Scope = Annotated[UUID | None, Query(description="The only assignment concerned; without it, all.")]
BINARY = {"schema": {"type": "string", "format": "binary"}}
FILES: Responses = {
    200: {
        "description": "The gradebook.",
        "content": dict.fromkeys(("text/csv", GradebookFormat.xlsx.media_type), BINARY),
    }
}  # fmt: skip


@router.put(
    "/classes/{class_id}/marks/{student}/{module}/{slug}",
    responses=problem_responses(400, 401, 403, 404, 409, 413, 422),
)
def set_mark(
    class_id: str, student: str, module: str, slug: str, body: NewMark, account: ApiAccount, course: CourseOf, db: Db,
    assignment: Scope = None,
) -> MarkOut:  # fmt: skip
    """Sets a student's mark at an exercise in place of the automatic one, which is kept beside it.

    With `assignment`, the mark holds in that assignment alone; without, in all that ask the exercise.
    """
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
        assignment_id=assignment,
    )
    gradebook = load_gradebook(db, course, place.school_class, utc_now(), [who])
    return MarkOut.model_validate(
        {"student": who, "mark": _exercise_mark_json(db, gradebook, who, exercise, assignment)}
    )


def _exercise_mark_json(
    db: Db, gradebook: Gradebook, who: UUID, exercise: str, assignment_id: UUID | None
) -> dict[str, Any]:
    """Return the mark in that assignment, else in the first one that asks the exercise, else of all attempts."""
    for row in gradebook.rows:
        for assignment, mark in zip(gradebook.assignments, row.marks, strict=True):
            for exercise_mark in mark.exercises:
                if exercise_mark.exercise == exercise and assignment_id in {None, assignment.id}:
                    return plain_values.exercise_mark_json(exercise_mark, mark.state)
    return plain_values.exercise_mark_json(load_unassigned_mark(db, gradebook.school_class, who, exercise))


@router.delete(
    "/classes/{class_id}/marks/{student}/{module}/{slug}",
    status_code=204,
    response_class=Response,
    responses=problem_responses(401, 403, 404, 409),
)
def withdraw_mark(
    class_id: str, student: str, module: str, slug: str, account: ApiAccount, course: CourseOf, db: Db,
    assignment: Scope = None,
) -> Response:  # fmt: skip
    """Withdraws the mark of that scope: what it replaced is in force again."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    who, exercise = parse_uuid(student, NOT_A_MEMBER), f"{module}/{slug}"
    service.withdraw_override(db, course, place.school_class, account, who, exercise, assignment_id=assignment)
    return Response(status_code=204)


@router.put(DECISION, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def decide_state(
    class_id: str, aid: str, student: str, body: NewDecision, account: ApiAccount, db: Db
) -> StudentDecision:
    """Says of a student's whole assignment: absent, excused, or zero. What was sent stays, and counts no more."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    who, assignment = parse_uuid(student, NOT_A_MEMBER), parse_uuid(aid, service.NO_SUCH_ASSIGNMENT)
    decisions.set_state_decision(db, place.school_class, account, who, assignment, body.state, body.reason)
    decision = plain_values.decision_json(
        marks.load_active_decisions(db, place.school_class.id, [who])[who, assignment]
    )
    return StudentDecision.model_validate({"assignment": assignment, "student": who, "decision": decision})


@router.delete(DECISION, status_code=204, response_class=Response, responses=problem_responses(401, 403, 404, 409))
def withdraw_decision(class_id: str, aid: str, student: str, account: ApiAccount, db: Db) -> Response:
    """Withdraws the decision: what was sent counts again."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    who, assignment = parse_uuid(student, NOT_A_MEMBER), parse_uuid(aid, service.NO_SUCH_ASSIGNMENT)
    decisions.withdraw_state_decision(db, place.school_class, account, who, assignment)
    return Response(status_code=204)


@router.get(MARKING, responses=problem_responses(401, 403, 404))
def read_marking(class_id: str, account: ApiAccount, db: Db) -> MarkingOut:
    """How states without points count in the means of the class."""
    place = rights.require_right(db, account, Right.read_marks, class_id)
    return _marking_out(marks.load_marking_rules(db, place.school_class.id))


@router.patch(MARKING, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def choose_marking(class_id: str, body: MarkingIn, account: ApiAccount, db: Db) -> MarkingOut:
    """Chooses how they count. Marks stay as they are; means are computed anew."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    chosen = {name: Counting(value) for name, value in body.model_dump(exclude={"version"}).items() if value}
    rules = replace(marks.load_marking_rules(db, place.school_class.id).rules, **chosen)
    return _marking_out(decisions.set_marking_rules(db, place.school_class, account, rules, body.version))


def _marking_out(marking: ClassMarking) -> MarkingOut:
    values = {**asdict(marking.rules), "chosen": marking.is_chosen, "version": marking.version}
    return MarkingOut.model_validate(values)


@router.get(
    "/classes/{class_id}/gradebook",
    response_model=GradebookOut,
    responses={**FILES, **problem_responses(401, 403, 404, 422)},
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
        content = GradebookOut.model_validate(plain_values.gradebook_json(made))
        return JSONResponse(
            content.model_dump(mode="json", by_alias=True), headers={"Cache-Control": "private, no-store"}
        )
    file = render_download(made, format, identifier, format_short_time)
    return Response(file.content, media_type=file.media_type, headers=file.headers)


@router.get("/classes/{class_id}/audit", responses=problem_responses(401, 403, 404, 422))
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
    return LogOut(total=total, events=[_event_out(entry) for entry in some])


def _event_out(entry: AuditEntry) -> EventOut:
    return EventOut.model_validate({**asdict(entry), "words": entry.words})
