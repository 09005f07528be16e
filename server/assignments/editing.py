"""Create, update, delete and copy assignments, each recorded in the class's audit log.

Every function works inside the caller's transaction, on a class that the caller may change (`server.rights`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timedelta
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, safeguards, teams
from server.assignments.models import (
    AssignedExercise,
    Assignment,
    AttemptSelection,
    LatePolicy,
    Mode,
    PastRules,
    Visibility,
    WeightedExercise,
)
from server.assignments.schemas import AssignmentInput, validate_assignment
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import InvalidFields, NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.service import require_not_archived
from server.course import Course
from server.database import utc_now
from server.studio import service as studio

MAX_PAST_RULES = 100
#: How long a deletion can be undone.
RESTORABLE = timedelta(days=30)
UNKNOWN = "Ce devoir n’existe pas dans cette classe."
TEAMS_EXIST = (
    "Des élèves rendent ou ont rendu ce devoir à {count}, et cela reste compté : gardez au moins {count}. Pour "
    "que chacun rende désormais seul, défaites leurs équipes sur la page du devoir."
)


def find_assignment(
    db: Session, school_class: SchoolClass, assignment_id: UUID | str, *, to_change: bool = False
) -> Assignment:
    """Return an assignment; `to_change` locks the class until the commit. Raises NotFound."""
    if to_change:
        classes.lock_class(db, school_class.id)
    assignment = repository.find_assignment(db, school_class.id, parse_uuid(assignment_id, UNKNOWN))
    if assignment is None:
        raise NotFound(UNKNOWN)
    return assignment


def editable_fields(assignment: Assignment, exercises: Sequence[WeightedExercise]) -> AssignmentInput:
    """Return the editable fields of an assignment."""
    return AssignmentInput(
        title=assignment.title,
        exercises=tuple(exercises),
        opens_at=assignment.opens_at,
        due_at=assignment.due_at,
        closes_at=assignment.closes_at,
        late=LatePolicy(assignment.late),
        late_per_day=assignment.late_per_day,
        counts=AttemptSelection(assignment.counts),
        weight=assignment.weight,
        mode=Mode(assignment.mode),
        hints=Visibility(assignment.hints),
        diagnosis=Visibility(assignment.diagnosis),
        solution=Visibility(assignment.solution),
        duration_minutes=assignment.duration_minutes,
        groups=tuple(assignment.groups),
        team_size=assignment.team_size,
        teams_by_students=assignment.teams_by_students,
    )


def load_editable_fields(db: Session, assignment: Assignment) -> AssignmentInput:
    return editable_fields(assignment, repository.load_exercises(db, [assignment.id]).get(assignment.id, ()))


def load_assignable_titles(db: Session, course: Course, school_class: SchoolClass) -> Mapping[str, str]:
    """Return the titles of the exercises of the class's module by id, in the course's order; then its teachers' own."""
    module = course.modules.get(school_class.module)
    if module is None:
        return {}
    own = studio.list_exercises_of_class_teachers(db, school_class)
    return {exercise.id: exercise.title for exercise in module.exercises} | dict(own)


def load_groups(db: Session, school_class: SchoolClass) -> frozenset[str]:
    """Load the groups of a class: those of its active students."""
    students = classes.load_active_students(db, school_class.id)
    return frozenset(label for student in students for label in student.groups)


def create_assignment(
    db: Session, course: Course, school_class: SchoolClass, by: UUID, fields: AssignmentInput
) -> Assignment:
    """Create an assignment. Raises Conflict for an archived class, or InvalidFields."""
    require_not_archived(school_class)
    valid = validate_assignment(fields, load_assignable_titles(db, course, school_class), load_groups(db, school_class))
    assignment = _insert_assignment(db, school_class, by, valid)
    audit.record_event(
        db, school_class.id, by, AuditAction.assignment_made, about=valid.title, after=_audit_values(valid)
    )
    return assignment


def _insert_assignment(db: Session, school_class: SchoolClass, by: UUID, fields: AssignmentInput) -> Assignment:
    assignment = Assignment(class_id=school_class.id, created_by=by, **fields.row_columns())
    db.add(assignment)
    db.flush()
    _set_exercises(db, assignment, fields.exercises)
    return assignment


def _set_exercises(db: Session, assignment: Assignment, chosen: Sequence[WeightedExercise]) -> None:
    repository.delete_exercises(db, assignment.id)
    for position, (exercise, weight) in enumerate(chosen):
        db.add(AssignedExercise(assignment_id=assignment.id, exercise=exercise, weight=weight, position=position))
    db.flush()


def update_assignment(
    db: Session, course: Course, school_class: SchoolClass, by: UUID, assignment: Assignment, fields: AssignmentInput
) -> None:
    """Update an assignment; its exercises that have left the course may stay, and its groups that have become empty.

    Raises Conflict or InvalidFields.
    """
    require_not_archived(school_class)
    safeguards.lock_test(db, assignment)
    before = load_editable_fields(db, assignment)
    current = {exercise: exercise for exercise, _ in before.exercises}
    labels = {*load_groups(db, school_class), *before.groups}
    valid = validate_assignment(fields, current | dict(load_assignable_titles(db, course, school_class)), labels)
    if valid == before:
        return
    now = utc_now()
    safeguards.require_safe_test_change(db, assignment, before, valid, now)
    _require_allowed_team_size(db, assignment, before, valid)
    append_past_rules(assignment, valid, now)
    for name, value in valid.row_columns().items():
        setattr(assignment, name, value)
    if valid.exercises != before.exercises:
        _set_exercises(db, assignment, valid.exercises)
    db.flush()
    old, new = _audit_values(before), _audit_values(valid)
    audit.record_event(
        db, school_class.id, by, AuditAction.assignment_changed, about=valid.title, before=old, after=new
    )


