"""Exercises that teachers write, and their published versions."""

from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

MODULE_LENGTH, SLUG_LENGTH, DIGEST_LENGTH, CODE_LENGTH = 40, 60, 64, 12


class AuthoredExercise(Base):
    """A teacher's exercise. `draft` is what the form holds, `digest` its digest, `trial` the last trial's outcome.

    `wants_publication`: the next trial publishes the draft if it may. `slug` is set once, at the first request to
    publish, and `number` counts the published versions. `for_classes`: the students of the author's classes find it in
    the list of their module. `tryout`: the program that the author tried as a student, and its verdict. Without an
    author, it stays as long as it is published.
    """

    __tablename__ = "authored_exercise"
    __table_args__ = (UniqueConstraint("module", "slug"),)

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    author_id: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    module: Mapped[str] = mapped_column(String(MODULE_LENGTH))
    slug: Mapped[str | None] = mapped_column(String(SLUG_LENGTH))
    draft: Mapped[dict[str, Any]] = mapped_column(JSON)
    digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH))
    trial: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    wants_publication: Mapped[bool] = mapped_column(default=False)
    number: Mapped[int] = mapped_column(default=0)
    share_code: Mapped[str | None] = mapped_column(String(CODE_LENGTH), unique=True)
    in_bank: Mapped[bool] = mapped_column(default=False)
    for_classes: Mapped[bool] = mapped_column(default=False)
    tryout: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    saved_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)

    @property
    def name(self) -> str:
        """The id of its exercise, "l20/compter_mots_k3f9ab"; empty before it is published."""
        return f"{self.module}/{self.slug}" if self.slug and self.number else ""


class ExerciseVersion(Base):
    """A published version: all that its page shows and its grader needs. It never changes.

    `version` is a digest of what can change a verdict; `fingerprints` are the answers of the known mistakes to the
    probes, by mistake.
    """

    __tablename__ = "exercise_version"

    exercise_id: Mapped[UUID] = mapped_column(ForeignKey("authored_exercise.id", ondelete="CASCADE"), primary_key=True)
    number: Mapped[int] = mapped_column(primary_key=True)
    version: Mapped[str] = mapped_column(String(DIGEST_LENGTH))
    content: Mapped[dict[str, Any]] = mapped_column(JSON)
    fingerprints: Mapped[dict[str, list[str]]] = mapped_column(JSON)
    published_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
