"""Queries on assignments and exemptions."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import Select, delete, func, select, update
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, Exemption, WeightedExercise
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import detached_instances, prepared_statement, select_core, table_of


def find_assignment(db: Session, class_id: UUID, assignment_id: UUID) -> Assignment | None:
    """Return an assignment of this class, or None."""
    query = select(Assignment).where(Assignment.id == assignment_id, Assignment.class_id == class_id)
    query = query.where(Assignment.removed_at.is_(None))
    return db.execute(query).scalar_one_or_none()


@prepared_statement
def _select_class_assignments(class_id: UUID) -> Select[Assignment]:
    query = select(Assignment).where(Assignment.class_id == class_id, Assignment.removed_at.is_(None))
    return query.order_by(Assignment.opens_at, Assignment.title, Assignment.id)


def load_removed_assignments(db: Session, class_id: UUID) -> Sequence[Assignment]:
    """Load the deleted assignments of a class that can still be restored, the last deleted first."""
    query = select(Assignment).where(Assignment.class_id == class_id, Assignment.removed_at.is_not(None))
    return db.execute(query.order_by(Assignment.removed_at.desc(), Assignment.id)).scalars().all()


def purge_assignments_removed_before(db: Session, before: datetime) -> None:
    """Delete for good the assignments that were removed before that time."""
    db.execute(delete(Assignment).where(Assignment.removed_at < before))


def load_class_assignments(db: Session, class_id: UUID) -> Sequence[Assignment]:
    """Load the assignments of a class in the order in which they open."""
    return db.execute(*_select_class_assignments(class_id)).scalars().all()


@prepared_statement
def _select_exercises(assignments: Collection[UUID]) -> Select[UUID, str, float]:
    query = select(AssignedExercise.assignment_id, AssignedExercise.exercise, AssignedExercise.weight)
    return query.where(AssignedExercise.assignment_id.in_(assignments)).order_by(AssignedExercise.position)


def load_exercises(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, Sequence[WeightedExercise]]:
    """Load the exercises of each assignment, in order."""
    exercises: dict[UUID, list[WeightedExercise]] = defaultdict(list)
    for assignment, exercise, weight in select_core(db, *_select_exercises(assignments)):
        exercises[assignment].append(WeightedExercise(exercise, weight))
    return exercises


def load_class_exercises(db: Session, class_id: UUID) -> Sequence[str]:
    """Return the exercises that any assignment of a class asks, each once."""
    of_class = select(Assignment.id).where(Assignment.class_id == class_id)
    query = select(AssignedExercise.exercise).distinct().where(AssignedExercise.assignment_id.in_(of_class))
    return db.execute(query.order_by(AssignedExercise.exercise)).scalars().all()


@prepared_statement
def _select_exemptions(assignments: Collection[UUID]) -> Select[Exemption]:
    query = select(Exemption).where(Exemption.assignment_id.in_(assignments))
    return query.order_by(Exemption.created_at, Exemption.id)


def load_exemptions(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, Sequence[Exemption]]:
    """Load the exemptions of each assignment, revoked ones included, oldest first."""
    exemptions: dict[UUID, list[Exemption]] = defaultdict(list)
    for exemption in db.execute(*_select_exemptions(assignments)).scalars():
        exemptions[exemption.assignment_id].append(exemption)
    return exemptions


@prepared_statement
def _select_opened_exercises(class_id: UUID, now: datetime) -> Select[str | None, bool, tuple[str, ...]]:
    assignments, exercises = table_of(Assignment), table_of(AssignedExercise)
    query = select(exercises.c.exercise, assignments.c.opens_at <= now, assignments.c.groups)
    rows = assignments.outerjoin(exercises, exercises.c.assignment_id == assignments.c.id)
    return query.select_from(rows).where(assignments.c.class_id == class_id, assignments.c.removed_at.is_(None))


def load_opened_exercises(db: Session, class_id: UUID, now: datetime) -> Mapping[str, frozenset[str]] | None:
    """Load the exercises of the class's open or past assignments, each with the groups to which alone it is given, none
    for the whole class; None where the class has no assignment at all."""
    rows = select_core(db, *_select_opened_exercises(class_id, now)).all()
    opened = [(name, frozenset(groups)) for name, is_open, groups in rows if name and is_open]
    for_all = {name for name, groups in opened if not groups}
    labels: dict[str, frozenset[str]] = dict.fromkeys(for_all, frozenset())
    for name, groups in opened:
        if name not in for_all:
            labels[name] = labels.get(name, frozenset()) | groups
    return labels if rows else None


def delete_exercises(db: Session, assignment_id: UUID) -> None:
    db.execute(delete(AssignedExercise).where(AssignedExercise.assignment_id == assignment_id))


def find_exemption(db: Session, assignment_id: UUID, exemption_id: UUID) -> Exemption | None:
    """Return an exemption of this assignment, or None."""
    query = select(Exemption).where(Exemption.id == exemption_id, Exemption.assignment_id == assignment_id)
    return db.execute(query).scalar_one_or_none()


def load_active_exemptions(db: Session, assignment_id: UUID) -> Sequence[Exemption]:
    """Load the exemptions of an assignment that are in force, oldest first."""
    exemptions = load_exemptions(db, [assignment_id]).get(assignment_id, ())
    return [exemption for exemption in exemptions if exemption.revoked_at is None]


def move_exemptions(db: Session, guest_id: UUID, account_id: UUID) -> None:
    db.execute(update(Exemption).where(Exemption.account_id == guest_id).values(account_id=account_id))


def rename_group_label(db: Session, class_id: UUID, old: str, new: str) -> None:
    """Rename a group in the assignments of a class, deleted ones included, and in their exemptions."""
    for assignment in db.execute(select(Assignment).where(Assignment.class_id == class_id)).scalars():
        if old in assignment.groups:
            assignment.groups = tuple(new if label == old else label for label in assignment.groups)
    own = select(Assignment.id).where(Assignment.class_id == class_id)
    renamed = update(Exemption).where(Exemption.assignment_id.in_(own), Exemption.label == old).values(label=new)
    db.execute(renamed.execution_options(synchronize_session=False))


@prepared_statement
def _select_exemption_counts(assignments: Collection[UUID]) -> Select[UUID, int]:
    query = select(Exemption.assignment_id, func.count()).where(
        Exemption.assignment_id.in_(assignments), Exemption.revoked_at.is_(None)
    )
    return query.group_by(Exemption.assignment_id)


def count_exemptions(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, int]:
    """Count the exemptions in force of each assignment."""
    return {row[0]: row[1] for row in select_core(db, *_select_exemption_counts(assignments))}


@prepared_statement
def _select_student_assignments(
    account_id: UUID, opened_by: datetime, exercise: str, *, everything: bool
) -> Select[*tuple[Any, ...]]:
    earlier = select(Exemption.assignment_id).where(Exemption.opens_at <= opened_by, Exemption.revoked_at.is_(None))
    exempted = select(Exemption.id).where(Exemption.assignment_id == Assignment.id)
    query = (
        select(*table_of(Assignment).c, Membership.groups, exempted.exists())
        .select_from(Assignment)
        .join(Membership, Membership.class_id == Assignment.class_id)
        .join(SchoolClass, SchoolClass.id == Assignment.class_id)
        .where(
            Membership.account_id == account_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            SchoolClass.archived_at.is_(None),
            Assignment.removed_at.is_(None),
            (Assignment.opens_at <= opened_by) | Assignment.id.in_(earlier),
        )
        .order_by(Assignment.opens_at, Assignment.title, Assignment.id)
    )
    containing = select(AssignedExercise.assignment_id).where(AssignedExercise.exercise == exercise)
    return query if everything else query.where(Assignment.id.in_(containing))


def load_student_assignments(
    db: Session, account_id: UUID, opened_by: datetime, exercise: str | None = None
) -> Sequence[tuple[Assignment, list[str], bool]]:
    """Load the assignments of a student's classes, archived ones excepted, that may have opened by then, also by an
    exemption; with `exercise`, those that contain it. Each has the student's groups, and whether there are exemptions.
    """
    rows = select_core(
        db, *_select_student_assignments(account_id, opened_by, exercise or "", everything=exercise is None)
    )
    return [(assignment, groups, exempted) for assignment, (groups, exempted) in detached_instances(Assignment, rows)]


def load_student_exemptions(db: Session, account_id: UUID, class_id: UUID) -> Sequence[tuple[str, Exemption]]:
    """Load a student's own exemptions in force in a class, each with the title of its assignment."""
    query = (
        select(Assignment.title, Exemption)
        .join(Exemption, Exemption.assignment_id == Assignment.id)
        .where(Exemption.account_id == account_id, Assignment.class_id == class_id, Exemption.revoked_at.is_(None))
        .where(Assignment.removed_at.is_(None))
        .order_by(Exemption.created_at, Exemption.id)
    )
    return [(title, exemption) for title, exemption in db.execute(query)]
