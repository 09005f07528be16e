"""Queries on threads and their messages."""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, func, or_, select, tuple_, type_coerce, update
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.comments.models import Message, Thread, ThreadState
from server.comments.schemas import AuthoredMessage, UnreadThread
from server.database import END_OF_TIME, ask, prepared, rows_of, table_of
from server.identity.models import Account
from server.submissions.models import Submission

#: Attempts before this one, and threads on each exercise, that are looked at again.
MAX_TRACKED_ATTEMPTS = 3
MAX_THREADS_SHOWN = 300
MAX_UNREAD_THREADS = 30


def find_thread(db: Session, thread_id: UUID) -> Thread | None:
    return db.get(Thread, thread_id)


def lock_thread(db: Session, thread_id: UUID) -> None:
    """Until the commit, nobody else adds to this thread who locks it first."""
    db.execute(select(Thread.id).where(Thread.id == thread_id).with_for_update())


def count_messages(db: Session, thread_id: UUID) -> int:
    query = select(func.count()).select_from(Message).where(Message.thread_id == thread_id)
    return db.execute(query).scalar_one()


def count_threads(db: Session, account_id: UUID, exercise: str) -> int:
    query = select(func.count()).select_from(Thread).where(_of(account_id, exercise))
    return db.execute(query).scalar_one()


@prepared
def _on(account_id: UUID, exercise: str, sent_at: datetime, submission_id: UUID) -> Select[*tuple[Any, ...]]:
    at, name = type_coerce(sent_at, Submission.created_at.type), type_coerce(submission_id, Submission.id.type)
    earlier = select(Submission.id).where(
        Submission.account_id == account_id,
        Submission.exercise == exercise,
        tuple_(Submission.created_at, Submission.id) < tuple_(at, name),
    )
    carried = and_(
        Thread.first_line.is_not(None), Thread.state != ThreadState.settled, Thread.submission_id.in_(earlier)
    )
    query = select(*table_of(Thread).c).where(
        _of(account_id, exercise),
        or_(Thread.submission_id == submission_id, Thread.submission_id.is_(None), carried),
    )
    return query.order_by(Thread.work_at.desc(), Thread.created_at.desc(), Thread.id).limit(MAX_THREADS_SHOWN)


def load_threads_for_submission(db: Session, submission: Submission) -> Sequence[Thread]:
    """The threads of a submission, and those on lines of earlier ones by the same author that are not settled."""
    asked = _on(submission.account_id, submission.exercise, submission.created_at, submission.id)
    return [thread for thread, _ in rows_of(Thread, ask(db, *asked))]


def load_exercise_threads(
    db: Session, account_id: UUID, exercise: str, until: datetime | None = None
) -> Sequence[Thread]:
    """All the threads on somebody's work in an exercise, newest first; of work from before `until` alone."""
    query = select(Thread).where(_of(account_id, exercise))
    query = query if until is None else query.where(Thread.work_at <= until)
    return db.execute(query.order_by(Thread.changed_at.desc(), Thread.id).limit(MAX_THREADS_SHOWN)).scalars().all()


def load_messages(db: Session, threads: Collection[UUID]) -> Mapping[UUID, Sequence[AuthoredMessage]]:
    """The messages of each thread, oldest first."""
    return dict.fromkeys(threads, ()) | _said(db, Message.thread_id.in_(threads))


def load_account_messages(db: Session, account_id: UUID) -> Mapping[UUID, Sequence[AuthoredMessage]]:
    """The messages of all threads on somebody's work."""
    mine = select(Thread.id).where(Thread.account_id == account_id)
    return _said(db, Message.thread_id.in_(mine))


def _said(db: Session, which: ColumnElement[bool]) -> dict[UUID, Sequence[AuthoredMessage]]:
    query = select(Message, Account.name).outerjoin(Account, Account.id == Message.author_id).where(which)
    found: dict[UUID, list[AuthoredMessage]] = {}
    for message, name in db.execute(query.order_by(Message.created_at, Message.id)):
        found.setdefault(message.thread_id, []).append(AuthoredMessage(message, name or ""))
    return dict(found)


def load_submissions(db: Session, submissions: Collection[UUID]) -> Mapping[UUID, Submission]:
    query = select(Submission).where(Submission.id.in_(submissions))
    return {one.id: one for one in db.execute(query).scalars()}


@prepared
def _on_page(account_id: UUID, exercise: str) -> Select[*tuple[Any, ...]]:
    query = select(*table_of(Thread).c).where(_of(account_id, exercise), or_(Thread.submission_id.is_(None), _is_new()))
    return query.order_by(Thread.created_at, Thread.id).limit(MAX_THREADS_SHOWN)


def load_page_threads(db: Session, account_id: UUID, exercise: str) -> Sequence[Thread]:
    """The threads on an exercise as a whole, and those that its student has not read, oldest first."""
    return [thread for thread, _ in rows_of(Thread, ask(db, *_on_page(account_id, exercise)))]


def _is_new() -> ColumnElement[bool]:
    """As `server.comments.schemas.is_new`."""
    return and_(Thread.staff_at.is_not(None), or_(Thread.seen_at.is_(None), Thread.seen_at < Thread.staff_at))


