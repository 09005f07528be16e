"""What was found each time that a submission was graded, what it comes to, and the solutions that are open."""

from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, BigInteger, ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class Grading(Base):
    """One grading of one submission, never changed afterwards. `score` is None for an error of ours.

    The columns repeat what lists and sums ask of the verdict, so that they need not open it. `films` are what the
    program did, by check, and `filmed` these checks; None where there are none.
    """

    __tablename__ = "grading"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    submission_id: Mapped[UUID] = mapped_column(ForeignKey("submission.id", ondelete="CASCADE"), index=True)
    exercise_version: Mapped[str] = mapped_column(String(64))
    outcome: Mapped[str] = mapped_column(String(32))
    score: Mapped[float | None]
    diagnosis: Mapped[str | None] = mapped_column(String(200))
    seed: Mapped[int] = mapped_column(BigInteger)
    started_at: Mapped[datetime] = mapped_column(UtcDateTime)
    finished_at: Mapped[datetime] = mapped_column(UtcDateTime, index=True)
    checks_ms: Mapped[float | None]
    diagnosis_ms: Mapped[float | None]
    total_ms: Mapped[float | None]
    verdict: Mapped[dict[str, Any]] = mapped_column(JSON)
    figures: Mapped[dict[str, Any]] = mapped_column(JSON, deferred=True)
    filmed: Mapped[list[str] | None] = mapped_column(JSON(none_as_null=True))
    films: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), deferred=True)


class Standing(Base):
    """What one account's gradings in one exercise come to: those that count, and are not errors of ours.

    `last_…` are of the attempt that was sent last, and times are those of sending, so that it does not matter in which
    order attempts are graded. It can be made again from the gradings (`gradebook.service.recount`).
    """

    __tablename__ = "standing"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    best_score: Mapped[float]
    attempts: Mapped[int]
    last_outcome: Mapped[str] = mapped_column(String(32))
    last_diagnosis: Mapped[str | None] = mapped_column(String(200))
    first_success_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    last_at: Mapped[datetime] = mapped_column(UtcDateTime)


class SolutionOpening(Base):
    """An administrator's decision: everyone may read the solution of this exercise."""

    __tablename__ = "solution_opening"

    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    opened_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    opened_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class ClassOpening(Base):
    """A teacher's decision: the members of a class may read the solution of this exercise."""

    __tablename__ = "class_opening"

    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    opened_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    opened_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
