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
from server.database import ask, prepared, rows_of, table_of


def find_assignment(db: Session, class_id: UUID, assignment_id: UUID) -> Assignment | None:
    """Of this class alone."""
    query = select(Assignment).where(Assignment.id == assignment_id, Assignment.class_id == class_id)
    return db.execute(query).scalar_one_or_none()


@prepared
def _of_class(class_id: UUID) -> Select[Assignment]:
    query = select(Assignment).where(Assignment.class_id == class_id)
    return query.order_by(Assignment.opens_at, Assignment.title, Assignment.id)


def load_class_assignments(db: Session, class_id: UUID) -> Sequence[Assignment]:
    """In the order in which they open."""
    return db.execute(*_of_class(class_id)).scalars().all()


@prepared
def _exercises(assignments: Collection[UUID]) -> Select[UUID, str, float]:
    query = select(AssignedExercise.assignment_id, AssignedExercise.exercise, AssignedExercise.weight)
    return query.where(AssignedExercise.assignment_id.in_(assignments)).order_by(AssignedExercise.position)


def load_exercises(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, Sequence[WeightedExercise]]:
    """Those of each assignment, in order."""
    found: dict[UUID, list[WeightedExercise]] = defaultdict(list)
    for assignment, exercise, weight in ask(db, *_exercises(assignments)):
        found[assignment].append(WeightedExercise(exercise, weight))
    return found


@prepared
def _exemptions(assignments: Collection[UUID]) -> Select[Exemption]:
    query = select(Exemption).where(Exemption.assignment_id.in_(assignments), Exemption.revoked_at.is_(None))
    return query.order_by(Exemption.created_at, Exemption.id)


def load_exemptions(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, Sequence[Exemption]]:
    """Those of each assignment that are not revoked, oldest first."""
    found: dict[UUID, list[Exemption]] = defaultdict(list)
    for one in db.execute(*_exemptions(assignments)).scalars():
        found[one.assignment_id].append(one)
    return found


@prepared
def _opened(class_id: UUID, now: datetime) -> Select[str | None, bool]:
    given, asked = table_of(Assignment), table_of(AssignedExercise)
    query = select(asked.c.exercise, given.c.opens_at <= now)
    rows = given.outerjoin(asked, asked.c.assignment_id == given.c.id)
    return query.select_from(rows).where(given.c.class_id == class_id)


def load_opened_exercises(db: Session, class_id: UUID, now: datetime) -> frozenset[str] | None:
    """The exercises of the class's assignments that are open or past; None where it has no assignment at all."""
    rows = ask(db, *_opened(class_id, now)).all()
    return frozenset(name for name, is_open in rows if name and is_open) if rows else None


def delete_exercises(db: Session, assignment_id: UUID) -> None:
    db.execute(delete(AssignedExercise).where(AssignedExercise.assignment_id == assignment_id))


def find_exemption(db: Session, assignment_id: UUID, exemption_id: UUID) -> Exemption | None:
    """Of this assignment alone."""
    query = select(Exemption).where(Exemption.id == exemption_id, Exemption.assignment_id == assignment_id)
    return db.execute(query).scalar_one_or_none()


def load_all_exemptions(db: Session, assignment_id: UUID) -> Sequence[Exemption]:
    """Those that were revoked too, oldest first."""
    query = select(Exemption).where(Exemption.assignment_id == assignment_id)
    return db.execute(query.order_by(Exemption.created_at, Exemption.id)).scalars().all()


def move_exemptions(db: Session, old: UUID, new: UUID) -> None:
    db.execute(update(Exemption).where(Exemption.account_id == old).values(account_id=new))


@prepared
def _counted_exemptions(assignments: Collection[UUID]) -> Select[UUID, int]:
    query = select(Exemption.assignment_id, func.count()).where(
        Exemption.assignment_id.in_(assignments), Exemption.revoked_at.is_(None)
    )
    return query.group_by(Exemption.assignment_id)


def count_exemptions(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, int]:
    """How many of each are in force."""
    return {row[0]: row[1] for row in ask(db, *_counted_exemptions(assignments))}


@prepared
def _given_to(account_id: UUID, opened_by: datetime, exercise: str, *, everything: bool) -> Select[*tuple[Any, ...]]:
    earlier = select(Exemption.assignment_id).where(Exemption.opens_at <= opened_by, Exemption.revoked_at.is_(None))
    differs = select(Exemption.id).where(Exemption.assignment_id == Assignment.id, Exemption.revoked_at.is_(None))
    query = (
        select(*table_of(Assignment).c, Membership.groups, differs.exists())
        .select_from(Assignment)
        .join(Membership, Membership.class_id == Assignment.class_id)
        .join(SchoolClass, SchoolClass.id == Assignment.class_id)
        .where(
            Membership.account_id == account_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            SchoolClass.archived_at.is_(None),
            (Assignment.opens_at <= opened_by) | Assignment.id.in_(earlier),
        )
        .order_by(Assignment.opens_at, Assignment.title, Assignment.id)
    )
    asking = select(AssignedExercise.assignment_id).where(AssignedExercise.exercise == exercise)
    return query if everything else query.where(Assignment.id.in_(asking))


def load_student_assignments(
    db: Session, account_id: UUID, opened_by: datetime, exercise: str | None = None
) -> Sequence[tuple[Assignment, list[str], bool]]:
    """The assignments of the classes where this account learns, but of archived classes; with the groups that it is in
    there, and whether the assignment is another one for some.

    Those that an exemption may have opened by then already, with `exercise` those that ask for it.
    """
    found = ask(db, *_given_to(account_id, opened_by, exercise or "", everything=exercise is None))
    return [(assignment, groups, differs) for assignment, (groups, differs) in rows_of(Assignment, found)]


def load_student_exemptions(db: Session, account_id: UUID, class_id: UUID) -> Sequence[tuple[str, Exemption]]:
    """An account's own in a class that are not revoked, each with the title of its assignment."""
    query = (
        select(Assignment.title, Exemption)
        .join(Exemption, Exemption.assignment_id == Assignment.id)
        .where(Exemption.account_id == account_id, Assignment.class_id == class_id, Exemption.revoked_at.is_(None))
        .order_by(Exemption.created_at, Exemption.id)
    )
    return [(title, exemption) for title, exemption in db.execute(query)]
