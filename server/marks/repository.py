"""Queries on overrides."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Row, and_, select, update
from sqlalchemy.orm import Session

from server.classes.models import Membership, SchoolClass
from server.identity.models import Account
from server.marks.models import Override
from server.marks.schemas import ActiveOverride, StudentExercise
from server.submissions.models import Submission


def _active(class_id: UUID) -> ColumnElement[bool]:
    return and_(Override.class_id == class_id, Override.withdrawn_at.is_(None))


def load_overrides(
    db: Session, class_id: UUID, students: Collection[UUID] | None = None, exercises: Collection[str] | None = None
) -> Mapping[StudentExercise, ActiveOverride]:
    """Load the overrides in force in a class, or those of some students or exercises, in one query."""
    columns = (Account.name, Membership.given_name, Membership.family_name)
    seat = and_(Membership.account_id == Override.by, Membership.class_id == Override.class_id)
    query = select(Override, *columns).outerjoin(Account, Account.id == Override.by).outerjoin(Membership, seat)
    query = query.where(_active(class_id))
    if students is not None:
        query = query.where(Override.account_id.in_(students))
    if exercises is not None:
        query = query.where(Override.exercise.in_(exercises))
    overrides = {}
    for row, name, given_name, family_name in db.execute(query.order_by(Override.account_id, Override.exercise)):
        by = " ".join(filter(None, (given_name, family_name))) or name or ""
        overrides[row.account_id, row.exercise] = ActiveOverride(
            row.points, row.excused, row.reason, by, row.at, frozenset(row.based_on)
        )
    return overrides


def find_override(db: Session, class_id: UUID, student: UUID, exercise: str) -> Override | None:
    query = select(Override).where(_active(class_id), Override.account_id == student, Override.exercise == exercise)
    return db.execute(query).scalar_one_or_none()


def list_overrides_on(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """Return every override ever set on an account's marks, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.account_id == account_id).order_by(Override.at, Override.id)).all()


def list_overrides_by(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """Return every override ever set by an account, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.by == account_id).order_by(Override.at, Override.id)).all()


def move_overrides(db: Session, old: UUID, new: UUID, now: datetime) -> None:
    """Move overrides from a guest to an account, which keeps its own where both have one in force."""
    own = set(_active_pairs(db, new))
    for override in db.execute(
        select(Override).where(Override.account_id == old, Override.withdrawn_at.is_(None))
    ).scalars():
        if (override.class_id, override.exercise) in own:
            override.withdrawn_at = now
    db.flush()
    db.execute(update(Override).where(Override.account_id == old).values(account_id=new))


def _active_pairs(db: Session, account_id: UUID) -> Sequence[tuple[UUID, str]]:
    query = select(Override.class_id, Override.exercise)
    query = query.where(Override.account_id == account_id, Override.withdrawn_at.is_(None))
    return [(class_id, exercise) for class_id, exercise in db.execute(query)]


def load_source(db: Session, submission_id: UUID) -> bytes | None:
    return db.execute(select(Submission.source).where(Submission.id == submission_id)).scalar_one_or_none()
