"""Queries on overrides."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Row, Select, and_, select, update
from sqlalchemy.orm import Session

from server.classes.models import Membership, SchoolClass
from server.database import Telling, Told, ask, prepared, table_of
from server.identity.models import Account
from server.marks.models import Override
from server.marks.schemas import ActiveOverride, StudentExercise
from server.submissions.models import Submission


def _active(class_id: UUID) -> ColumnElement[bool]:
    return and_(Override.class_id == class_id, Override.withdrawn_at.is_(None))


_by, _seats = table_of(Account), table_of(Membership)
_overrides = table_of(Override)
_set = _overrides.c
TOLD = Telling(
    _set.account_id,
    _set.exercise,
    _set.points,
    _set.excused,
    _set.reason,
    _set.at,
    _set.based_on,
    _by.c.name,
    _seats.c.given_name,
    _seats.c.family_name,
)


@prepared
def _told(
    class_id: UUID, students: Collection[UUID], exercises: Collection[str], *, everyone: bool, everything: bool
) -> Select[*tuple[Any, ...]]:
    seated = and_(_seats.c.account_id == _set.by, _seats.c.class_id == _set.class_id)
    rows = _overrides.outerjoin(_by, _by.c.id == _set.by).outerjoin(_seats, seated)
    query = select(*TOLD.asked).select_from(rows).where(_set.class_id == class_id, _set.withdrawn_at.is_(None))
    query = query if everyone else query.where(_set.account_id.in_(students))
    query = query if everything else query.where(_set.exercise.in_(exercises))
    return query.order_by(_set.account_id, _set.exercise)


def told(db: Session, class_id: UUID, students: Collection[UUID] | None) -> Sequence[Told]:
    """The overrides in force of a class, or of some of its students, each with who set it, as the database tells
    them."""
    asked = _told(class_id, students or (), (), everyone=students is None, everything=True)
    return [tuple(row) for row in ask(db, *asked).all()]


def read(db: Session, told: Iterable[Told]) -> Mapping[StudentExercise, ActiveOverride]:
    """The same as they are read."""
    found = {}
    for row in map(TOLD.reader(db), told):
        account_id, exercise, points, excused, reason, at, based_on, name, given, family = row
        by = " ".join(filter(None, (given, family))) or name or ""
        found[account_id, exercise] = ActiveOverride(points, excused, reason, by, at, frozenset(based_on))
    return found


def load_overrides(
    db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]
) -> Mapping[StudentExercise, ActiveOverride]:
    """The overrides in force of these students at these exercises, in one query."""
    asked = _told(class_id, students, exercises, everyone=False, everything=False)
    return read(db, map(tuple, ask(db, *asked)))


def find_override(db: Session, class_id: UUID, student: UUID, exercise: str) -> Override | None:
    query = select(Override).where(_active(class_id), Override.account_id == student, Override.exercise == exercise)
    return db.execute(query).scalar_one_or_none()


def list_overrides_on(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """All that were ever set on somebody's marks, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.account_id == account_id).order_by(Override.at, Override.id)).all()


def list_overrides_by(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """All that somebody ever set, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.by == account_id).order_by(Override.at, Override.id)).all()


def move(db: Session, old: UUID, new: UUID, now: datetime) -> None:
    """Gives an account a guest's overrides; where both have one in force, the account keeps its own."""
    mine = set(_in_force_of(db, new))
    for one in db.execute(
        select(Override).where(Override.account_id == old, Override.withdrawn_at.is_(None))
    ).scalars():
        if (one.class_id, one.exercise) in mine:
            one.withdrawn_at = now
    db.flush()
    db.execute(update(Override).where(Override.account_id == old).values(account_id=new))


def _in_force_of(db: Session, account_id: UUID) -> Sequence[tuple[UUID, str]]:
    query = select(Override.class_id, Override.exercise)
    query = query.where(Override.account_id == account_id, Override.withdrawn_at.is_(None))
    return [(class_id, exercise) for class_id, exercise in db.execute(query)]


def load_source(db: Session, submission_id: UUID) -> bytes | None:
    return db.execute(select(Submission.source).where(Submission.id == submission_id)).scalar_one_or_none()
