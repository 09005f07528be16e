"""Tables of groups of programs with equal answers, their members, and the names that teachers give to them."""

from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import JSON, ForeignKey, Index, LargeBinary, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

GROUP_LENGTH = 16
TITLE_LENGTH = 200
EXPLANATION_LENGTH = 4000
QUESTION_LENGTH = 1000
CHANGES_LENGTH = 200


class BehaviourGroup(Base):
    """A group of programs with the same answers. `answers`: those of the first, as `graders.core.code.plain.packed`.

    Equal answers have the same `structure` and near projections; `functions` are those that answer wrongly, `example`
    is a `graders.core.code.behaviour.Example`.
    """

    __tablename__ = "behaviour_group"

    id: Mapped[str] = mapped_column(String(GROUP_LENGTH), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200))
    exercise_version: Mapped[str] = mapped_column(String(64))
    structure: Mapped[str] = mapped_column(String(64))
    projection: Mapped[float]
    answers: Mapped[bytes] = mapped_column(LargeBinary, deferred=True)
    functions: Mapped[list[str]] = mapped_column(JSON)
    example: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)

    __table_args__ = (Index("ix_behaviour_group_alike", "exercise", "exercise_version", "structure", "projection"),)


class Fingerprint(Base):
    """The group of a graded program; no group where nothing was observed, or it could not be.

    `place` is the diagnosis of where its mistakes are, as `graders.core.contract.verdict.Diagnosis` writes it, and
    `changes` the kinds of the changes that mend it; None where none was found.
    """

    __tablename__ = "fingerprint"

    grading_id: Mapped[UUID] = mapped_column(ForeignKey("grading.id", ondelete="CASCADE"), primary_key=True)
    group_id: Mapped[str | None] = mapped_column(ForeignKey("behaviour_group.id", ondelete="CASCADE"), index=True)
    made_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    place: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    changes: Mapped[str | None] = mapped_column(String(CHANGES_LENGTH))


class BehaviourName(Base):
    """A teacher's name and explanation of a group, shown to all of a class whose programs are in it. Plain text."""

    __tablename__ = "behaviour_name"

    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), primary_key=True)
    group_id: Mapped[str] = mapped_column(
        ForeignKey("behaviour_group.id", ondelete="CASCADE"), primary_key=True, index=True
    )
    title: Mapped[str] = mapped_column(String(TITLE_LENGTH))
    explanation: Mapped[str] = mapped_column(Text)
    question: Mapped[str] = mapped_column(Text)
    named_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    named_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
