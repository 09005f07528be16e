"""Queries on staff and students that share a class."""

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
    reader: UUID, author: UUID, module: str, sent_at: datetime, *, roles: tuple[ClassRole, ...]
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
            equals_any(staff.role, roles),
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
    db: Session, reader: UUID, author: UUID, module: str, sent_at: datetime, roles: Sequence[ClassRole] = STAFF
) -> bool:
    """Whether the reader has such a role in a class of this module of which the author is, or was then, a student."""
    return select_core(db, *_reads_work(reader, author, module, sent_at, roles=tuple(roles))).first() is not None


@prepared_statement
def _member_for_reader(reader: UUID, author: UUID, module: str, *, anybody: bool) -> Select[Membership, Account]:
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
    return query if anybody else query.where(Membership.class_id.in_(_class_ids(reader, module, STAFF)))


def find_member_for_reader(db: Session, reader: UUID | None, author: UUID, module: str) -> Member | None:
    """Return the author as a student of a class of this module whose staff includes the reader; None: any class."""
    row = db.execute(*_member_for_reader(reader or author, author, module, anybody=reader is None)).first()
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
    """Whether an open class of this module, of which the author is a student, has active staff."""
    return select_core(db, *_has_readers(author, module)).first() is not None


def teaches_clause(account_id: UUID, module: str) -> ColumnElement[bool]:
    """Return the condition that an account is staff in a class of this module."""
    return _class_ids(account_id, module, STAFF).exists()


def is_student(db: Session, account_id: UUID, module: str) -> bool:
    """Whether an account is a student of an open class of this module."""
    class_ids = _class_ids(account_id, module, (ClassRole.student,)).where(SchoolClass.archived_at.is_(None))
    return db.execute(select(class_ids.exists())).scalar_one()


@prepared_statement
def _of_teacher(account_id: UUID, module: str) -> Select[SchoolClass]:
    query = select(SchoolClass).where(
        _is_open(module), SchoolClass.id.in_(_class_ids(account_id, module, (ClassRole.teacher,)))
    )
    return query.order_by(SchoolClass.name, SchoolClass.id)


def load_classes_of_teacher(db: Session, account_id: UUID, module: str) -> Sequence[SchoolClass]:
    """Load the open classes of this module that an account teaches, by name."""
    return db.execute(*_of_teacher(account_id, module)).scalars().all()


def load_classes_of_module(db: Session, module: str) -> Sequence[SchoolClass]:
    query = select(SchoolClass).where(_is_open(module))
    return db.execute(query.order_by(SchoolClass.name, SchoolClass.id)).scalars().all()


def _is_open(module: str) -> ColumnElement[bool]:
    return and_(SchoolClass.module == module, SchoolClass.archived_at.is_(None))


def _class_ids(account_id: UUID, module: str, roles: Sequence[ClassRole]) -> Select[UUID]:
    return (
        select(Membership.class_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(
            SchoolClass.module == module,
            Membership.account_id == account_id,
            Membership.status == Status.active,
            equals_any(Membership.role, roles),
        )
    )
