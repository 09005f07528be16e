"""Queries on assignments and exemptions."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import select
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, Exemption


def by_id(db: Session, class_id: UUID, assignment_id: UUID) -> Assignment | None:
    """Of this class alone."""
    query = select(Assignment).where(Assignment.id == assignment_id, Assignment.class_id == class_id)
    return db.execute(query).scalar_one_or_none()


def of_class(db: Session, class_id: UUID) -> Sequence[Assignment]:
    """In the order in which they open."""
    query = select(Assignment).where(Assignment.class_id == class_id)
    return db.execute(query.order_by(Assignment.opens_at, Assignment.title, Assignment.id)).scalars().all()


def exercises(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, Sequence[AssignedExercise]]:
    """Those of each assignment, in order."""
    query = select(AssignedExercise).where(AssignedExercise.assignment_id.in_(assignments))
    found: dict[UUID, list[AssignedExercise]] = defaultdict(list)
    for one in db.execute(query.order_by(AssignedExercise.position)).scalars():
        found[one.assignment_id].append(one)
    return found


def exemptions(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, Sequence[Exemption]]:
    """Those of each assignment that are not revoked, oldest first."""
    query = select(Exemption).where(Exemption.assignment_id.in_(assignments), Exemption.revoked_at.is_(None))
    found: dict[UUID, list[Exemption]] = defaultdict(list)
    for one in db.execute(query.order_by(Exemption.created_at, Exemption.id)).scalars():
        found[one.assignment_id].append(one)
    return found


def opened_exercises(db: Session, class_id: UUID, now: datetime) -> frozenset[str] | None:
    """The exercises of the class's assignments that are open or past; None where it has no assignment at all."""
    query = (
        select(AssignedExercise.exercise, Assignment.opens_at)
        .select_from(Assignment)
        .outerjoin(AssignedExercise, AssignedExercise.assignment_id == Assignment.id)
        .where(Assignment.class_id == class_id)
    )
    rows = db.execute(query).all()
    return frozenset(name for name, opens_at in rows if name and opens_at <= now) if rows else None
