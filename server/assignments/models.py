"""Assignments, their exemptions, and the sittings of tests."""

from datetime import datetime
from enum import StrEnum
from typing import NamedTuple
from uuid import UUID, uuid4

from sqlalchemy import CheckConstraint, ForeignKey, LargeBinary, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

TITLE_LENGTH = 200
GROUP_LENGTH = 40


class Mode(StrEnum):
    """In a `test`, feedback is shown only once the teacher releases it."""

    practice = "practice"
    test = "test"


class LatePolicy(StrEnum):
    """An attempt sent after the due date does not count; counts and is marked late; loses points for each day begun."""

    refuse = "refuse"
    accept = "accept"
    penalty = "penalty"


class AttemptSelection(StrEnum):
    """Which of a student's attempts at an exercise makes the mark."""

    best = "best"
    last = "last"
    best_before_due = "best_before_due"


class Visibility(StrEnum):
    """When a part of the feedback is shown; `usual`: as outside any assignment."""

    usual = "usual"
    after_due = "after_due"
    after_close = "after_close"
    never = "never"


class Assignment(Base):
    """Exercises set for a class. Without `due_at` nothing is late; without `closes_at` it stays open.

    `late_per_day`: points out of 20 that each day begun costs, with `LatePolicy.penalty` alone. `duration_minutes`: the
    time of a test, from when a student begins it. `released_at`: from when the feedback of a test is shown.
    """

    __tablename__ = "assignment"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), index=True)
    title: Mapped[str] = mapped_column(String(TITLE_LENGTH))
    mode: Mapped[str] = mapped_column(String(16), default=Mode.practice)
    opens_at: Mapped[datetime] = mapped_column(UtcDateTime)
    due_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    closes_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    late: Mapped[str] = mapped_column(String(16), default=LatePolicy.accept)
    late_per_day: Mapped[float | None]
    counts: Mapped[str] = mapped_column(String(16), default=AttemptSelection.best)
    weight: Mapped[float] = mapped_column(default=1.0)
    hints: Mapped[str] = mapped_column(String(16), default=Visibility.usual)
    diagnosis: Mapped[str] = mapped_column(String(16), default=Visibility.usual)
    solution: Mapped[str] = mapped_column(String(16), default=Visibility.usual)
    duration_minutes: Mapped[int | None]
    released_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class WeightedExercise(NamedTuple):
    """An exercise by its id, and its weight among the others of an assignment."""

    exercise: str
    weight: float = 1.0


class AssignedExercise(Base):
    """An exercise of an assignment, with its weight among the others."""

    __tablename__ = "assigned_exercise"

    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    position: Mapped[int]
    weight: Mapped[float] = mapped_column(default=1.0)


class Exemption(Base):
    """Changes to an assignment's rules for a student, or for all students with a label. None inherits.

    `time_factor` multiplies the duration of a test. The reason is for the staff alone. A revoked exemption stays
    readable.
    """

    __tablename__ = "exemption"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), index=True)
    account_id: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    label: Mapped[str | None] = mapped_column(String(GROUP_LENGTH))
    opens_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    due_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    closes_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    time_factor: Mapped[float | None]
    excused: Mapped[bool | None]
    reason: Mapped[str] = mapped_column(Text, default="")
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcDateTime)

    __table_args__ = (CheckConstraint("(account_id IS NULL) <> (label IS NULL)", name="one_of"),)


class EndedBy(StrEnum):
    """Who or what ended a sitting. A sitting ended by `time` resumes where more time is granted."""

    student = "student"
    time = "time"


class Sitting(Base):
    """A student's own time in a test. `handed_in_at` is when it ended: work saved by then has been submitted."""

    __tablename__ = "sitting"

    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    began_at: Mapped[datetime] = mapped_column(UtcDateTime)
    handed_in_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    ended_by: Mapped[str | None] = mapped_column(String(16))


class SavedWork(Base):
    """The last work that a student saved in a test, submitted or not: a file, or answers in their submitted form."""

    __tablename__ = "saved_work"

    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    source: Mapped[bytes] = mapped_column(LargeBinary)
    saved_at: Mapped[datetime] = mapped_column(UtcDateTime)
