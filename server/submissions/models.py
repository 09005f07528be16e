"""Submissions, and the seeds of variants."""

from datetime import datetime
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import BigInteger, ForeignKey, Index, LargeBinary, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class SubmissionState(StrEnum):
    queued = "queued"
    running = "running"
    done = "done"


class Submission(Base):
    """One file or set of answers of one account. `grading_id` is the grading that counts; None before the first.

    Database triggers set `revision` to a random number whenever anything read of a graded attempt changes: equal
    revisions mean equal attempts.
    """

    __tablename__ = "submission"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"))
    exercise: Mapped[str] = mapped_column(String(200))
    source: Mapped[bytes] = mapped_column(LargeBinary)
    digest: Mapped[str] = mapped_column(String(64))
    seed: Mapped[int] = mapped_column(BigInteger)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    grading_id: Mapped[UUID | None] = mapped_column(
        ForeignKey("grading.id", name="fk_submission_grading_id_grading", use_alter=True),
        index=True,  # deleting a grading looks up the submissions that count it
    )
    revision: Mapped[int | None] = mapped_column(BigInteger)

    __table_args__ = (Index("ix_submission_attempts", "account_id", "exercise", "created_at"),)

    @property
    def code(self) -> str:
        """The file as text, for showing it."""
        return self.source.decode("utf-8-sig", errors="replace")


Index(
    "ix_submission_waiting",
    Submission.account_id,
    Submission.exercise,
    sqlite_where=Submission.grading_id.is_(None),
    postgresql_where=Submission.grading_id.is_(None),
)
Index(
    "ix_submission_revisions",
    Submission.account_id,
    Submission.revision,
    sqlite_where=Submission.revision.is_not(None),
    postgresql_where=Submission.revision.is_not(None),
)


class Variant(Base):
    """The seed of an account's random data in an exercise answered without code; it never changes."""

    __tablename__ = "deal"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    exercise: Mapped[str] = mapped_column(String(200), primary_key=True)
    seed: Mapped[int] = mapped_column(BigInteger)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
