"""Tables of what teachers decide about marks: overrides, states, the rules of a class, columns of their own."""

from datetime import date, datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, Index, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

REASON_LENGTH = 1000
COLUMN_TITLE_LENGTH = 100
COMMENT_LENGTH = 500


class Override(Base):
    """A student's mark at an exercise, set by a teacher of the class: points out of 20, or excused.

    With `assignment_id` it holds in that assignment alone, without in all that ask the exercise; in an assignment, the
    former takes precedence. `based_on`: the ids of the gradings that made the automatic marks when this was set, null
    for none; once another one counts, the override is stale. The ids are only compared. Withdrawn or replaced, the row
    stays.
    """

    __tablename__ = "mark_override"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"))
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    exercise: Mapped[str] = mapped_column(String(200))
    assignment_id: Mapped[UUID | None] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), index=True)
    points: Mapped[float | None]
    excused: Mapped[bool] = mapped_column(default=False)
    reason: Mapped[str] = mapped_column(Text)
    based_on: Mapped[list[str | None]] = mapped_column(JSON)
    by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    withdrawn_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


_EVERYWHERE = Override.withdrawn_at.is_(None) & Override.assignment_id.is_(None)
_IN_ASSIGNMENT = Override.withdrawn_at.is_(None) & Override.assignment_id.is_not(None)
Index(
    "uq_mark_override_active",
    Override.class_id,
    Override.account_id,
    Override.exercise,
    unique=True,
    sqlite_where=_EVERYWHERE,
    postgresql_where=_EVERYWHERE,
)
Index(
    "uq_mark_override_active_assignment",
    Override.assignment_id,
    Override.account_id,
    Override.exercise,
    unique=True,
    sqlite_where=_IN_ASSIGNMENT,
    postgresql_where=_IN_ASSIGNMENT,
)


class StateDecision(Base):
    """A teacher's decision about a whole assignment of a student: absent, excused, or zero (`states.DecidedState`).

    It takes precedence over what was sent and over overrides. Withdrawn or replaced, the row stays.
    """

    __tablename__ = "mark_decision"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"))
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    state: Mapped[str] = mapped_column(String(16))
    reason: Mapped[str] = mapped_column(Text, default="")
    by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    withdrawn_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


Index(
    "uq_mark_decision_active",
    StateDecision.assignment_id,
    StateDecision.account_id,
    unique=True,
    sqlite_where=StateDecision.withdrawn_at.is_(None),
    postgresql_where=StateDecision.withdrawn_at.is_(None),
)


class MarkingPolicy(Base):
    """How a class counts in its means what has no points (`states.MarkingRules`); without a row, by the defaults.

    `chosen_at` is None where no teacher has chosen yet: such a row holds the rules of before for an older class.
    `version` grows with each change.
    """

    __tablename__ = "marking_policy"

    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), primary_key=True)
    not_handed_in: Mapped[str] = mapped_column(String(8))
    late_refused: Mapped[str] = mapped_column(String(8))
    absent: Mapped[str] = mapped_column(String(8))
    unanswered: Mapped[str] = mapped_column(String(8))
    chosen_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    version: Mapped[int] = mapped_column(default=1)


class ManualColumn(Base):
    """A column of marks that teachers type: an oral, a paper test, participation.

    Points go from 0 to `out_of`. `bonus`: the points are added to the mean as they are. Students see the column from
    `published_at` on. A deleted column can be restored. `version` grows with each change of the column itself.
    """

    __tablename__ = "manual_column"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), index=True)
    title: Mapped[str] = mapped_column(String(COLUMN_TITLE_LENGTH))
    out_of: Mapped[float] = mapped_column(default=20.0)
    taken_on: Mapped[date | None]
    weight: Mapped[float] = mapped_column(default=1.0)
    bonus: Mapped[bool] = mapped_column(default=False)
    position: Mapped[int]
    published_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    deleted_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    version: Mapped[int] = mapped_column(default=1)


class ManualMark(Base):
    """A student's mark in a manual column: points out of its `out_of`, or a state (`states.TypedState`), or neither.

    `version` grows with each change; a mark that was never typed has version 0.
    """

    __tablename__ = "manual_mark"

    column_id: Mapped[UUID] = mapped_column(ForeignKey("manual_column.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    points: Mapped[float | None]
    state: Mapped[str | None] = mapped_column(String(16))
    comment: Mapped[str] = mapped_column(Text, default="")
    by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    version: Mapped[int] = mapped_column(default=1)


class Rubric(Base):
    """The criteria by which copies of an assignment are marked by hand: those of a manual column.

    `items` are those of `rubric_items.RubricItem`, in order. Until the column is published, copies are shown without
    names where it is `anonymous`. `version` grows with each change.
    """

    __tablename__ = "rubric"

    column_id: Mapped[UUID] = mapped_column(ForeignKey("manual_column.id", ondelete="CASCADE"), primary_key=True)
    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), index=True)
    items: Mapped[list[dict[str, Any]]] = mapped_column(JSON)
    anonymous: Mapped[bool] = mapped_column(default=False)
    version: Mapped[int] = mapped_column(default=1)


class RubricMarking(Base):
    """A copy that is being marked by a rubric: points and remarks by item (`rubric_items.RubricScores`).

    Without `finished_at` it is a draft. Its sum becomes a mark of the column when that is published.
    """

    __tablename__ = "rubric_marking"

    column_id: Mapped[UUID] = mapped_column(ForeignKey("rubric.column_id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    points: Mapped[dict[str, float]] = mapped_column(JSON, default=dict)
    remarks: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    finished_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    version: Mapped[int] = mapped_column(default=1)
