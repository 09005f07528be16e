"""A submission, from its storing to its verdict; what was drawn for whom; the solutions that a teacher has opened."""

from datetime import datetime
from enum import StrEnum
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, BigInteger, ForeignKey, Index, LargeBinary, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

#: The outcome of a failure of ours, which never counts.
INTERNAL_ERROR = "internal_error"


class State(StrEnum):
    queued = "queued"
    running = "running"
    done = "done"


class Submission(Base):
    """One file sent by one account. While `running` it is leased: only the lease's holder may write the verdict."""

    __tablename__ = "submission"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    exercise: Mapped[str] = mapped_column(String(200))
    source: Mapped[bytes] = mapped_column(LargeBinary)
    digest: Mapped[str] = mapped_column(String(64))
    seed: Mapped[int] = mapped_column(BigInteger)
    state: Mapped[str] = mapped_column(String(16), default=State.queued)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    started_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    finished_at: Mapped[datetime | None] = mapped_column(UtcDateTime)

    attempts: Mapped[int] = mapped_column(default=0)
    lease_owner: Mapped[str | None] = mapped_column(String(300))
    lease_token: Mapped[UUID | None]
    lease_until: Mapped[datetime | None] = mapped_column(UtcDateTime)

    outcome: Mapped[str | None] = mapped_column(String(32))
    score: Mapped[float | None]
    verdict: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    figures: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), deferred=True)

    __table_args__ = (
        Index("ix_submission_queue", "state", "created_at", "id"),
        Index("ix_submission_attempts", "account_id", "exercise", "created_at"),
    )

    @property
    def code(self) -> str:
        """The file as text, for showing it."""
        return self.source.decode("utf-8-sig", errors="replace")


class Draw(Base):
    """The seed of what one account was given in an exercise answered without code: it does not change."""

    __tablename__ = "draw"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    seed: Mapped[int] = mapped_column(BigInteger)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class SolutionOpening(Base):
    """A teacher's decision: everyone may read the solution of this exercise."""

    __tablename__ = "solution_opening"

    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    opened_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    opened_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
