"""Queries on who shares a class with whom."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, or_, select
from sqlalchemy.orm import Session, aliased

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import Member
from server.database import equals_any, prepared_statement, select_core
from server.identity.models import Account

STAFF = (ClassRole.assistant, ClassRole.teacher)


@prepared_statement
def _reads_work(
    reader: UUID, author: UUID, module: str, sent_at: datetime, *, seats: tuple[ClassRole, ...]
) -> Select[UUID]:
    staff, student = aliased(Membership), aliased(Membership)
    query = (
        select(SchoolClass.id)
        .join(staff, staff.class_id == SchoolClass.id)
        .join(student, student.class_id == SchoolClass.id)
        .where(
            SchoolClass.module == module,
            or_(SchoolClass.archived_at.is_(None), SchoolClass.archived_at >= sent_at),
            staff.account_id == reader,
            equals_any(staff.role, seats),
            staff.status == Status.active,
            student.account_id == author,
            student.role == ClassRole.student,
            or_(
                student.status == Status.active,
                and_(
                    student.status == Status.left,
                    student.left_at >= sent_at,
                ),
            ),
        )
    )
    return query.limit(1)


def may_read_work(
    db: Session, reader: UUID, author: UUID, module: str, sent_at: datetime, seats: Sequence[ClassRole] = STAFF
) -> bool:
    """Has the reader one of these seats in a class of this module in which the author is, or was at that time?"""
    return select_core(db, *_reads_work(reader, author, module, sent_at, seats=tuple(seats))).first() is not None


@prepared_statement
def _seen_through(reader: UUID, author: UUID, module: str, *, anybody: bool) -> Select[Membership, Account]:
    query = (
        select(Membership, Account)
        .join(Account, Account.id == Membership.account_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(
            SchoolClass.module == module,
            Membership.account_id == author,
            Membership.role == ClassRole.student,
            Membership.status != Status.pending,
        )
        .order_by(Membership.status, SchoolClass.archived_at.is_not(None), Membership.joined_at.desc())
        .limit(1)
    )
    return query if anybody else query.where(Membership.class_id.in_(_seats(reader, module, STAFF)))


def find_member_for_reader(db: Session, reader: UUID | None, author: UUID, module: str) -> Member | None:
    """How a class of this module in which the reader helps or teaches (any, without one) lists its student."""
    row = db.execute(*_seen_through(reader or author, author, module, anybody=reader is None)).first()
    return None if row is None else Member(*row)


@prepared_statement
def _has_readers(author: UUID, module: str) -> Select[UUID]:
    staff = aliased(Membership)
    return (
        select(SchoolClass.id)
        .join(Membership, Membership.class_id == SchoolClass.id)
        .join(staff, staff.class_id == SchoolClass.id)
        .where(
            _is_open(module),
            Membership.account_id == author,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            equals_any(staff.role, STAFF),
            staff.status == Status.active,
        )
        .limit(1)
    )


def has_readers(db: Session, author: UUID, module: str) -> bool:
    """Is there somebody to read what is sent now: who teaches or helps in an open class in which the author learns?"""
    return select_core(db, *_has_readers(author, module)).first() is not None


def teaches_clause(account_id: UUID, module: str) -> ColumnElement[bool]:
    """Whether one teaches or helps in a class of this module, to be asked with something else."""
    return _seats(account_id, module, STAFF).exists()


def is_student(db: Session, account_id: UUID, module: str) -> bool:
    """Is this account a student of a class of this module that is not archived?"""
    seats = _seats(account_id, module, (ClassRole.student,)).where(SchoolClass.archived_at.is_(None))
    return db.execute(select(seats.exists())).scalar_one()


@prepared_statement
def _of_teacher(account_id: UUID, module: str) -> Select[SchoolClass]:
    query = select(SchoolClass).where(
        _is_open(module), SchoolClass.id.in_(_seats(account_id, module, (ClassRole.teacher,)))
    )
    return query.order_by(SchoolClass.name, SchoolClass.id)


def load_classes_of_teacher(db: Session, account_id: UUID, module: str) -> Sequence[SchoolClass]:
    """The classes of this module in which one teaches, by their names, but those archived."""
    return db.execute(*_of_teacher(account_id, module)).scalars().all()


def load_classes_of_module(db: Session, module: str) -> Sequence[SchoolClass]:
    query = select(SchoolClass).where(_is_open(module))
    return db.execute(query.order_by(SchoolClass.name, SchoolClass.id)).scalars().all()


def _is_open(module: str) -> ColumnElement[bool]:
    return and_(SchoolClass.module == module, SchoolClass.archived_at.is_(None))


def _seats(account_id: UUID, module: str, seats: Sequence[ClassRole]) -> Select[UUID]:
    return (
        select(Membership.class_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(
            SchoolClass.module == module,
            Membership.account_id == account_id,
            Membership.status == Status.active,
            equals_any(Membership.role, seats),
        )
    )
