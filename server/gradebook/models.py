"""Tables of gradings, of standings computed from them, and of open solutions."""

from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, BigInteger, ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class Grading(Base):
    """One grading of one submission, never changed afterwards. `score` is None for an internal error.

    The columns repeat the parts of the verdict that lists and sums need. `films`: recordings of the program by check;
    `filmed`: the checks that have one; None where there are none. `balise_version`: the version that graded; None
    before 1.0.0. `diagnosis`: the mistake that boards count, none where others resemble it.
    """

    __tablename__ = "grading"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    submission_id: Mapped[UUID] = mapped_column(ForeignKey("submission.id", ondelete="CASCADE"), index=True)
    exercise_version: Mapped[str] = mapped_column(String(64))
    balise_version: Mapped[str | None] = mapped_column(String(32))
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


class EarlyVerdict(Base):
    """The verdict of a submission without its diagnosis, from the end of its checks until it is graded."""

    __tablename__ = "early_verdict"

    submission_id: Mapped[UUID] = mapped_column(ForeignKey("submission.id", ondelete="CASCADE"), primary_key=True)
    verdict: Mapped[dict[str, Any]] = mapped_column(JSON)


class Standing(Base):
    """Totals of one account's counting gradings in one exercise, internal errors left out.

    `last_…` belong to the attempt that was sent last, and times are those of sending, so that the order of grading does
    not matter. It can be rebuilt from the gradings (`gradebook.service.rebuild_account_standings`).
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
    """An administrator has opened the solution of this exercise to everyone."""

    __tablename__ = "solution_opening"

    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    opened_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    opened_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class ClassOpening(Base):
    """A teacher has opened the solution of this exercise to the members of a class."""

    __tablename__ = "class_opening"

    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    opened_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    opened_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
