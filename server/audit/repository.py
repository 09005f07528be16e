"""Queries on what was changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Row, and_, func, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from server.audit.models import AuditEvent
from server.audit.schemas import Event, Filter, Named
from server.classes.models import Membership, SchoolClass
from server.identity.models import Account


def of_class(
    db: Session, class_id: UUID, wanted: Filter, *, most: int, skipped: int = 0, before: Event | None = None
) -> Sequence[Event]:
    """Newest first, with names; those older than `before`, where one is given."""
    by, student = aliased(Account), aliased(Account)
    by_seat, student_seat = aliased(Membership), aliased(Membership)
    query = (
        select(
            AuditEvent,
            by.id,
            by.name,
            by_seat.given_name,
            by_seat.family_name,
            student.id,
            student.name,
            student_seat.given_name,
            student_seat.family_name,
        )
        .outerjoin(by, by.id == AuditEvent.by)
        .outerjoin(by_seat, and_(by_seat.account_id == AuditEvent.by, by_seat.class_id == AuditEvent.class_id))
        .outerjoin(student, student.id == AuditEvent.student)
        .outerjoin(
            student_seat,
            and_(student_seat.account_id == AuditEvent.student, student_seat.class_id == AuditEvent.class_id),
        )
        .where(_wanted(class_id, wanted))
        .order_by(AuditEvent.at.desc(), AuditEvent.id.desc())
    )
    if before is not None:
        query = query.where(tuple_(AuditEvent.at, AuditEvent.id) < tuple_(before.at, before.id))
    return [
        _event(row[0], _named(*row[1:5]), _named(*row[5:9])) for row in db.execute(query.limit(most).offset(skipped))
    ]


def _event(one: AuditEvent, by: Named | None, student: Named | None) -> Event:
    return Event(one.id, one.at, by, one.what, student, one.about, one.before, one.after, one.reason)


def _named(name: UUID | None, own: str | None, given: str | None, family: str | None) -> Named | None:
    return None if name is None else Named(name, " ".join(filter(None, (given, family))) or own or "")


def count(db: Session, class_id: UUID, wanted: Filter) -> int:
    return db.execute(select(func.count()).select_from(AuditEvent).where(_wanted(class_id, wanted))).scalar_one()


def _wanted(class_id: UUID, wanted: Filter) -> ColumnElement[bool]:
    conditions = [AuditEvent.class_id == class_id]
    if wanted.student is not None:
        conditions.append(AuditEvent.student == wanted.student)
    if wanted.what is not None:
        conditions.append(AuditEvent.what == wanted.what)
    return and_(*conditions)


def about(db: Session, account_id: UUID) -> Sequence[Row[AuditEvent, str]]:
    """What was changed about somebody, each with the name of the class."""
    return db.execute(_with_class().where(AuditEvent.student == account_id)).all()


def by(db: Session, account_id: UUID) -> Sequence[Row[AuditEvent, str]]:
    """What somebody has changed, each with the name of the class."""
    return db.execute(_with_class().where(AuditEvent.by == account_id)).all()


def _with_class() -> Any:
    query = select(AuditEvent, SchoolClass.name).join(SchoolClass, SchoolClass.id == AuditEvent.class_id)
    return query.order_by(AuditEvent.at, AuditEvent.id)


def move(db: Session, old: UUID, new: UUID) -> None:
    """What is told of a guest is told of the account that the same person has opened."""
    for column in (AuditEvent.by, AuditEvent.student):
        db.execute(update(AuditEvent).where(column == old).values({column: new}))


def forget_reasons(db: Session, account_id: UUID) -> None:
    """The reasons of what was changed about somebody: their name goes with the account, these would still tell."""
    db.execute(update(AuditEvent).where(AuditEvent.student == account_id).values(reason=""))
