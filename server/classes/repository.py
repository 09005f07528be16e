"""Queries on classes and their members."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import TypeVarTuple
from uuid import UUID

from sqlalchemy import Row, Select, and_, delete, func, select, update
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import (
    ActiveStudent,
    JoinedClass,
    Member,
    StudentRecord,
    display_name,
    distinct_names,
    name_sort_key,
)
from server.database import prepared_statement, select_core
from server.identity.models import Account, account_handle

Ts = TypeVarTuple("Ts")
STAFF = (ClassRole.assistant, ClassRole.teacher)


def find_class(db: Session, class_id: UUID) -> SchoolClass | None:
    return db.get(SchoolClass, class_id)


def lock_class(db: Session, class_id: UUID) -> None:
    """Lock a class until the commit, before changing it or its list."""
    db.execute(select(SchoolClass.id).where(SchoolClass.id == class_id).with_for_update())


def find_class_by_code(db: Session, code: str, now: datetime) -> SchoolClass | None:
    """Return the class that one may join now by this code."""
    query = select(SchoolClass).where(
        SchoolClass.join_code == code, SchoolClass.join_code_until > now, SchoolClass.archived_at.is_(None)
    )
    return db.execute(query).scalar_one_or_none()


def is_code_taken(db: Session, code: str) -> bool:
    return db.execute(select(SchoolClass.id).where(SchoolClass.join_code == code)).first() is not None


def load_joined_classes(db: Session, account_id: UUID) -> Sequence[JoinedClass]:
    """Load the classes that an account is in, or asks to join, with its memberships."""
    query = (
        select(SchoolClass, Membership)
        .join(Membership, Membership.class_id == SchoolClass.id)
        .where(Membership.account_id == account_id, Membership.status != Status.left)
        .order_by(SchoolClass.name, SchoolClass.id)
    )
    return [JoinedClass(*row) for row in db.execute(query)]


def load_visible_classes(db: Session, account: Account) -> Sequence[tuple[SchoolClass, Membership | None]]:
    """Load an account's classes with its memberships; for an administrator all other classes too, without any."""
    joined = [(row.school_class, row.membership) for row in load_joined_classes(db, account.id)]
    if not account.is_administrator:
        return joined
    joined_ids = {school_class.id for school_class, _ in joined}
    classes = db.execute(select(SchoolClass).order_by(SchoolClass.name, SchoolClass.id)).scalars()
    return [*joined, *((school_class, None) for school_class in classes if school_class.id not in joined_ids)]


def load_all_joined_classes(db: Session, account_id: UUID) -> Sequence[JoinedClass]:
    """Load an account's classes, those that it has left included."""
    query = select(SchoolClass, Membership).join(Membership, Membership.class_id == SchoolClass.id)
    query = query.where(Membership.account_id == account_id).order_by(Membership.joined_at)
    return [JoinedClass(*row) for row in db.execute(query)]


def find_membership(db: Session, class_id: UUID, account_id: UUID) -> Membership | None:
    return db.get(Membership, (class_id, account_id))


def load_class_and_membership(
    db: Session, class_id: UUID, account_id: UUID
) -> Row[SchoolClass, Membership | None] | None:
    """Load a class with an account's membership of it, in one query."""
    own = and_(Membership.class_id == SchoolClass.id, Membership.account_id == account_id)
    query = select(SchoolClass, Membership).outerjoin(Membership, own).where(SchoolClass.id == class_id)
    return db.execute(query).one_or_none()


def load_members(db: Session, class_id: UUID, only: Collection[UUID] | None = None) -> Sequence[Member]:
    """Load all members of a class, former ones included, or some of them, sorted by name."""
    query = _select_members(class_id)
    return _load_sorted_members(db, query if only is None else query.where(Membership.account_id.in_(only)))


def load_staff(db: Session, class_id: UUID) -> Sequence[Member]:
    """Load the members that assist or teach, or did, sorted by name."""
    return _load_sorted_members(db, _select_members(class_id).where(Membership.role.in_(STAFF)))


