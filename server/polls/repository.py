"""Queries on answers to the questions of the lessons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from sqlalchemy import func, select, update
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, Status
from server.database import table_of, upsert_statement, utc_now
from server.polls.models import PollAnswer
from server.polls.schemas import AnswerCount


def save_latest_answer(db: Session, account_id: UUID, poll: str, answer: str) -> None:
    """Insert the first answer, or update the last one and the number of tries."""
    now = utc_now()
    row = {"answer": answer, "last": answer, "tries": 1, "answered_at": now, "last_at": now}
    again = {"last": answer, "tries": table_of(PollAnswer).c.tries + 1, "last_at": now}
    statement = upsert_statement(db, PollAnswer).values(account_id=account_id, poll=poll, **row)
    db.execute(statement.on_conflict_do_update(index_elements=["account_id", "poll"], set_=again))


def save_first_answer(db: Session, account_id: UUID, poll: str, answer: str) -> None:
    """Keeps an answer, unless there is one already: of two requests at once, the first one's stays."""
    now = utc_now()
    row = {"answer": answer, "last": answer, "tries": 1, "answered_at": now, "last_at": now}
    statement = upsert_statement(db, PollAnswer).values(account_id=account_id, poll=poll, **row)
    db.execute(statement.on_conflict_do_nothing())


def load_poll_answers(db: Session, account_id: UUID) -> Sequence[PollAnswer]:
    query = select(PollAnswer).where(PollAnswer.account_id == account_id).order_by(PollAnswer.poll)
    return db.execute(query).scalars().all()


def load_first_answers(db: Session, account_id: UUID, polls: Sequence[str]) -> Mapping[str, str]:
    """Return the account's first answer to each of these polls."""
    query = select(PollAnswer.poll, PollAnswer.answer)
    query = query.where(PollAnswer.account_id == account_id, PollAnswer.poll.in_(polls))
    return dict(db.execute(query).all())


def load_answer_counts(db: Session, class_id: UUID, polls: Sequence[str]) -> Sequence[AnswerCount]:
    """Count the first and last answers of a class's active students, in one query."""
    columns = (PollAnswer.poll, PollAnswer.answer, PollAnswer.last)
    query = select(*columns, func.count()).join(Membership, Membership.account_id == PollAnswer.account_id)
    query = query.where(
        Membership.class_id == class_id,
        Membership.role == ClassRole.student,
        Membership.status == Status.active,
        PollAnswer.poll.in_(polls),
    )
    return [AnswerCount._make(row) for row in db.execute(query.group_by(*columns).order_by(*columns))]


def count_active_students(db: Session, class_id: UUID) -> int:
    """Return the number of active students of a class."""
    active = (Membership.role == ClassRole.student, Membership.status == Status.active)
    query = select(func.count()).select_from(Membership).where(Membership.class_id == class_id, *active)
    return db.execute(query).scalar_one()


def move_poll_answers(db: Session, old: UUID, new: UUID) -> None:
    """Moves the answers to polls that `new` has not answered."""
    answered = select(PollAnswer.poll).where(PollAnswer.account_id == new)
    moved = update(PollAnswer).where(PollAnswer.account_id == old, PollAnswer.poll.not_in(answered))
    db.execute(moved.values(account_id=new).execution_options(synchronize_session=False))
