"""Queries on what was changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypedDict
from uuid import UUID

from sqlalchemy import ColumnElement, Row, Select, and_, func, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from server.audit.models import AuditAction, AuditEvent
from server.audit.schemas import AuditEntry, AuditFilter, PersonName
from server.classes.models import Membership, SchoolClass
from server.database import prepared_statement, select_core
from server.identity.models import Account


class _Asked(TypedDict):
    one_student: bool
    one_kind: bool


def load_entries(
    db: Session, class_id: UUID, wanted: AuditFilter, *, most: int, skipped: int = 0, before: AuditEntry | None = None
) -> Sequence[AuditEntry]:
    """Newest first, with names; those older than `before`, where one is given."""
    query, values = _log(class_id, wanted.student, wanted.what, skipped, most=most, **_asked(wanted))
    if before is not None:
        query = query.where(tuple_(AuditEvent.at, AuditEvent.id) < tuple_(before.at, before.id))
    return [_event(row[0], _named(*row[1:5]), _named(*row[5:9])) for row in db.execute(query, values)]


@prepared_statement
def _log(
    class_id: UUID,
    student: UUID | None,
    what: AuditAction | None,
    skipped: int,
    *,
    most: int,
    one_student: bool,
    one_kind: bool,
) -> Select[*tuple[Any, ...]]:
    by, about = aliased(Account), aliased(Account)
    by_seat, seat = aliased(Membership), aliased(Membership)
    names = (by.id, by.name, by_seat.given_name, by_seat.family_name)
    query = (
        select(AuditEvent, *names, about.id, about.name, seat.given_name, seat.family_name)
        .outerjoin(by, by.id == AuditEvent.by)
        .outerjoin(by_seat, and_(by_seat.account_id == AuditEvent.by, by_seat.class_id == AuditEvent.class_id))
        .outerjoin(about, about.id == AuditEvent.student)
        .outerjoin(seat, and_(seat.account_id == AuditEvent.student, seat.class_id == AuditEvent.class_id))
        .where(_wanted(class_id, student, what, one_student=one_student, one_kind=one_kind))
    )
    return query.order_by(AuditEvent.at.desc(), AuditEvent.id.desc()).limit(most).offset(skipped)


def _event(one: AuditEvent, by: PersonName | None, student: PersonName | None) -> AuditEntry:
    return AuditEntry(one.id, one.at, by, one.what, student, one.about, one.before, one.after, one.reason)


def _named(name: UUID | None, own: str | None, given: str | None, family: str | None) -> PersonName | None:
    return None if name is None else PersonName(name, " ".join(filter(None, (given, family))) or own or "")


@prepared_statement
def _count(
    class_id: UUID, student: UUID | None, what: AuditAction | None, *, one_student: bool, one_kind: bool
) -> Select[int]:
    events = _wanted(class_id, student, what, one_student=one_student, one_kind=one_kind)
    return select(func.count()).select_from(AuditEvent).where(events)


def count_entries(db: Session, class_id: UUID, wanted: AuditFilter) -> int:
    return select_core(db, *_count(class_id, wanted.student, wanted.what, **_asked(wanted))).scalar_one()


def _asked(wanted: AuditFilter) -> _Asked:
    return {"one_student": wanted.student is not None, "one_kind": wanted.what is not None}


def _wanted(
    class_id: UUID, student: UUID | None, what: AuditAction | None, *, one_student: bool, one_kind: bool
) -> ColumnElement[bool]:
    conditions = [AuditEvent.class_id == class_id]
    if one_student:
        conditions.append(AuditEvent.student == student)
    if one_kind:
        conditions.append(AuditEvent.what == what)
    return and_(*conditions)


def load_events_about(db: Session, account_id: UUID) -> Sequence[Row[AuditEvent, str]]:
    """What was changed about somebody, each with the name of the class."""
    return db.execute(_with_class().where(AuditEvent.student == account_id)).all()


def load_events_by(db: Session, account_id: UUID) -> Sequence[Row[AuditEvent, str]]:
    """What somebody has changed, each with the name of the class."""
    return db.execute(_with_class().where(AuditEvent.by == account_id)).all()


def _with_class() -> Any:
    query = select(AuditEvent, SchoolClass.name).join(SchoolClass, SchoolClass.id == AuditEvent.class_id)
    return query.order_by(AuditEvent.at, AuditEvent.id)


def move_events(db: Session, old: UUID, new: UUID) -> None:
    """What is told of a guest is told of the account that the same person has opened."""
    for column in (AuditEvent.by, AuditEvent.student):
        db.execute(update(AuditEvent).where(column == old).values({column: new}))


def erase_reasons(db: Session, account_id: UUID) -> None:
    """The reasons of what was changed about somebody: their name goes with the account, these would still tell."""
    db.execute(update(AuditEvent).where(AuditEvent.student == account_id).values(reason=""))
