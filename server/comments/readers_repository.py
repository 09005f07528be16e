"""Queries on who has read a thread: the author of the work, and those who hand it in with them, each for themselves."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, delete, exists, select, update
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise
from server.assignments.team_repository import MINE, OTHER, select_shared_work
from server.comments.models import Message, Thread, ThreadReader
from server.comments.schemas import UnreadThread
from server.database import upsert_statement

MAX_UNREAD_THREADS = 30


def unread_clause(reader: UUID) -> ColumnElement[bool]:
    """Return the condition that a reader has not seen the last staff message of a thread."""
    read = exists().where(
        ThreadReader.thread_id == Thread.id,
        ThreadReader.account_id == reader,
        ThreadReader.seen_at >= Thread.staff_at,
    )
    return and_(Thread.staff_at.is_not(None), ~read)


def select_readable_threads(reader: UUID) -> Select[UUID]:
    """Return the query of the threads on a reader's work, and on attempts that a partner sent for them too."""
    own = select(Thread.id).where(Thread.account_id == reader)
    partners = and_(Thread.account_id == OTHER.account_id, Thread.exercise == AssignedExercise.exercise)
    pairs = select_shared_work(Thread.work_at, Thread.id).join(Thread, partners)
    shared = pairs.where(MINE.account_id == reader, Thread.submission_id.is_not(None))
    return select(own.union(shared).subquery().c.id)


def load_unread_threads(db: Session, reader: UUID) -> Sequence[UnreadThread]:
    """Load the threads that a reader has not read, newest first, each with its last message."""
    last = (
        select(Message.text)
        .where(Message.thread_id == Thread.id)
        .order_by(Message.created_at.desc(), Message.id.desc())
        .limit(1)
        .scalar_subquery()
    )
    query = select(Thread, last).where(Thread.id.in_(select_readable_threads(reader)), unread_clause(reader))
    rows = db.execute(query.order_by(Thread.changed_at.desc(), Thread.id).limit(MAX_UNREAD_THREADS))
    return [UnreadThread(thread, text or "", thread.account_id != reader) for thread, text in rows]


def filter_unread(db: Session, reader: UUID, threads: Collection[UUID]) -> frozenset[UUID]:
    """Return which of these threads a reader has not read."""
    query = select(Thread.id).where(Thread.id.in_(threads), unread_clause(reader))
    return frozenset(db.execute(query).scalars())


def load_read_times(db: Session, reader: UUID) -> Mapping[UUID, datetime]:
    """Load when an account last looked at each thread on its own work."""
    query = select(ThreadReader.thread_id, ThreadReader.seen_at).where(ThreadReader.account_id == reader)
    own = query.join(Thread, Thread.id == ThreadReader.thread_id).where(Thread.account_id == reader)
    return dict(db.execute(own).all())


def load_readings_of_others_threads(db: Session, reader: UUID) -> Sequence[tuple[str, datetime]]:
    """Load the exercise and the time of each thread on the work of others that an account has read."""
    query = select(Thread.exercise, ThreadReader.seen_at).join(ThreadReader, ThreadReader.thread_id == Thread.id)
    query = query.where(ThreadReader.account_id == reader, Thread.account_id != reader)
    return [(name, at) for name, at in db.execute(query.order_by(ThreadReader.seen_at, Thread.id))]


def mark_threads_seen(db: Session, reader: UUID, threads: Collection[UUID], now: datetime) -> None:
    """Record that a reader has looked at these threads."""
    if not threads:
        return
    rows = [{"thread_id": thread, "account_id": reader, "seen_at": now} for thread in threads]
    statement = upsert_statement(db, ThreadReader).values(rows)
    db.execute(statement.on_conflict_do_update(index_elements=["thread_id", "account_id"], set_={"seen_at": now}))


def move_thread_readings(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's readings to an account, which keeps its own of a thread that both have read."""
    own = select(ThreadReader.thread_id).where(ThreadReader.account_id == account_id)
    moved = update(ThreadReader).where(ThreadReader.account_id == guest_id, ThreadReader.thread_id.not_in(own))
    db.execute(moved.values(account_id=account_id).execution_options(synchronize_session=False))
    left = delete(ThreadReader).where(ThreadReader.account_id == guest_id)
    db.execute(left.execution_options(synchronize_session=False))
