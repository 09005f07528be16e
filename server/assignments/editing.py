"""Making, changing, deleting and copying assignments, each noted in the class's log.

Every function works inside the caller's transaction, on a class that the caller may change (`server.rights`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, safeguards
from server.assignments.models import (
    AssignedExercise,
    Assignment,
    AttemptSelection,
    LatePolicy,
    Mode,
    Visibility,
    WeightedExercise,
)
from server.assignments.schemas import AssignmentInput, Weighted, validate_assignment
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.service import require_open
from server.course import Course
from server.database import utc_now

UNKNOWN = "Ce devoir n’existe pas dans cette classe."


def find_assignment(
    db: Session, school_class: SchoolClass, assignment_id: UUID | str, *, to_change: bool = False
) -> Assignment:
    """`to_change`: until the commit, nobody else changes an assignment of the class. Raises NotFound."""
    if to_change:
        classes.lock_class(db, school_class.id)
    found = repository.find_assignment(db, school_class.id, parse_uuid(assignment_id, UNKNOWN))
    if found is None:
        raise NotFound(UNKNOWN)
    return found


def assignment_input(assignment: Assignment, exercises: Sequence[WeightedExercise]) -> AssignmentInput:
    """What is set of an assignment, to be changed."""
    return AssignmentInput(
        title=assignment.title,
        exercises=tuple(Weighted(one.exercise, one.weight) for one in exercises),
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
    )


def load_assignment_input(db: Session, assignment: Assignment) -> AssignmentInput:
    return assignment_input(assignment, repository.load_exercises(db, [assignment.id]).get(assignment.id, ()))


def assignable_exercises(course: Course, school_class: SchoolClass) -> Mapping[str, str]:
    """Those that one may give to the class, by their titles, in the course's order."""
    module = course.modules.get(school_class.module)
    return {} if module is None else {exercise.id: exercise.title for exercise in module.exercises}


def create_assignment(
    db: Session, course: Course, school_class: SchoolClass, by: UUID, wanted: AssignmentInput
) -> Assignment:
    """Raises Conflict for an archived class, FieldsRefused."""
    require_open(school_class)
    good = validate_assignment(wanted, assignable_exercises(course, school_class))
    made = _added(db, school_class, by, good)
    audit.record_event(db, school_class.id, by, AuditAction.assignment_made, about=good.title, after=_told(good))
    return made


def _added(db: Session, school_class: SchoolClass, by: UUID, wanted: AssignmentInput) -> Assignment:
    made = Assignment(class_id=school_class.id, created_by=by, **wanted.columns())
    db.add(made)
    db.flush()
    _set_exercises(db, made, wanted.exercises)
    return made


def _set_exercises(db: Session, assignment: Assignment, chosen: Sequence[Weighted]) -> None:
    repository.delete_exercises(db, assignment.id)
    for position, one in enumerate(chosen):
        row = {"exercise": one.exercise, "weight": one.weight, "position": position}
        db.add(AssignedExercise(assignment_id=assignment.id, **row))
    db.flush()


def update_assignment(
    db: Session, course: Course, school_class: SchoolClass, by: UUID, assignment: Assignment, wanted: AssignmentInput
) -> None:
    """What it had of exercises that have left the course may stay. Raises Conflict, FieldsRefused."""
    require_open(school_class)
    safeguards.lock_test(db, assignment)
    before = load_assignment_input(db, assignment)
    kept = {one.exercise: one.exercise for one in before.exercises}
    good = validate_assignment(wanted, kept | dict(assignable_exercises(course, school_class)))
    if good == before:
        return
    safeguards.require_coherent(db, assignment, before, good, utc_now())
    for name, value in good.columns().items():
        setattr(assignment, name, value)
    if good.exercises != before.exercises:
        _set_exercises(db, assignment, good.exercises)
    db.flush()
    old, new = _told(before), _told(good)
    audit.record_event(db, school_class.id, by, AuditAction.assignment_changed, about=good.title, before=old, after=new)


def delete_assignment(db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment) -> None:
    """Its exemptions go with it; what students have sent stays. Raises Conflict, also while a test holds something."""
    require_open(school_class)
    safeguards.lock_test(db, assignment)
    safeguards.require_nothing_held(db, assignment)
    before = _told(load_assignment_input(db, assignment))
    lost = len(repository.load_exemptions(db, [assignment.id]).get(assignment.id, ()))
    told = before | ({"exemptions": lost} if lost else {})
    audit.record_event(db, school_class.id, by, AuditAction.assignment_deleted, about=assignment.title, before=told)
    db.delete(assignment)
    db.flush()


def copy_assignments(
    db: Session,
    original: SchoolClass,
    made: SchoolClass,
    by: UUID,
    moved: Callable[[datetime], datetime],
    there: Callable[[str], str | None],
) -> int:
    """Gives a copied class the assignments of the original, their dates moved; no exemption, nothing released.

    `there` finds an exercise in the copy's module: one that is not there is left out, and so is what had no other.
    How many assignments there are.
    """
    copied = 0
    rows = repository.load_class_assignments(db, original.id)
    exercises = repository.load_exercises(db, [one.id for one in rows])
    for one in rows:
        wanted = assignment_input(one, exercises.get(one.id, ()))
        columns = wanted.columns()
        for name in ("opens_at", "due_at", "closes_at"):
            columns[name] = None if columns[name] is None else moved(columns[name])
        found = [(there(weighted.exercise), weighted.weight) for weighted in wanted.exercises]
        kept = tuple(Weighted(exercise, weight) for exercise, weight in found if exercise is not None)
        if kept:
            given = AssignmentInput(exercises=kept, **columns)
            _added(db, made, by, given)
            audit.record_event(db, made.id, by, AuditAction.assignment_made, about=given.title, after=_told(given))
            copied += 1
    return copied


def uncopied_exercises(
    db: Session, school_class: SchoolClass, there: Callable[[str], str | None]
) -> Sequence[tuple[str, str]]:
    """What `copy` leaves out: the titles of assignments, each with an exercise of it."""
    rows = repository.load_class_assignments(db, school_class.id)
    exercises = repository.load_exercises(db, [one.id for one in rows])
    weighted = ((row, one) for row in rows for one in assignment_input(row, exercises.get(row.id, ())).exercises)
    return [(row.title, one.exercise) for row, one in weighted if there(one.exercise) is None]


def _told(wanted: AssignmentInput) -> dict[str, Any]:
    """As the log keeps it: plain values, those that say something."""
    columns: dict[str, Any] = {
        name: value.value if isinstance(value, LatePolicy | AttemptSelection | Mode | Visibility) else value
        for name, value in wanted.columns().items()
        if value is not None
    }
    return columns | {"exercises": {one.exercise: one.weight for one in wanted.exercises}}