def load_attempt_numbers(db: Session, account_id: UUID, exercise: str, wanted: Collection[UUID]) -> Mapping[UUID, int]:
    """Of some attempts, which each is among its author's at the exercise: 1 for the first."""
    place = func.row_number().over(order_by=(Submission.created_at, Submission.id)).label("place")
    query = select(Submission.id, place).where(Submission.account_id == account_id, Submission.exercise == exercise)
    placed = query.subquery()
    rows = db.execute(select(placed.c.id, placed.c.place).where(placed.c.id.in_(wanted)))
    return dict(rows.all())


def load_unread_threads(db: Session, account_id: UUID) -> Sequence[UnreadThread]:
    """What somebody was told and has not looked at, newest first, each thread with its last message."""
    last = (
        select(Message.text)
        .where(Message.thread_id == Thread.id)
        .order_by(Message.created_at.desc(), Message.id.desc())
        .limit(1)
        .scalar_subquery()
    )
    query = select(Thread, last).where(Thread.account_id == account_id, _is_new())
    rows = db.execute(query.order_by(Thread.changed_at.desc(), Thread.id).limit(MAX_UNREAD_THREADS))
    return [UnreadThread(thread, text or "") for thread, text in rows]


def mark_seen(db: Session, threads: Collection[UUID], now: datetime) -> None:
    db.execute(
        update(Thread).where(Thread.id.in_(threads)).values(seen_at=now).execution_options(synchronize_session=False)
    )


def load_class_threads(
    db: Session, school_class: SchoolClass, state: ThreadState | None, *, most: int, skipped: int
) -> Sequence[tuple[Thread, Membership, Account, str, int]]:
    """Threads on the work of a class's students, newest first, with their first message and how many there are."""
    first = (
        select(Message.text)
        .where(Message.thread_id == Thread.id)
        .order_by(Message.created_at, Message.id)
        .limit(1)
        .scalar_subquery()
    )
    count = select(func.count()).where(Message.thread_id == Thread.id).scalar_subquery()
    query = (
        select(Thread, Membership, Account, first, count)
        .join(Membership, Membership.account_id == Thread.account_id)
        .join(Account, Account.id == Thread.account_id)
        .where(_read_in(school_class))
        .order_by(Thread.changed_at.desc(), Thread.id)
    )
    query = query if state is None else query.where(Thread.state == state)
    return [tuple(row) for row in db.execute(query.limit(most).offset(skipped))]


def count_class_threads(db: Session, school_class: SchoolClass) -> Mapping[str, int]:
    query = (
        select(Thread.state, func.count())
        .join(Membership, Membership.account_id == Thread.account_id)
        .where(_read_in(school_class))
        .group_by(Thread.state)
    )
    return dict(db.execute(query).all())


def count_open_questions_by_class(db: Session, classes: Collection[UUID]) -> Mapping[UUID, int]:
    """How many questions wait for an answer in each of these classes; none is left out of the answer but at 0."""
    query = (
        select(Membership.class_id, func.count())
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .join(Thread, Thread.account_id == Membership.account_id)
        .where(
            Membership.class_id.in_(classes),
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            SchoolClass.archived_at.is_(None),
            Thread.exercise.startswith(SchoolClass.module + "/"),
            Thread.state == ThreadState.open,
        )
        .group_by(Membership.class_id)
    )
    return dict(db.execute(query).all())


@prepared
def _open_of(account_id: UUID, until: datetime, *, all_times: bool) -> Select[str, int]:
    query = select(Thread.exercise, func.count()).where(
        Thread.account_id == account_id, Thread.state == ThreadState.open
    )
    return (query if all_times else query.where(Thread.work_at <= until)).group_by(Thread.exercise)


def count_open_questions(db: Session, account_id: UUID, until: datetime | None) -> Mapping[str, int]:
    return dict(ask(db, *_open_of(account_id, until or END_OF_TIME, all_times=until is None)).all())


def _read_in(school_class: SchoolClass) -> ColumnElement[bool]:
    """Of the students of a class, in its module, what its staff may read (see `server.rights`)."""
    there = or_(
        Membership.status == Status.active, and_(Membership.status == Status.left, Membership.left_at >= Thread.work_at)
    )
    conditions = [
        Membership.class_id == school_class.id,
        Membership.role == ClassRole.student,
        there,
        Thread.exercise.startswith(f"{school_class.module}/", autoescape=True),
    ]
    if school_class.archived_at is not None:
        conditions.append(Thread.work_at <= school_class.archived_at)
    return and_(*conditions)


def move_threads(db: Session, old: UUID, new: UUID) -> None:
    """Gives an account what a guest has asked and was told."""
    unsynchronised = {"synchronize_session": False}
    moved = update(Thread).where(Thread.account_id == old).values(account_id=new)
    written = update(Message).where(Message.author_id == old).values(author_id=new)
    for statement in (moved, written):
        db.execute(statement.execution_options(**unsynchronised))


def load_account_threads(db: Session, account_id: UUID) -> Sequence[Thread]:
    query = select(Thread).where(Thread.account_id == account_id)
    return db.execute(query.order_by(Thread.created_at, Thread.id)).scalars().all()


def load_staff_messages(db: Session, account_id: UUID) -> Sequence[tuple[Message, str]]:
    """What somebody has written on the work of others, each with its exercise."""
    query = select(Message, Thread.exercise).join(Thread, Thread.id == Message.thread_id)
    query = query.where(Message.author_id == account_id, Message.as_staff)
    return [(message, exercise) for message, exercise in db.execute(query.order_by(Message.created_at, Message.id))]


def _of(account_id: UUID, exercise: str) -> ColumnElement[bool]:
    return and_(Thread.account_id == account_id, Thread.exercise == exercise)