def _select_members(class_id: UUID) -> Select[Membership, Account]:
    query = select(Membership, Account).join(Account, Account.id == Membership.account_id)
    return query.where(Membership.class_id == class_id)


def _load_sorted_members(db: Session, query: Select[Membership, Account]) -> Sequence[Member]:
    members = [Member(*row) for row in db.execute(query)]
    names = distinct_names([(member.plain_name, member.groups, member.account.handle) for member in members])
    members = [
        member if name == member.plain_name else replace(member, distinct_name=name)
        for member, name in zip(members, names, strict=True)
    ]
    return sorted(members, key=lambda member: (*member.sort_key, str(member.id)))


def load_active_students(db: Session, class_id: UUID) -> Sequence[ActiveStudent]:
    """Load the active students of a class, sorted by name."""
    names = (Membership.given_name, Membership.family_name, Account.name)
    handle = (Account.login, Account.role)
    query = select(Membership.account_id, *names, *handle, Membership.groups, Membership.last_seen_at)
    rows = db.execute(_restrict_to_active_students(query, class_id)).all()
    own_names = [display_name(given, family, own) for _, given, family, own, *_ in rows]
    shown = distinct_names(
        [(name, row[6], account_handle(row[4], row[5], row[0])) for name, row in zip(own_names, rows, strict=True)]
    )
    students = []
    for (account_id, _, family, _, _, _, groups, seen_at), name, told in zip(rows, own_names, shown, strict=True):
        student = ActiveStudent(account_id, told, tuple(groups), seen_at)
        students.append((name_sort_key(family, name), str(account_id), student))
    return [student for *_, student in sorted(students, key=lambda row: row[:2])]


def load_student_records(db: Session, class_id: UUID, only: Collection[UUID] | None = None) -> Sequence[StudentRecord]:
    """Load the records of the active students of a class, or of some of them, sorted by name."""
    row = Membership
    columns = (
        row.account_id,
        row.family_name,
        row.given_name,
        Account.name,
        row.email,
        Account.login,
        Account.role,
        row.groups,
    )
    query = _restrict_to_active_students(select(*columns), class_id)
    rows = db.execute(query if only is None else query.where(row.account_id.in_(only))).all()
    names = distinct_names(
        [(display_name(row[2], row[1], row[3]), row[7], account_handle(row[5], row[6], row[0])) for row in rows]
    )
    students = (
        StudentRecord(account_id, name, family, given, email, login or "", tuple(groups))
        for (account_id, family, given, _, email, login, _, groups), name in zip(rows, names, strict=True)
    )
    return sorted(students, key=lambda student: (*student.sort_key, str(student.id)))


def _restrict_to_active_students(query: Select[*Ts], class_id: UUID) -> Select[*Ts]:
    """Restrict a query on memberships and accounts to the active students of a class."""
    query = query.join(Account, Account.id == Membership.account_id).where(Membership.class_id == class_id)
    return query.where(Membership.role == ClassRole.student, Membership.status == Status.active)


def count_students(db: Session, classes: Collection[UUID]) -> Mapping[UUID, tuple[int, int]]:
    """Count the active students and the pending requests of each class."""
    query = select(Membership.class_id, Membership.status, func.count()).where(
        Membership.class_id.in_(classes), Membership.role == ClassRole.student
    )
    rows = db.execute(query.group_by(Membership.class_id, Membership.status))
    counts = {(class_id, status): count for class_id, status, count in rows}
    return {key: (counts.get((key, Status.active), 0), counts.get((key, Status.pending), 0)) for key in classes}


def count_other_teachers(db: Session, class_id: UUID, account_id: UUID) -> int:
    query = select(func.count()).select_from(Membership)
    query = query.where(
        Membership.class_id == class_id,
        Membership.account_id != account_id,
        Membership.role == ClassRole.teacher,
        Membership.status == Status.active,
    )
    return db.execute(query).scalar_one()


