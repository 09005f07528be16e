"""Queries on the audit log."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Row, and_, func, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from server.audit.models import AuditEvent
from server.audit.schemas import AuditEntry, AuditFilter, PersonName
from server.classes.models import Membership, SchoolClass
from server.classes.schemas import display_name
from server.identity.models import Account


def load_entries(
    db: Session,
    class_id: UUID,
    filters: AuditFilter,
    *,
    limit: int,
    offset: int = 0,
    before: AuditEntry | None = None,
) -> Sequence[AuditEntry]:
    """Load the entries of a class with names, newest first; `before` starts after an entry (keyset pagination)."""
    author, student = aliased(Account), aliased(Account)
    author_seat, seat = aliased(Membership), aliased(Membership)
    names = (author.id, author.name, author_seat.given_name, author_seat.family_name)
    query = (
        select(AuditEvent, *names, student.id, student.name, seat.given_name, seat.family_name)
        .outerjoin(author, author.id == AuditEvent.by)
        .outerjoin(
            author_seat, and_(author_seat.account_id == AuditEvent.by, author_seat.class_id == AuditEvent.class_id)
        )
        .outerjoin(student, student.id == AuditEvent.student)
        .outerjoin(seat, and_(seat.account_id == AuditEvent.student, seat.class_id == AuditEvent.class_id))
        .where(_matches_filters(class_id, filters))
    )
    if before is not None:
        query = query.where(tuple_(AuditEvent.at, AuditEvent.id) < tuple_(before.at, before.id))
    query = query.order_by(AuditEvent.at.desc(), AuditEvent.id.desc()).limit(limit).offset(offset)
    return [
        _build_entry(row[0], _build_person_name(*row[1:5]), _build_person_name(*row[5:9])) for row in db.execute(query)
    ]


def _build_entry(event: AuditEvent, by: PersonName | None, student: PersonName | None) -> AuditEntry:
    values = (event.about, event.before, event.after, event.reason)
    return AuditEntry(event.id, event.at, by, event.what, student, *values)


def _build_person_name(
    account_id: UUID | None, own: str | None, given: str | None, family: str | None
) -> PersonName | None:
    return None if account_id is None else PersonName(account_id, display_name(given, family, own or ""))


def count_entries(db: Session, class_id: UUID, filters: AuditFilter) -> int:
    query = select(func.count()).select_from(AuditEvent).where(_matches_filters(class_id, filters))
    return db.execute(query).scalar_one()


def _matches_filters(class_id: UUID, filters: AuditFilter) -> ColumnElement[bool]:
    conditions = [AuditEvent.class_id == class_id]
    if filters.student is not None:
        conditions.append(AuditEvent.student == filters.student)
    if filters.what is not None:
        conditions.append(AuditEvent.what == filters.what)
    return and_(*conditions)


def load_events_about(db: Session, account_id: UUID) -> Sequence[Row[AuditEvent, str | None]]:
    """Load the events about an account, each with the name of the class."""
    return db.execute(_select_events_with_class().where(AuditEvent.student == account_id)).all()


def load_events_by(db: Session, account_id: UUID) -> Sequence[Row[AuditEvent, str | None]]:
    """Load the events of an author, each with the name of the class, None for one of the server."""
    return db.execute(_select_events_with_class().where(AuditEvent.by == account_id)).all()


def _select_events_with_class() -> Any:
    query = select(AuditEvent, SchoolClass.name).outerjoin(SchoolClass, SchoolClass.id == AuditEvent.class_id)
    return query.order_by(AuditEvent.at, AuditEvent.id)


def load_server_entries(db: Session, *, limit: int, offset: int = 0) -> Sequence[AuditEntry]:
    """Load the entries of no class, an administrator's, newest first, with the names of who and about whom."""
    author, subject = aliased(Account), aliased(Account)
    query = (
        select(AuditEvent, author.id, author.name, subject.id, subject.name)
        .outerjoin(author, author.id == AuditEvent.by)
        .outerjoin(subject, subject.id == AuditEvent.student)
        .where(AuditEvent.class_id.is_(None))
        .order_by(AuditEvent.at.desc(), AuditEvent.id.desc())
        .limit(limit)
        .offset(offset)
    )
    return [
        _build_entry(
            event, _build_person_name(by, by_name, None, None), _build_person_name(about, about_name, None, None)
        )
        for event, by, by_name, about, about_name in db.execute(query)
    ]


def count_server_entries(db: Session) -> int:
    return db.execute(select(func.count()).select_from(AuditEvent).where(AuditEvent.class_id.is_(None))).scalar_one()


def move_events(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move the events of a guest to the account that the same person has opened."""
    for column in (AuditEvent.by, AuditEvent.student):
        db.execute(update(AuditEvent).where(column == guest_id).values({column: account_id}))


def erase_reasons(db: Session, account_id: UUID) -> None:
    """Erase the reasons of the events about an account: they could identify it once its name is gone."""
    db.execute(update(AuditEvent).where(AuditEvent.student == account_id).values(reason=""))
