"""ORM model of answers to the questions of the lessons."""

from datetime import datetime
from uuid import UUID

from sqlalchemy import ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

POLL_LENGTH = 200
ANSWER_LENGTH = 200


class PollAnswer(Base):
    """An account's answer to one question: `answer` is the first, `last` the latest, after `tries` tries.

    `poll` is the module and the question's own name (`l20/rejeux/icp`); an answer is the id of an option, or several
    in their order, joined by commas. No mark comes of it.
    """

    __tablename__ = "poll_answer"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    poll: Mapped[str] = mapped_column(String(POLL_LENGTH), primary_key=True)
    answer: Mapped[str] = mapped_column(String(ANSWER_LENGTH))
    last: Mapped[str] = mapped_column(String(ANSWER_LENGTH))
    tries: Mapped[int]
    answered_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    last_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
