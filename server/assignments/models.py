"""Assignments, their exemptions, and the sittings of tests."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any, NamedTuple
from uuid import UUID, uuid4

from sqlalchemy import CheckConstraint, Dialect, ForeignKey, Index, LargeBinary, String, Text, false
from sqlalchemy.orm import Mapped, mapped_column
from sqlalchemy.types import TypeDecorator

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


@dataclass(frozen=True)
class PastRules:
    """The rules on time that an assignment had until it was changed."""

    until: datetime
    opens_at: datetime
    due_at: datetime | None
    closes_at: datetime | None
    late: str
    late_per_day: float | None
    duration_minutes: int | None


class PastRulesColumn(TypeDecorator[Sequence[PastRules]]):
    """Past rules, oldest first, as JSON text with ISO dates."""

    impl = Text
    cache_ok = True

    def process_bind_param(self, value: Sequence[PastRules] | None, dialect: Dialect) -> str:
        return json.dumps([asdict(past) for past in value or ()], default=datetime.isoformat)

    def process_result_value(self, value: Any | None, dialect: Dialect) -> tuple[PastRules, ...]:
        return () if not value or value == "[]" else tuple(_read_past_rules(row) for row in json.loads(value))


def _read_past_rules(row: dict[str, Any]) -> PastRules:
    dates = ("until", "opens_at", "due_at", "closes_at")
    return PastRules(**row | {name: row[name] and datetime.fromisoformat(row[name]) for name in dates})


class LabelsColumn(TypeDecorator[Sequence[str]]):
    """Labels of groups, in order, as JSON text."""

    impl = Text
    cache_ok = True

    def process_bind_param(self, value: Sequence[str] | None, dialect: Dialect) -> str:
        return json.dumps(list(value or ()), ensure_ascii=False)

    def process_result_value(self, value: Any | None, dialect: Dialect) -> tuple[str, ...]:
        return () if not value or value == "[]" else tuple(json.loads(value))


class Assignment(Base):
    """Exercises set for a class. Without `due_at` nothing is late; without `closes_at` it stays open.

    `late_per_day`: points out of 20 that each day begun costs, with `LatePolicy.penalty` alone. `duration_minutes`: the
    time of a test, from when a student begins it. `released_at`: from when the feedback of a test is shown.
    `removed_at`: when it was deleted; it can be restored for a while, and counts nowhere meanwhile. Attempts
    that arrived under `past_rules` keep what they were told. `groups`: the labels of the students whom it concerns;
    empty for the whole class. `team_size`: how many students may hand in together, 1 for each alone, in teams that they
    form themselves too with `teams_by_students`.
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
    removed_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    groups: Mapped[Sequence[str]] = mapped_column(LabelsColumn, default=(), server_default="[]")
    team_size: Mapped[int] = mapped_column(default=1, server_default="1")
    teams_by_students: Mapped[bool] = mapped_column(default=False, server_default=false())
    past_rules: Mapped[Sequence[PastRules]] = mapped_column(PastRulesColumn, default=(), server_default="[]")


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
    readable. `extends`: its dates were not earlier than those of the others as it was made, so that they never leave
    less; otherwise its teacher chose earlier ones, which hold.
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
    extends: Mapped[bool] = mapped_column(default=False, server_default=false())
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


class TeamMember(Base):
    """A student's place in a team of an assignment, whose members hand in together.

    Attempts that a member sends from `since` until `until` (None: still) count for those who are in the team then. A
    place that ends stays, so that what was sent goes on counting.
    """

    __tablename__ = "team_member"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), index=True)
    team_id: Mapped[UUID]
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    since: Mapped[datetime] = mapped_column(UtcDateTime)
    until: Mapped[datetime | None] = mapped_column(UtcDateTime)


Index(
    "uq_team_member_current",
    TeamMember.assignment_id,
    TeamMember.account_id,
    unique=True,
    sqlite_where=TeamMember.until.is_(None),
    postgresql_where=TeamMember.until.is_(None),
)


class TeamProposal(Base):
    """A student's proposal to another to hand in an assignment together, until it is accepted or taken back."""

    __tablename__ = "team_proposal"

    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    partner_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    proposed_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
