"""The table of marks that teachers set in place of automatic ones."""

from datetime import datetime
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, Index, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

REASON_LENGTH = 1000


class Override(Base):
    """A student's mark at an exercise, set by a teacher of the class: points out of 20, or excused.

    `based_on`: the ids of the gradings that made the automatic marks when this was set, null for none; once another one
    counts, the override is stale. The ids are only compared. Withdrawn or replaced, the row stays.
    """

    __tablename__ = "mark_override"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"))
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    exercise: Mapped[str] = mapped_column(String(200))
    points: Mapped[float | None]
    excused: Mapped[bool] = mapped_column(default=False)
    reason: Mapped[str] = mapped_column(Text)
    based_on: Mapped[list[str | None]] = mapped_column(JSON)
    by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    withdrawn_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


Index(
    "uq_mark_override_active",
    Override.class_id,
    Override.account_id,
    Override.exercise,
    unique=True,
    sqlite_where=Override.withdrawn_at.is_(None),
    postgresql_where=Override.withdrawn_at.is_(None),
)
