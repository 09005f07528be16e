"""A regrade of an exercise, and the attempts that it grades anew."""

from datetime import datetime
from enum import StrEnum
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class RegradePolicy(StrEnum):
    """Which of an attempt's two gradings is to count: the better one, or the new one."""

    keep_best = "keep_best"
    renew = "replace"


class RegradeScope(StrEnum):
    """Whose attempts: those of the whole class, those that may count in an assignment, those of one student."""

    school_class = "class"
    assignment = "assignment"
    student = "student"


class Regrade(Base):
    """Nothing of it counts until it is applied. `stopped_at`: its teacher gave it up before its end.

    It is applied when `applied_at` is there and `undone_at` is not. Of an assignment or a student that is no more, the
    scope alone is left.
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
    """An attempt to be graded anew. `before_id` is the grading that counted, `after_id` the new one once it is there.

    `position` is its place among those of the regrade; `counting`: it was its author's best or last attempt. `why` is
    what differs between the two verdicts (`server.regrades.differences.Reason`). `moved`: the new grading counts.
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


_WAITS = RegradeItem.after_id.is_(None)
Index(
    "ix_regrade_item_waiting",
    RegradeItem.regrade_id,
    RegradeItem.position,
    sqlite_where=_WAITS,
    postgresql_where=_WAITS,
)
