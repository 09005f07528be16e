"""Queries on classes and their members."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import Row, Select, and_, delete, func, select, update
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import ActiveStudent, JoinedClass, Member, StudentRecord, display_name, name_sort_key
from server.database import ask, one_of, prepared, rows_of, table_of
from server.identity.models import Account

STAFF = (ClassRole.assistant, ClassRole.teacher)


def find_class(db: Session, class_id: UUID) -> SchoolClass | None:
    return db.get(SchoolClass, class_id)


def lock_class(db: Session, class_id: UUID) -> None:
    """Until the commit, nobody else changes the class or its list who locks it first."""
    db.execute(select(SchoolClass.id).where(SchoolClass.id == class_id).with_for_update())


def find_class_by_code(db: Session, code: str, now: datetime) -> SchoolClass | None:
    """The class that one joins by this code, where it is still good."""
    query = select(SchoolClass).where(
        SchoolClass.join_code == code, SchoolClass.join_code_until > now, SchoolClass.archived_at.is_(None)
    )
    return db.execute(query).scalar_one_or_none()


def code_is_taken(db: Session, code: str) -> bool:
    return db.execute(select(SchoolClass.id).where(SchoolClass.join_code == code)).first() is not None


def load_joined_classes(db: Session, account_id: UUID) -> Sequence[JoinedClass]:
    """The classes that an account is in, or asks to be in, with what it is there."""
    query = (
        select(SchoolClass, Membership)
        .join(Membership, Membership.class_id == SchoolClass.id)
        .where(Membership.account_id == account_id, Membership.status != Status.left)
        .order_by(SchoolClass.name, SchoolClass.id)
    )
    return [JoinedClass(*row) for row in db.execute(query)]


def load_visible_classes(db: Session, account: Account) -> Sequence[tuple[SchoolClass, Membership | None]]:
    """The same; for an administrator every other class too, where they are nothing."""
    mine = [(one.school_class, one.membership) for one in load_joined_classes(db, account.id)]
    if not account.is_administrator:
        return mine
    known = {school_class.id for school_class, _ in mine}
    every = db.execute(select(SchoolClass).order_by(SchoolClass.name, SchoolClass.id)).scalars()
    return [*mine, *((one, None) for one in every if one.id not in known)]


def load_all_joined_classes(db: Session, account_id: UUID) -> Sequence[JoinedClass]:
    """Those that it has left too."""
    query = select(SchoolClass, Membership).join(Membership, Membership.class_id == SchoolClass.id)
    query = query.where(Membership.account_id == account_id).order_by(Membership.joined_at)
    return [JoinedClass(*row) for row in db.execute(query)]


def find_membership(db: Session, class_id: UUID, account_id: UUID) -> Membership | None:
    return db.get(Membership, (class_id, account_id))


@prepared
def _seen_by(class_id: UUID, account_id: UUID) -> Select[SchoolClass, Membership | None]:
    seat = and_(Membership.class_id == SchoolClass.id, Membership.account_id == account_id)
    return select(SchoolClass, Membership).outerjoin(Membership, seat).where(SchoolClass.id == class_id)


def load_class_and_membership(
    db: Session, class_id: UUID, account_id: UUID
) -> Row[SchoolClass, Membership | None] | None:
    """A class, and what an account is in it, in one question."""
    return db.execute(*_seen_by(class_id, account_id)).one_or_none()


@prepared
def _members(class_id: UUID) -> Select[Membership, Account]:
    query = select(Membership, Account).join(Account, Account.id == Membership.account_id)
    return query.where(Membership.class_id == class_id)


@prepared
def _some(class_id: UUID, accounts: Collection[UUID]) -> Select[Membership, Account]:
    query = select(Membership, Account).join(Account, Account.id == Membership.account_id)
    return query.where(Membership.class_id == class_id, Membership.account_id.in_(accounts))


@prepared
def _staff(class_id: UUID) -> Select[Membership, Account]:
    query = select(Membership, Account).join(Account, Account.id == Membership.account_id)
    return query.where(Membership.class_id == class_id, one_of(Membership.role, STAFF))


def load_members(db: Session, class_id: UUID, only: Collection[UUID] | None = None) -> Sequence[Member]:
    """All that ever were, or some, in the order of a list of names."""
    return _listed(db, *(_members(class_id) if only is None else _some(class_id, only)))


@prepared
def _everyone(class_id: UUID) -> Select[*tuple[Any, ...]]:
    query = select(*table_of(Membership).c, *table_of(Account).c).select_from(Membership)
    return query.join(Account, Account.id == Membership.account_id).where(Membership.class_id == class_id)


def everyone(db: Session, class_id: UUID) -> Sequence[Member]:
    """All members for who only looks at them: what is given back is not the session's."""
    seats = list(rows_of(Membership, ask(db, *_everyone(class_id))))
    accounts = rows_of(Account, (rest for _, rest in seats))
    return _in_order(Member(seat, account) for (seat, _), (account, _) in zip(seats, accounts, strict=True))


