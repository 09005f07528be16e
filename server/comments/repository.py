"""Queries on threads and their messages."""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, and_, func, or_, select, tuple_, update
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.comments.models import Message, Thread, ThreadState
from server.comments.readers_repository import select_readable_threads, unread_clause
from server.comments.schemas import AuthoredMessage
from server.identity.models import Account
from server.submissions.models import Submission

#: Earlier attempts whose threads are tracked to a later one; threads shown at once.
MAX_TRACKED_ATTEMPTS = 3
MAX_THREADS_SHOWN = 100


def find_thread(db: Session, thread_id: UUID) -> Thread | None:
    return db.get(Thread, thread_id)


def lock_thread(db: Session, thread_id: UUID) -> None:
    """Lock a thread until the commit, before adding to it."""
    db.execute(select(Thread.id).where(Thread.id == thread_id).with_for_update())


def count_messages(db: Session, thread_id: UUID) -> int:
    query = select(func.count()).select_from(Message).where(Message.thread_id == thread_id)
    return db.execute(query).scalar_one()


def count_threads(db: Session, account_id: UUID, exercise: str) -> int:
    query = select(func.count()).select_from(Thread).where(_is_thread_on_exercise(account_id, exercise))
    return db.execute(query).scalar_one()


def load_threads_for_submission(db: Session, submission: Submission) -> Sequence[Thread]:
    """Load the threads of a submission, and the unsettled ones on lines of the author's earlier submissions."""
    earlier = select(Submission.id).where(
        Submission.account_id == submission.account_id,
        Submission.exercise == submission.exercise,
        tuple_(Submission.created_at, Submission.id) < (submission.created_at, submission.id),
    )
    carried = and_(
        Thread.first_line.is_not(None), Thread.state != ThreadState.settled, Thread.submission_id.in_(earlier)
    )
    query = select(Thread).where(
        _is_thread_on_exercise(submission.account_id, submission.exercise),
        or_(Thread.submission_id == submission.id, Thread.submission_id.is_(None), carried),
    )
    query = query.order_by(Thread.work_at.desc(), Thread.created_at.desc(), Thread.id)
    return db.execute(query.limit(MAX_THREADS_SHOWN)).scalars().all()


def load_exercise_threads(
    db: Session, account_id: UUID, exercise: str, until: datetime | None = None
) -> Sequence[Thread]:
    """Load the threads on a student's work in an exercise, newest first; `until` limits them to earlier work."""
    query = select(Thread).where(_is_thread_on_exercise(account_id, exercise))
    query = query if until is None else query.where(Thread.work_at <= until)
    return db.execute(query.order_by(Thread.changed_at.desc(), Thread.id).limit(MAX_THREADS_SHOWN)).scalars().all()


def load_messages(db: Session, threads: Collection[UUID]) -> Mapping[UUID, Sequence[AuthoredMessage]]:
    """Load the messages of each thread, oldest first."""
    return dict.fromkeys(threads, ()) | _load_messages(db, Message.thread_id.in_(threads))


def load_account_messages(db: Session, account_id: UUID) -> Mapping[UUID, Sequence[AuthoredMessage]]:
    """Load the messages of all threads on a student's work."""
    own = select(Thread.id).where(Thread.account_id == account_id)
    return _load_messages(db, Message.thread_id.in_(own))


def _load_messages(db: Session, condition: ColumnElement[bool]) -> dict[UUID, Sequence[AuthoredMessage]]:
    query = select(Message, Account.name).outerjoin(Account, Account.id == Message.author_id).where(condition)
    messages: dict[UUID, list[AuthoredMessage]] = {}
    for message, name in db.execute(query.order_by(Message.created_at, Message.id)):
        messages.setdefault(message.thread_id, []).append(AuthoredMessage(message, name or ""))
    return dict(messages)


def load_submissions(db: Session, submissions: Collection[UUID]) -> Mapping[UUID, Submission]:
    query = select(Submission).where(Submission.id.in_(submissions))
    return {submission.id: submission for submission in db.execute(query).scalars()}


