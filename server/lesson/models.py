"""Lessons of classes, and the students whom a teacher has seen in them."""

from __future__ import annotations

from datetime import datetime, timedelta
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

#: A lesson that nobody ended is over after that time.
LONGEST_LESSON = timedelta(hours=4)


class Afterwards(StrEnum):
    """What a student gets who has finished the exercises of the day."""

    none = "none"
    help = "help"
    challenge = "challenge"


class LiveLesson(Base):
    """A lesson of a class, with the ids of the exercises of the day in order. It goes on until `ended_at`.

    `challenge` is the exercise for who has finished, where `next_step` says so.
    """

    __tablename__ = "live_lesson"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"))
    exercises: Mapped[list[str]] = mapped_column(JSON)
    next_step: Mapped[str] = mapped_column(String(16), default=Afterwards.none)
    challenge: Mapped[str | None] = mapped_column(String(200))
    started_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    ended_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    started_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)

    __table_args__ = (Index("ix_live_lesson_class_id_started_at", "class_id", "started_at"),)


class LessonVisit(Base):
    """The last time that a teacher marked a student as seen in a lesson, at which exercise, and who did."""

    __tablename__ = "lesson_visit"

    lesson_id: Mapped[UUID] = mapped_column(ForeignKey("live_lesson.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    exercise: Mapped[str] = mapped_column(String(200))
    visited_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    visited_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
