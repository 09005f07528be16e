"""Give an exercise to some students of a class, or re-open an assignment for them.

Every function works inside the caller's transaction, on a class that the caller may change (`server.rights`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import editing, exemption_service, groups, repository
from server.assignments.models import Assignment, Exemption, Mode, WeightedExercise
from server.assignments.rules import is_assigned_to
from server.assignments.schemas import AssignmentInput, ExemptionInput, ExemptionTarget
from server.base.errors import InvalidFields
from server.classes import repository as classes
from server.classes.folding import normalise_name
from server.classes.models import SchoolClass
from server.course import Course

NOBODY = "Cochez au moins un élève."
NO_DATE = "Donnez la date jusqu’à laquelle ils peuvent rendre."
PAST = "Cette date est passée : donnez-en une à venir."
OPEN = "Ce devoir est encore ouvert à cette date pour toute la classe : il n’y a rien à rouvrir."
OTHERS = "Ce devoir n’est pas donné à {name} : décochez cet élève, ou donnez-lui plutôt un exercice."
MAX_NAMES = 100


def assign_exercise_to_students(
    db: Session,
    course: Course,
    school_class: SchoolClass,
    by: UUID,
    students: Collection[UUID],
    exercise: str,
    name: str,
    due_at: datetime | None,
    now: datetime,
) -> Assignment:
    """Give one exercise to these students alone, as an assignment of a group of that name, or of one that they are.

    Raises Conflict for an archived class, or InvalidFields.
    """
    _require_students_and_date(students, due_at, now)
    label = _find_exact_group(db, school_class, students)
    if label is None:
        label = groups.create_group(db, school_class, by, _number_until_free(db, school_class, name), students)
    titles = editing.load_assignable_titles(db, course, school_class)
    title = f"Reprise : {titles.get(exercise, exercise)}"
    fields = AssignmentInput(title, (WeightedExercise(exercise),), now, due_at, groups=(label,))
    return editing.create_assignment(db, course, school_class, by, fields)


def _require_students_and_date(students: Collection[UUID], until: datetime | None, now: datetime) -> None:
    problems = {} if students else {"students": NOBODY}
    if until is None or until <= now:
        problems["due_at"] = NO_DATE if until is None else PAST
    if problems:
        raise InvalidFields(problems)


def _find_exact_group(db: Session, school_class: SchoolClass, students: Collection[UUID]) -> str | None:
    """Return a group that has these students and no others."""
    members: dict[str, set[UUID]] = {}
    for student in classes.load_active_students(db, school_class.id):
        for label in student.groups:
            members.setdefault(label, set()).add(student.id)
    return next((label for label, own in sorted(members.items()) if own == set(students)), None)


def _number_until_free(db: Session, school_class: SchoolClass, name: str) -> str:
    """Return the name, numbered where groups have it already."""
    taken = groups.load_taken_group_names(db, school_class)
    names = [name, *(f"{name} ({number})" for number in range(2, MAX_NAMES))]
    return next((each for each in names if normalise_name(each) not in taken), name)


def list_reopenable_assignments(db: Session, school_class: SchoolClass, now: datetime) -> Sequence[Assignment]:
    """Return the assignments whose date limit or closing has gone by, the latest first; tests are no such."""
    given = repository.load_class_assignments(db, school_class.id)
    over = [row for row in given if row.mode != Mode.test and _has_passed_date(row, now)]
    return sorted(over, key=lambda row: row.opens_at, reverse=True)


def _has_passed_date(assignment: Assignment, now: datetime) -> bool:
    return any(date is not None and date <= now for date in (assignment.due_at, assignment.closes_at))


def reopen_for_students(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    assignment: Assignment,
    students: Collection[UUID],
    until: datetime | None,
    now: datetime,
) -> Sequence[Exemption]:
    """Re-open an assignment for these students until a new date limit, by an exemption each.

    Raises InvalidFields, or Conflict for an archived class.
    """
    _require_students_and_date(students, until, now)
    assert until is not None
    members = classes.load_members(db, school_class.id)
    for member in members:
        if member.id in students and not is_assigned_to(assignment, member.groups):
            raise InvalidFields({"students": OTHERS.format(name=member.name)})
    closes_at = assignment.closes_at
    fields = ExemptionInput(
        due_at=until if assignment.due_at is not None and assignment.due_at < until else None,
        closes_at=until if closes_at is not None and closes_at < until else None,
        reason="rouvert",
    )
    if not fields.changed_fields:
        raise InvalidFields({"due_at": OPEN})
    target = ExemptionTarget(tuple(students))
    return exemption_service.grant_exemptions(db, school_class, by, assignment, members, target, fields)
