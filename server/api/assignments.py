"""Assignments of a class, and who is exempted from what."""

from collections.abc import Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from server.api.assignment_schemas import (
    AssignmentChange,
    AssignmentIn,
    AssignmentOut,
    ExceptionIn,
    ExceptionOut,
    Lateness,
    PerDay,
    RulesOut,
    SaidOut,
    WeightedIn,
)
from server.api.documentation import problem_responses
from server.assignments import editing, exemption_service, repository, student_assignments
from server.assignments.exemption_service import explain_rules, find_exemption
from server.assignments.models import Assignment, Exemption, LatePolicy, WeightedExercise
from server.assignments.schemas import AssignmentInput, ExemptionInput, ExemptionTarget
from server.assignments.student_assignments import StudentAssignment
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import team_rules_in_force
from server.base import root_path
from server.base.errors import Forbidden, NotFound
from server.classes import repository as classes
from server.classes.models import Membership
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import Db
from server.identity.dependencies import ApiAccount
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.text.lines import normalise_line
from server.web.time_warnings import load_time_warnings

router = APIRouter(tags=["assignments"])

ALL = "/classes/{class_id}/assignments"
ONE = "/classes/{class_id}/assignments/{aid}"
OTHERS = "Les règles d’un autre élève ne se lisent pas."


def _lateness_of_policy(late: str, per_day: float | None) -> Lateness:
    return PerDay(per_day=per_day or 0.0) if late == LatePolicy.penalty else late  # type: ignore[return-value]


def _late_policy_fields(late: Lateness) -> dict[str, Any]:
    if isinstance(late, PerDay):
        return {"late": LatePolicy.penalty, "late_per_day": late.per_day}
    return {"late": LatePolicy(late), "late_per_day": None}


def _weighted_exercises(chosen: list[WeightedIn]) -> tuple[WeightedExercise, ...]:
    return tuple(WeightedExercise(exercise.exercise, exercise.weight) for exercise in chosen)


def _assignment_out(assignment: Assignment, fields: AssignmentInput, **in_force: Any) -> AssignmentOut:
    """`in_force` is what a student sees otherwise."""
    columns = fields.row_columns()
    columns["late"], columns["groups"] = (
        _lateness_of_policy(fields.late, columns.pop("late_per_day")),
        list(fields.groups),
    )
    told = {
        "exercises": [WeightedIn(exercise=exercise.exercise, weight=exercise.weight) for exercise in fields.exercises],
        "time_factor": None,
        "excused": None,
        **columns,
        **in_force,
    }
    url = root_path.external_path(f"/api/v1/classes/{assignment.class_id}/assignments/{assignment.id}")
    return AssignmentOut(id=assignment.id, released_at=assignment.released_at, url=url, **told)


def _own_assignment_out(assigned: StudentAssignment) -> AssignmentOut:
    rules = assigned.rules
    told = {name: getattr(rules, name) for name in ("opens_at", "due_at", "closes_at", "time_factor", "excused")}
    told["groups"] = None
    if assigned.hides_exercises:
        told["exercises"] = None
    return _assignment_out(
        assigned.assignment, editing.editable_fields(assigned.assignment, assigned.exercises), **told
    )