def filter_staff_accounts(db: Session, accounts: Collection[UUID]) -> frozenset[UUID]:
    """Return those of these accounts that assist or teach in some class."""
    query = select(Membership.account_id).where(Membership.account_id.in_(accounts), Membership.role.in_(STAFF))
    return frozenset(db.execute(query).scalars())


def load_student_ids_of_teacher(db: Session, teacher_id: UUID) -> frozenset[UUID]:
    """Load the active students of all classes of a teacher."""
    taught = select(Membership.class_id).where(
        Membership.account_id == teacher_id, Membership.role == ClassRole.teacher, Membership.status == Status.active
    )
    query = select(Membership.account_id).where(
        Membership.class_id.in_(taught), Membership.role == ClassRole.student, Membership.status == Status.active
    )
    return frozenset(db.execute(query).scalars())


def load_taught_classes(db: Session, teacher_id: UUID) -> Sequence[SchoolClass]:
    """Load the classes that an account teaches and that are not archived, sorted by name."""
    query = select(SchoolClass).join(Membership, Membership.class_id == SchoolClass.id)
    query = query.where(
        Membership.account_id == teacher_id,
        Membership.role == ClassRole.teacher,
        Membership.status == Status.active,
        SchoolClass.archived_at.is_(None),
    )
    return db.execute(query.order_by(SchoolClass.name, SchoolClass.id)).scalars().all()


def load_accounts_by_login(db: Session, logins: Collection[str]) -> Mapping[str, Account]:
    """Load accounts by login, in chunks: databases bound the number of parameters."""
    accounts: dict[str, Account] = {}
    ordered = list(logins)
    for start in range(0, len(ordered), 500):
        query = select(Account).where(Account.login.in_(ordered[start : start + 500]))
        accounts.update({account.login: account for account in db.execute(query).scalars() if account.login})
    return accounts


def move_memberships(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's memberships to an account; where both have one, the account's own becomes active if the guest's
    is."""
    own = {membership.class_id: membership for membership in _load_memberships(db, account_id)}
    for membership in _load_memberships(db, guest_id):
        existing = own.get(membership.class_id)
        if existing is None:
            db.execute(
                update(Membership)
                .where(Membership.class_id == membership.class_id, Membership.account_id == guest_id)
                .values(account_id=account_id)
                .execution_options(synchronize_session=False)
            )
        elif existing.status != Status.active and membership.status == Status.active:
            existing.status, existing.left_at = Status.active, None
    db.flush()
    statement = delete(Membership).where(Membership.account_id == guest_id)
    db.execute(statement.execution_options(synchronize_session=False))
    db.expire_all()


def _load_memberships(db: Session, account_id: UUID) -> Sequence[Membership]:
    return db.execute(select(Membership).where(Membership.account_id == account_id)).scalars().all()


def update_last_seen(db: Session, account_id: UUID, now: datetime, unless_since: datetime) -> None:
    """Update when a member was last seen, unless it was updated since `unless_since`."""
    db.execute(
        update(Membership)
        .where(
            Membership.account_id == account_id,
            Membership.status == Status.active,
            Membership.last_seen_at.is_(None) | (Membership.last_seen_at < unless_since),
        )
        .values(last_seen_at=now)
        .execution_options(synchronize_session=False)
    )


@prepared_statement
def _select_presence(account_id: UUID) -> Select[datetime | None, datetime | None]:
    return (
        select(Membership.last_seen_at, SchoolClass.archived_at)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(Membership.account_id == account_id, Membership.status == Status.active)
    )


def load_presence(db: Session, account_id: UUID) -> Sequence[Row[datetime | None, datetime | None]]:
    """Load, for each class of an active member, when they were last seen there and when it was archived."""
    return select_core(db, *_select_presence(account_id)).all()


def is_presence_stale(db: Session, account_id: UUID, unless_since: datetime) -> bool:
    query = select(Membership.class_id).where(
        Membership.account_id == account_id,
        Membership.status == Status.active,
        Membership.last_seen_at.is_(None) | (Membership.last_seen_at < unless_since),
    )
    return db.execute(query.limit(1)).first() is not None
