"""ORM models of the answers to what comes back, and of what a reader chose."""

from datetime import datetime
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

SUBJECT_LENGTH, NAME_LENGTH, VALUE_LENGTH = 250, 100, 200


class QuestionKind(StrEnum):
    """A question about a misconception: an input that shows it, an answer of its program, its line, a calculation."""

    hunt = "hunt"
    prediction = "prediction"
    line = "line"
    calculation = "calculation"


class RecallAnswer(Base):
    """An account's answer to one question about a misconception. No mark comes of it.

    `subject` is the family of the misconception, or the misconception itself where it has none: what is scheduled.
    """

    __tablename__ = "recall_answer"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    subject: Mapped[str] = mapped_column(String(SUBJECT_LENGTH))
    kind: Mapped[str] = mapped_column(String(16))
    exercise: Mapped[str] = mapped_column(String(SUBJECT_LENGTH))
    misconception: Mapped[str] = mapped_column(String(NAME_LENGTH))
    is_right: Mapped[bool]
    answered_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)

    __table_args__ = (Index("ix_recall_answer_account_id_answered_at", "account_id", "answered_at"),)


class ReaderChoice(Base):
    """What a reader chose: the path through a module (`path:l20`), no reminder (`reminders`)."""

    __tablename__ = "reader_choice"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(String(NAME_LENGTH), primary_key=True)
    value: Mapped[str] = mapped_column(String(VALUE_LENGTH))