@router.post(ALL, status_code=201, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def create(class_id: str, body: AssignmentIn, account: ApiAccount, course: CourseOf, db: Db) -> AssignmentOut:
    """Gives the class something to do."""
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    told = {name: getattr(body, name) for name in AssignmentIn.model_fields} | _late_policy_fields(body.late)
    told |= {
        "exercises": _weighted_exercises(body.exercises),
        "opens_at": body.opens_at or utc_now(),
        "groups": tuple(body.groups),
    }
    made = editing.create_assignment(db, course, place.school_class, account.id, AssignmentInput(**told))
    warnings = list(load_time_warnings(db, made))
    return _assignment_out(made, editing.load_editable_fields(db, made), warnings=warnings)


@router.get(ALL, responses=problem_responses(401, 403, 404))
def list_assignments(class_id: str, account: ApiAccount, db: Db) -> list[AssignmentOut]:
    """All of the class, in the order in which they open; a student's with their own dates."""
    place = rights.require_right(db, account, Right.see_assignments, class_id)
    if not place.has(Right.see_students):
        seat = _membership_of_student(place)
        return [
            _own_assignment_out(assigned)
            for assigned in student_assignments.load_assignments_for_student(
                db, seat.class_id, account.id, seat.groups, utc_now()
            )
        ]
    rows = repository.load_class_assignments(db, place.school_class.id)
    exercises = repository.load_exercises(db, [assignment.id for assignment in rows])
    return [
        _assignment_out(assignment, editing.editable_fields(assignment, exercises.get(assignment.id, ())))
        for assignment in rows
    ]


def _membership_of_student(place: ClassAccess) -> Membership:
    """Who is none of the staff has one."""
    assert place.membership is not None
    return place.membership


@router.get(ONE, responses=problem_responses(401, 403, 404))
def read(class_id: str, aid: str, account: ApiAccount, db: Db) -> AssignmentOut:
    """One assignment; a student's with their own dates."""
    place = rights.require_right(db, account, Right.see_assignments, class_id)
    assignment = editing.find_assignment(db, place.school_class, aid)
    if place.has(Right.see_students):
        warnings = list(load_time_warnings(db, assignment))
        return _assignment_out(assignment, editing.load_editable_fields(db, assignment), warnings=warnings)
    return _own_assignment_out(
        student_assignments.load_student_assignment(
            db, assignment, account.id, _membership_of_student(place).groups, utc_now()
        )
    )


@router.patch(ONE, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def change(
    class_id: str, aid: str, body: AssignmentChange, account: ApiAccount, course: CourseOf, db: Db
) -> AssignmentOut:
    """Changes what is sent, and leaves the rest. What students have sent stays."""
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    assignment = editing.find_assignment(db, place.school_class, aid, to_change=True)
    before = editing.load_editable_fields(db, assignment)
    told: dict[str, Any] = {**before.row_columns(), "exercises": before.exercises}
    told |= {name: getattr(body, name) for name in body.model_fields_set}
    if "late" in body.model_fields_set:
        told |= _late_policy_fields(body.late)
    if "exercises" in body.model_fields_set:
        told["exercises"] = _weighted_exercises(body.exercises)
    told["opens_at"], told["groups"] = told["opens_at"] or utc_now(), tuple(told["groups"])
    editing.update_assignment(db, course, place.school_class, account.id, assignment, AssignmentInput(**told))
    warnings = list(load_time_warnings(db, assignment))
    return _assignment_out(assignment, editing.load_editable_fields(db, assignment), warnings=warnings)


@router.delete(ONE, status_code=204, responses=problem_responses(401, 403, 404, 409))
def delete(class_id: str, aid: str, account: ApiAccount, db: Db) -> Response:
    """Takes the assignment back, with its exceptions. What students have sent stays."""
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    editing.delete_assignment(
        db, place.school_class, account.id, editing.find_assignment(db, place.school_class, aid, to_change=True)
    )
    return Response(status_code=204)


@router.post(f"{ONE}/exceptions", status_code=201, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def exempt(class_id: str, aid: str, body: ExceptionIn, account: ApiAccount, db: Db) -> ExceptionOut:
    """Has something differ for a student or a group."""
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    assignment = editing.find_assignment(db, place.school_class, aid, to_change=True)
    effect = ExemptionInput(
        body.opens_at, body.due_at, body.closes_at, body.time_factor, body.excused, normalise_line(body.reason)
    )
    whom = ExemptionTarget((body.student,) if body.student else (), normalise_line(body.group or ""))
    members = classes.load_members(db, place.school_class.id)
    (made,) = exemption_service.grant_exemptions(db, place.school_class, account.id, assignment, members, whom, effect)
    return _exception_out(made, list(load_time_warnings(db, assignment)))


def _exception_out(exemption: Exemption, warnings: Sequence[str] = ()) -> ExceptionOut:
    return ExceptionOut(
        id=exemption.id,
        student=exemption.account_id,
        group=exemption.label,
        opens_at=exemption.opens_at,
        due_at=exemption.due_at,
        closes_at=exemption.closes_at,
        time_factor=exemption.time_factor,
        excused=exemption.excused,
        reason=exemption.reason,
        created_at=exemption.created_at,
        revoked_at=exemption.revoked_at,
        warnings=list(warnings),
    )


@router.get(f"{ONE}/exceptions", responses=problem_responses(401, 403, 404))
def list_exceptions(class_id: str, aid: str, account: ApiAccount, db: Db) -> list[ExceptionOut]:
    """All that were made, oldest first; those revoked too."""
    place = rights.require_right(db, account, Right.see_students, class_id)
    assignment = editing.find_assignment(db, place.school_class, aid)
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    return [_exception_out(exemption) for exemption in exemptions]


@router.delete(f"{ONE}/exceptions/{{eid}}", status_code=204, responses=problem_responses(401, 403, 404, 409))
def revoke(class_id: str, aid: str, eid: str, account: ApiAccount, db: Db) -> Response:
    """Takes an exception back; it stays in the list, revoked."""
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    assignment = editing.find_assignment(db, place.school_class, aid, to_change=True)
    exemption_service.revoke_exemption(
        db, place.school_class, account.id, assignment, find_exemption(db, assignment, eid)
    )
    return Response(status_code=204)


@router.get(f"{ONE}/rules", responses=problem_responses(401, 403, 404))
def read_rules(
    class_id: str,
    aid: str,
    account: ApiAccount,
    db: Db,
    student: Annotated[str, Query(max_length=100, description="`id` of a student; oneself, where it is empty.")] = "",
) -> RulesOut:
    """The rules in force for a student, and why; one's own, for who is one."""
    place = rights.require_right(db, account, Right.see_assignments, class_id)
    assignment = editing.find_assignment(db, place.school_class, aid)
    seat = _find_student_for_rules(db, place, account, student)
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    places = load_places_of_team_assignments(db, [assignment]).get(assignment.id, ())
    rules = team_rules_in_force(assignment, exemptions, seat.account_id, seat.groups, places)
    staff = place.has(Right.see_students)
    if not staff:
        student_assignments.load_student_assignment(db, assignment, seat.account_id, seat.groups, utc_now())
    why = {
        name: [
            SaidOut(
                origin=value.origin,
                value=value.value,
                group=value.label or None,
                reason=value.reason if staff and value.by is not None else None,
            )
            for value in said
        ]
        for name, said in explain_rules(rules, exemptions, seat.account_id).items()
    }
    return RulesOut(
        student=seat.account_id,
        opens_at=rules.opens_at,
        due_at=rules.due_at,
        closes_at=rules.closes_at,
        late=_lateness_of_policy(rules.late, rules.late_per_day),
        time_factor=rules.time_factor,
        excused=rules.excused,
        duration_seconds=None if rules.duration is None else rules.duration.total_seconds(),
        why=why,
    )


def _find_student_for_rules(db: Db, place: ClassAccess, account: Account, name: str) -> Membership:
    """The student whom it is about. Raises NotFound, or Forbidden for another's rules."""
    wanted = name.lower() or str(account.id)
    if not place.has(Right.see_students):
        if wanted != str(account.id):
            raise Forbidden(OTHERS)
        return _membership_of_student(place)
    members = exemption_service.filter_active_students(classes.load_members(db, place.school_class.id))
    for member in members:
        if str(member.id) == wanted:
            return member.membership
    raise NotFound(exemption_service.NO_STUDENT)