def load_staff(db: Session, class_id: UUID) -> Sequence[Member]:
    """The members that help or teach there, and those that did."""
    return _listed(db, *_staff(class_id))


@prepared
def _learners(class_id: UUID) -> Select[UUID, str | None, str | None, str, list[str], datetime | None]:
    seat, account = table_of(Membership), table_of(Account)
    names = (seat.c.given_name, seat.c.family_name, account.c.name)
    query = select(seat.c.account_id, *names, seat.c.groups, seat.c.last_seen_at)
    query = query.join(account, account.c.id == seat.c.account_id).where(seat.c.class_id == class_id)
    return query.where(seat.c.role == ClassRole.student, seat.c.status == Status.active)


def load_active_students(db: Session, class_id: UUID) -> Sequence[ActiveStudent]:
    """The students of now, in the order of a list of names."""
    found = []
    for identity, given, family, own, groups, seen_at in ask(db, *_learners(class_id)).all():
        learner = ActiveStudent(identity, display_name(given, family, own), tuple(groups), seen_at)
        found.append((name_sort_key(family, learner.name), str(identity), learner))
    return [learner for *_, learner in sorted(found, key=lambda one: one[:2])]


def list_students(db: Session, class_id: UUID, only: Collection[UUID] | None = None) -> Sequence[StudentRecord]:
    """Load the active students of a class, or some of them, in the order of a list of names."""
    seat = Membership
    columns = (seat.account_id, seat.family_name, seat.given_name, Account.name, seat.email, Account.login, seat.groups)
    query = select(*columns).join(Account, Account.id == seat.account_id)
    query = query.where(seat.class_id == class_id, seat.role == ClassRole.student, seat.status == Status.active)
    rows = db.execute(query if only is None else query.where(seat.account_id.in_(only)))
    students = (
        StudentRecord(account_id, display_name(given, family, own), family, given, email, login or "", tuple(groups))
        for account_id, family, given, own, email, login, groups in rows
    )
    return sorted(students, key=lambda student: (*student.sort_key, str(student.id)))


def _listed(db: Session, query: Select[Membership, Account], values: Mapping[str, object]) -> Sequence[Member]:
    return _in_order(Member(*row) for row in db.execute(query, values))


def _in_order(found: Iterable[Member]) -> Sequence[Member]:
    return sorted(found, key=lambda member: (*member.sort_key, str(member.id)))


@prepared
def _counts(classes: Collection[UUID]) -> Select[UUID, str, int]:
    return (
        select(Membership.class_id, Membership.status, func.count())
        .where(
            Membership.class_id.in_(classes),
            Membership.role == ClassRole.student,
            one_of(Membership.status, (Status.active, Status.pending)),
        )
        .group_by(Membership.class_id, Membership.status)
    )


