"""Queries on overrides, and on the attempts that marks are made of. No list reads a source or a verdict."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Row, Select, and_, select, update
from sqlalchemy.orm import Session

from server.classes.models import Membership, SchoolClass
from server.database import NEVER, Telling, Told, ask, prepared, table_of
from server.gradebook.models import Grading
from server.identity.models import Account
from server.marks.models import Override
from server.marks.schemas import Key, Set
from server.submissions.models import Submission


def _active(class_id: UUID) -> ColumnElement[bool]:
    return and_(Override.class_id == class_id, Override.withdrawn_at.is_(None))


@prepared
def _set_by(class_id: UUID, students: Collection[UUID], exercises: Collection[str]) -> Select[*tuple[Any, ...]]:
    one, by, seat = table_of(Override), table_of(Account), table_of(Membership)
    told = (one.c.account_id, one.c.exercise, one.c.points, one.c.excused, one.c.reason, one.c.at, one.c.based_on)
    query = select(*told, by.c.name, seat.c.given_name, seat.c.family_name)
    query = query.select_from(
        one.outerjoin(by, by.c.id == one.c.by).outerjoin(
            seat, and_(seat.c.account_id == one.c.by, seat.c.class_id == one.c.class_id)
        )
    )
    return query.where(_active(class_id), one.c.account_id.in_(students), one.c.exercise.in_(exercises))


def active(db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]) -> Mapping[Key, Set]:
    """The overrides in force, each with who set it, in one query."""
    found = {}
    for row in ask(db, *_set_by(class_id, students, exercises)):
        account_id, exercise, points, excused, reason, at, based_on, name, given, family = row
        by = " ".join(filter(None, (given, family))) or name or ""
        found[account_id, exercise] = Set(points, excused, reason, by, at, frozenset(based_on))
    return found


def one_active(db: Session, class_id: UUID, student: UUID, exercise: str) -> Override | None:
    query = select(Override).where(_active(class_id), Override.account_id == student, Override.exercise == exercise)
    return db.execute(query).scalar_one_or_none()


_submissions, _gradings = table_of(Submission), table_of(Grading)
_sent = _submissions.c
TOLD = Telling(_sent.account_id, _sent.exercise, _sent.id, _sent.created_at, _gradings.c.score, _sent.grading_id)


@prepared
def _graded(
    students: Collection[UUID], exercises: Collection[str], until: datetime, *, all_times: bool
) -> Select[*tuple[Any, ...]]:
    query = select(*TOLD.asked).select_from(_submissions.join(_gradings, _gradings.c.id == _sent.grading_id))
    query = query.where(
        _sent.account_id.in_(students), _sent.exercise.in_(exercises), _gradings.c.score.is_not(None)
    ).order_by(_sent.account_id, _sent.exercise, _sent.created_at, _sent.id)
    return query if all_times else query.where(_sent.created_at <= until)


def graded(
    db: Session, students: Collection[UUID], exercises: Collection[str], until: datetime | None
) -> Sequence[Told]:
    """The graded attempts of many students at many exercises, errors of ours left out: by student, then by exercise.

    `until`: when the class was archived; nothing that is sent later is its business.
    """
    asked = _graded(students, exercises, until or NEVER, all_times=until is None)
    return list(map(tuple, ask(db, *asked).all()))


def overrides_of(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """All that were ever set on somebody's marks, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.account_id == account_id).order_by(Override.at, Override.id)).all()


def overrides_by(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
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


def source_of(db: Session, submission_id: UUID) -> bytes | None:
    return db.execute(select(Submission.source).where(Submission.id == submission_id)).scalar_one_or_none()