def _require_allowed_team_size(
    db: Session, assignment: Assignment, before: AssignmentInput, after: AssignmentInput
) -> None:
    """Raise InvalidFields where more students hand in together, or have, than a change would allow."""
    largest = teams.load_largest_team_size(db, assignment.id) if after.team_size < before.team_size else 0
    if after.team_size < largest:
        raise InvalidFields({"team_size": TEAMS_EXIST.format(count=largest)})


def append_past_rules(assignment: Assignment, after: AssignmentInput, now: datetime) -> None:
    """Keep the rules on time that a change ends: attempts that arrived under them keep what they were told."""
    names = [each.name for each in dataclasses.fields(PastRules) if each.name != "until"]
    before = {name: getattr(assignment, name) for name in names}
    if before != {name: getattr(after, name) for name in names}:
        past = (*assignment.past_rules, PastRules(until=now, **before))
        assignment.past_rules = past[-MAX_PAST_RULES:]


def delete_assignment(db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment) -> None:
    """Delete an assignment, not the attempts; `restore_assignment` undoes it for a while.

    Raises Conflict, also while a test holds feedback.
    """
    require_not_archived(school_class)
    safeguards.lock_test(db, assignment)
    safeguards.require_no_withheld_feedback(db, assignment)
    before = _audit_values(load_editable_fields(db, assignment))
    exemptions = len(repository.load_active_exemptions(db, assignment.id))
    deleted = before | ({"exemptions": exemptions} if exemptions else {})
    audit.record_event(db, school_class.id, by, AuditAction.assignment_deleted, about=assignment.title, before=deleted)
    assignment.removed_at = utc_now()
    db.flush()


def restore_assignment(db: Session, school_class: SchoolClass, by: UUID, assignment_id: UUID | str) -> Assignment:
    """Undo the deletion of an assignment, with its exemptions and sittings. Raises NotFound, or Conflict for an
    archived class."""
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    wanted = parse_uuid(assignment_id, UNKNOWN)
    removed = repository.load_removed_assignments(db, school_class.id)
    assignment = next((assignment for assignment in removed if assignment.id == wanted), None)
    if assignment is None:
        return find_assignment(db, school_class, wanted)  # restored already, by a double click or another teacher
    assignment.removed_at = None
    values = _audit_values(load_editable_fields(db, assignment))
    audit.record_event(db, school_class.id, by, AuditAction.assignment_restored, about=assignment.title, after=values)
    return assignment


def purge_removed_assignments(db: Session, now: datetime) -> None:
    """Delete for good what was removed too long ago to be restored."""
    repository.purge_assignments_removed_before(db, now - RESTORABLE)


def copy_assignments(
    db: Session,
    original: SchoolClass,
    target: SchoolClass,
    by: UUID,
    shift_date: Callable[[datetime], datetime],
    map_exercise: Callable[[str], str | None],
) -> int:
    """Copy the assignments of a class into another, with shifted dates, without exemptions or released results.

    `map_exercise` finds an exercise in the target's module; exercises without one are left out, and so are assignments
    without any. Returns how many assignments were copied.
    """
    copied = 0
    assignments = repository.load_class_assignments(db, original.id)
    exercises = repository.load_exercises(db, [assignment.id for assignment in assignments])
    for assignment in assignments:
        fields = editable_fields(assignment, exercises.get(assignment.id, ()))
        columns = fields.row_columns()
        for name in ("opens_at", "due_at", "closes_at"):
            columns[name] = None if columns[name] is None else shift_date(columns[name])
        mapped = [(map_exercise(exercise), weight) for exercise, weight in fields.exercises]
        available = tuple(WeightedExercise(exercise, weight) for exercise, weight in mapped if exercise is not None)
        if available:
            copy = AssignmentInput(exercises=available, **columns)
            _insert_assignment(db, target, by, copy)
            audit.record_event(
                db, target.id, by, AuditAction.assignment_made, about=copy.title, after=_audit_values(copy)
            )
            copied += 1
    return copied


def find_uncopied_exercises(
    db: Session, school_class: SchoolClass, map_exercise: Callable[[str], str | None]
) -> Sequence[tuple[str, str]]:
    """Return what `copy_assignments` leaves out: pairs of an assignment's title and an exercise."""
    assignments = repository.load_class_assignments(db, school_class.id)
    exercises = repository.load_exercises(db, [assignment.id for assignment in assignments])
    return [
        (assignment.title, exercise)
        for assignment in assignments
        for exercise, _ in exercises.get(assignment.id, ())
        if map_exercise(exercise) is None
    ]


def _audit_values(fields: AssignmentInput) -> dict[str, Any]:
    """Return the values for the audit log, without None."""
    columns: dict[str, Any] = {
        name: value.value if isinstance(value, LatePolicy | AttemptSelection | Mode | Visibility) else value
        for name, value in fields.row_columns().items()
        if value is not None and value != ()
    }
    if fields.team_size == 1:
        del columns["team_size"], columns["teams_by_students"]
    return columns | {"exercises": dict(fields.exercises)}