def count_students(db: Session, classes: Collection[UUID]) -> Mapping[UUID, tuple[int, int]]:
    """How many students each class has, and how many ask to join it."""
    found = {(class_id, status): count for class_id, status, count in ask(db, *_counts(classes))}
    return {one: (found.get((one, Status.active), 0), found.get((one, Status.pending), 0)) for one in classes}


def count_other_teachers(db: Session, class_id: UUID, account_id: UUID) -> int:
    query = select(func.count()).select_from(Membership)
    query = query.where(
        Membership.class_id == class_id,
        Membership.account_id != account_id,
        Membership.role == ClassRole.teacher,
        Membership.status == Status.active,
    )
    return db.execute(query).scalar_one()


def filter_staff(db: Session, accounts: Collection[UUID]) -> frozenset[UUID]:
    """Those of these accounts that help or teach in some class."""
    query = select(Membership.account_id).where(Membership.account_id.in_(accounts), Membership.role.in_(STAFF))
    return frozenset(db.execute(query).scalars())


def load_student_ids_of_teacher(db: Session, teacher_id: UUID) -> frozenset[UUID]:
    """The students whom a teacher or an assistant has in some class already."""
    taught = select(Membership.class_id).where(
        Membership.account_id == teacher_id, Membership.role == ClassRole.teacher, Membership.status == Status.active
    )
    query = select(Membership.account_id).where(
        Membership.class_id.in_(taught), Membership.role == ClassRole.student, Membership.status == Status.active
    )
    return frozenset(db.execute(query).scalars())


def load_accounts_by_login(db: Session, logins: Collection[str]) -> Mapping[str, Account]:
    """The accounts that have these logins, some hundred at a time: databases bound how much one asks."""
    found: dict[str, Account] = {}
    wanted = list(logins)
    for start in range(0, len(wanted), 500):
        query = select(Account).where(Account.login.in_(wanted[start : start + 500]))
        found.update({account.login: account for account in db.execute(query).scalars() if account.login})
    return found


def move_memberships(db: Session, old: UUID, new: UUID) -> None:
    """Gives an account the memberships of a guest; where both have one, the account keeps its own, made good."""
    mine = {one.class_id: one for one in db.execute(_of(new)).scalars()}
    for one in db.execute(_of(old)).scalars().all():
        own = mine.get(one.class_id)
        if own is None:
            db.execute(
                update(Membership)
                .where(Membership.class_id == one.class_id, Membership.account_id == old)
                .values(account_id=new)
                .execution_options(synchronize_session=False)
            )
        elif own.status != Status.active and one.status == Status.active:
            own.status, own.left_at = Status.active, None
    db.flush()
    db.execute(delete(Membership).where(Membership.account_id == old).execution_options(synchronize_session=False))
    db.expire_all()


def _of(account_id: UUID) -> Select[Membership]:
    return select(Membership).where(Membership.account_id == account_id)


def update_last_seen(db: Session, account_id: UUID, now: datetime, unless_since: datetime) -> None:
    """Notes that a member was there, where nothing was noted since `unless_since`."""
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


@prepared
def _presence(account_id: UUID) -> Select[datetime | None, datetime | None]:
    return (
        select(Membership.last_seen_at, SchoolClass.archived_at)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(Membership.account_id == account_id, Membership.status == Status.active)
    )


def load_presence(db: Session, account_id: UUID) -> Sequence[Row[datetime | None, datetime | None]]:
    """Of each class that an account is in: when it was last seen there, when the class was archived."""
    return ask(db, *_presence(account_id)).all()


def is_presence_stale(db: Session, account_id: UUID, unless_since: datetime) -> bool:
    query = select(Membership.class_id).where(
        Membership.account_id == account_id,
        Membership.status == Status.active,
        Membership.last_seen_at.is_(None) | (Membership.last_seen_at < unless_since),
    )
    return db.execute(query.limit(1)).first() is not None
