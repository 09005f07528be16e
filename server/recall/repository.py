"""Queries on the answers to what comes back, and on readers' choices."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from server.database import upsert_statement
from server.recall.models import ReaderChoice, RecallAnswer

MAX_ANSWERS, MAX_CLASS_ANSWERS = 3000, 30_000


def load_recall_answers(db: Session, account_id: UUID) -> Sequence[RecallAnswer]:
    """Load an account's latest answers, the oldest first."""
    query = select(RecallAnswer).where(RecallAnswer.account_id == account_id)
    latest = query.order_by(RecallAnswer.answered_at.desc(), RecallAnswer.id).limit(MAX_ANSWERS)
    return tuple(reversed(db.execute(latest).scalars().all()))


def load_recall_answers_of_accounts(db: Session, accounts: Collection[UUID]) -> Sequence[RecallAnswer]:
    """Load the latest answers of several accounts, the oldest first."""
    query = select(RecallAnswer).where(RecallAnswer.account_id.in_(accounts))
    latest = query.order_by(RecallAnswer.answered_at.desc(), RecallAnswer.id).limit(MAX_CLASS_ANSWERS)
    return tuple(reversed(db.execute(latest).scalars().all()))


def find_latest_answer_time(db: Session, account_id: UUID, subject: str) -> datetime | None:
    """Return when an account last answered about a subject."""
    query = select(func.max(RecallAnswer.answered_at)).where(
        RecallAnswer.account_id == account_id, RecallAnswer.subject == subject
    )
    return db.execute(query).scalar_one()


def add_answer(db: Session, answer: RecallAnswer) -> None:
    db.add(answer)


def load_choices(db: Session, account_id: UUID) -> Mapping[str, str]:
    """Load an account's choices by name."""
    query = select(ReaderChoice).where(ReaderChoice.account_id == account_id).order_by(ReaderChoice.name)
    return {choice.name: choice.value for choice in db.execute(query).scalars()}


def save_choice(db: Session, account_id: UUID, name: str, value: str) -> None:
    """Store a choice; an empty value takes it back."""
    if not value:
        db.execute(delete(ReaderChoice).where(ReaderChoice.account_id == account_id, ReaderChoice.name == name))
        return
    statement = upsert_statement(db, ReaderChoice).values(account_id=account_id, name=name, value=value)
    db.execute(statement.on_conflict_do_update(index_elements=["account_id", "name"], set_={"value": value}))


def move_answers_and_choices(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Give an account the answers of a guest, and the choices that it has not made itself."""
    db.execute(update(RecallAnswer).where(RecallAnswer.account_id == guest_id).values(account_id=account_id))
    own = select(ReaderChoice.name).where(ReaderChoice.account_id == account_id)
    moved = update(ReaderChoice).where(ReaderChoice.account_id == guest_id, ReaderChoice.name.not_in(own))
    db.execute(moved.values(account_id=account_id).execution_options(synchronize_session=False))
