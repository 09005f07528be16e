"""ORM model of the questions with which a class begins a lesson."""

from __future__ import annotations

from datetime import date, datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, Date, ForeignKey, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class WarmUp(Base):
    """The questions of a class on one day, as `WarmUpQuestion.to_data` writes them: a course that changes, or a
    schedule that moves with the answers, changes none of them. They name no student."""

    __tablename__ = "warm_up"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"))
    day: Mapped[date] = mapped_column(Date)
    questions: Mapped[list[dict[str, Any]]] = mapped_column(JSON)
    prepared_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)

    __table_args__ = (UniqueConstraint("class_id", "day"),)
