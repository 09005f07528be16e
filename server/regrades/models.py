"""A regrade of an exercise, and the attempts that it regrades."""

from datetime import datetime
from enum import StrEnum
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class RegradePolicy(StrEnum):
    """Which of an attempt's two gradings counts: the better one, or the new one."""

    keep_best = "keep_best"
    renew = "replace"


class RegradeScope(StrEnum):
    """The attempts to regrade: of the whole class, those that may count in an assignment, or of one student."""

    school_class = "class"
    assignment = "assignment"
    student = "student"


class Regrade(Base):
    """A regrade, whose gradings count only while it is applied. `stopped_at`: its teacher cancelled it.

    It is applied while `applied_at` is set and `undone_at` is not. Once its assignment or student is deleted, `scope`
    alone remains.
    """

    __tablename__ = "regrade"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), index=True)
    exercise: Mapped[str] = mapped_column(String(200))
    policy: Mapped[str] = mapped_column(String(16))
    scope: Mapped[str] = mapped_column(String(16), default=RegradeScope.school_class)
    assignment_id: Mapped[UUID | None] = mapped_column(ForeignKey("assignment.id", ondelete="SET NULL"), index=True)
    student_id: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    stopped_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    applied_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    undone_at: Mapped[datetime | None] = mapped_column(UtcDateTime)

    @property
    def is_applied(self) -> bool:
        return self.applied_at is not None and self.undone_at is None


class RegradeItem(Base):
    """An attempt to regrade. `before_id` is the grading that counted, `after_id` the new one once it exists.

    `position` orders the items of a regrade; `counted`: the best or last attempt of its author. `differences` of the
    two verdicts are `VerdictDifference` as JSON. `is_applied`: the new grading counts.
    """

    __tablename__ = "regrade_item"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    regrade_id: Mapped[UUID] = mapped_column(ForeignKey("regrade.id", ondelete="CASCADE"))
    position: Mapped[int]
    counted: Mapped[bool] = mapped_column("counting", key="counted")
    submission_id: Mapped[UUID] = mapped_column(ForeignKey("submission.id", ondelete="CASCADE"), index=True)
    before_id: Mapped[UUID] = mapped_column(ForeignKey("grading.id", ondelete="CASCADE"), index=True)
    after_id: Mapped[UUID | None] = mapped_column(ForeignKey("grading.id", ondelete="CASCADE"), index=True)
    differences: Mapped[list[dict[str, Any]]] = mapped_column("why", JSON, key="differences", default=list)
    is_applied: Mapped[bool] = mapped_column("moved", key="is_applied", default=False)

    __table_args__ = (Index("ix_regrade_item_regrade_id", "regrade_id"),)


_IS_WAITING = RegradeItem.after_id.is_(None)
Index(
    "ix_regrade_item_waiting",
    RegradeItem.regrade_id,
    RegradeItem.position,
    sqlite_where=_IS_WAITING,
    postgresql_where=_IS_WAITING,
)
