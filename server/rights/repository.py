"""Queries on staff and students that share a class."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, or_, select
from sqlalchemy.orm import Session, aliased

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import Member
from server.identity.models import Account

STAFF = (ClassRole.assistant, ClassRole.teacher)


def may_read_work(
    db: Session, reader: UUID, author: UUID, module: str, sent_at: datetime, roles: Sequence[ClassRole] = STAFF
) -> bool:
    """Whether the reader has such a role in a class of this module of which the author is, or was then, a student."""
    staff, student = aliased(Membership), aliased(Membership)
    query = (
        select(SchoolClass.id)
        .join(staff, staff.class_id == SchoolClass.id)
        .join(student, student.class_id == SchoolClass.id)
        .where(
            SchoolClass.module == module,
            or_(SchoolClass.archived_at.is_(None), SchoolClass.archived_at >= sent_at),
            staff.account_id == reader,
            staff.role.in_(roles),
            staff.status == Status.active,
            student.account_id == author,
            student.role == ClassRole.student,
            or_(
                student.status == Status.active,
                and_(student.status == Status.left, student.left_at >= sent_at),
            ),
        )
    )
    return db.execute(query.limit(1)).first() is not None


def find_member_for_reader(db: Session, reader: UUID | None, author: UUID, module: str) -> Member | None:
    """Return the author as a student of a class of this module whose staff includes the reader; None: any class."""
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
    )
    if reader is not None:
        query = query.where(Membership.class_id.in_(_select_class_ids_by_role(reader, module, STAFF)))
    row = db.execute(query.limit(1)).first()
    return None if row is None else Member(*row)


def has_staff_readers(db: Session, author: UUID, module: str) -> bool:
    """Whether an open class of this module, of which the author is a student, has active staff."""
    staff = aliased(Membership)
    query = (
        select(SchoolClass.id)
        .join(Membership, Membership.class_id == SchoolClass.id)
        .join(staff, staff.class_id == SchoolClass.id)
        .where(
            _open_class_of_module_clause(module),
            Membership.account_id == author,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            staff.role.in_(STAFF),
            staff.status == Status.active,
        )
    )
    return db.execute(query.limit(1)).first() is not None


def teaches_clause(account_id: UUID, module: str) -> ColumnElement[bool]:
    """Return the condition that an account is staff in a class of this module."""
    return _select_class_ids_by_role(account_id, module, STAFF).exists()


def is_student(db: Session, account_id: UUID, module: str) -> bool:
    """Whether an account is a student of an open class of this module."""
    class_ids = _select_class_ids_by_role(account_id, module, (ClassRole.student,)).where(
        SchoolClass.archived_at.is_(None)
    )
    return db.execute(select(class_ids.exists())).scalar_one()


def load_classes_of_teacher(db: Session, account_id: UUID, module: str) -> Sequence[SchoolClass]:
    """Load the open classes of this module that an account teaches, by name."""
    query = select(SchoolClass).where(
        _open_class_of_module_clause(module),
        SchoolClass.id.in_(_select_class_ids_by_role(account_id, module, (ClassRole.teacher,))),
    )
    return db.execute(query.order_by(SchoolClass.name, SchoolClass.id)).scalars().all()


def load_taught_classes(db: Session, account_id: UUID) -> Sequence[SchoolClass]:
    """Load the open classes that an account teaches, by name."""
    query = (
        select(SchoolClass)
        .join(Membership, Membership.class_id == SchoolClass.id)
        .where(
            Membership.account_id == account_id,
            Membership.role == ClassRole.teacher,
            Membership.status == Status.active,
            SchoolClass.archived_at.is_(None),
        )
    )
    return db.execute(query.order_by(SchoolClass.name, SchoolClass.id)).scalars().all()


def load_classes_of_module(db: Session, module: str) -> Sequence[SchoolClass]:
    query = select(SchoolClass).where(_open_class_of_module_clause(module))
    return db.execute(query.order_by(SchoolClass.name, SchoolClass.id)).scalars().all()


def _open_class_of_module_clause(module: str) -> ColumnElement[bool]:
    return and_(SchoolClass.module == module, SchoolClass.archived_at.is_(None))


def _select_class_ids_by_role(account_id: UUID, module: str, roles: Sequence[ClassRole]) -> Select[UUID]:
    return (
        select(Membership.class_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(
            SchoolClass.module == module,
            Membership.account_id == account_id,
            Membership.status == Status.active,
            Membership.role.in_(roles),
        )
    )