def load_exercise_page_threads(db: Session, account_id: UUID, exercise: str) -> Sequence[Thread]:
    """Load a student's last threads on an exercise as a whole, and the unread ones on attempts, oldest first."""
    whole = and_(_is_thread_on_exercise(account_id, exercise), Thread.submission_id.is_(None))
    unread = and_(
        Thread.exercise == exercise, unread_clause(account_id), Thread.id.in_(select_readable_threads(account_id))
    )
    query = select(Thread).where(or_(whole, unread))
    newest_first = query.order_by(Thread.created_at.desc(), Thread.id.desc()).limit(MAX_THREADS_SHOWN)
    return db.execute(newest_first).scalars().all()[::-1]


def load_attempt_numbers(
    db: Session, account_id: UUID, exercise: str, submissions: Collection[UUID]
) -> Mapping[UUID, int]:
    """Number these attempts among their author's attempts at the exercise, from 1."""
    number = func.row_number().over(order_by=(Submission.created_at, Submission.id)).label("number")
    query = select(Submission.id, number).where(Submission.account_id == account_id, Submission.exercise == exercise)
    numbered = query.subquery()
    rows = db.execute(select(numbered.c.id, numbered.c.number).where(numbered.c.id.in_(submissions)))
    return dict(rows.all())


def load_class_threads(
    db: Session, school_class: SchoolClass, state: ThreadState | None, *, limit: int, offset: int
) -> Sequence[tuple[Thread, Membership, Account, str, int]]:
    """Load threads on the work of a class's students, newest first, with their first message and message count."""
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
        .where(_is_readable_by_class_staff(school_class))
        .order_by(Thread.changed_at.desc(), Thread.id)
    )
    query = query if state is None else query.where(Thread.state == state)
    return [tuple(row) for row in db.execute(query.limit(limit).offset(offset))]


def count_class_threads(db: Session, school_class: SchoolClass) -> Mapping[str, int]:
    query = (
        select(Thread.state, func.count())
        .join(Membership, Membership.account_id == Thread.account_id)
        .where(_is_readable_by_class_staff(school_class))
        .group_by(Thread.state)
    )
    return dict(db.execute(query).all())


def count_open_questions_by_class(db: Session, classes: Collection[UUID]) -> Mapping[UUID, int]:
    """Count the open questions of each of these classes; classes without any are left out."""
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


def count_open_questions(db: Session, account_id: UUID, until: datetime | None) -> Mapping[str, int]:
    query = select(Thread.exercise, func.count()).where(
        Thread.account_id == account_id, Thread.state == ThreadState.open
    )
    query = query if until is None else query.where(Thread.work_at <= until)
    return dict(db.execute(query.group_by(Thread.exercise)).all())


def _is_readable_by_class_staff(school_class: SchoolClass) -> ColumnElement[bool]:
    """The condition on threads that the staff of a class may read (see `server.rights`)."""
    is_or_was_member = or_(
        Membership.status == Status.active, and_(Membership.status == Status.left, Membership.left_at >= Thread.work_at)
    )
    conditions = [
        Membership.class_id == school_class.id,
        Membership.role == ClassRole.student,
        is_or_was_member,
        Thread.exercise.startswith(f"{school_class.module}/", autoescape=True),
    ]
    if school_class.archived_at is not None:
        conditions.append(Thread.work_at <= school_class.archived_at)
    return and_(*conditions)


def move_threads(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's threads and messages to an account."""
    threads = update(Thread).where(Thread.account_id == guest_id).values(account_id=account_id)
    messages = update(Message).where(Message.author_id == guest_id).values(author_id=account_id)
    for statement in (threads, messages):
        db.execute(statement.execution_options(synchronize_session=False))


def load_account_threads(db: Session, account_id: UUID) -> Sequence[Thread]:
    query = select(Thread).where(Thread.account_id == account_id)
    return db.execute(query.order_by(Thread.created_at, Thread.id)).scalars().all()


def load_staff_messages(db: Session, account_id: UUID) -> Sequence[tuple[Message, str]]:
    """Load an account's messages on the work of others, each with its exercise."""
    query = select(Message, Thread.exercise).join(Thread, Thread.id == Message.thread_id)
    query = query.where(Message.author_id == account_id, Message.as_staff)
    return [(message, exercise) for message, exercise in db.execute(query.order_by(Message.created_at, Message.id))]


def _is_thread_on_exercise(account_id: UUID, exercise: str) -> ColumnElement[bool]:
    return and_(Thread.account_id == account_id, Thread.exercise == exercise)
