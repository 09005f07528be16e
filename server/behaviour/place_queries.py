"""Queries on the places of mistakes that were found after a verdict."""

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from server.behaviour.models import Fingerprint


def has_fingerprint(db: Session, grading_id: UUID) -> bool:
    """Whether a grading's program has been observed."""
    return db.execute(select(Fingerprint.grading_id).where(Fingerprint.grading_id == grading_id)).first() is not None


def load_place(db: Session, grading_id: UUID) -> dict[str, Any] | None:
    """Load the diagnosis of the places of a program's mistakes, as JSON, if any were found."""
    return db.execute(select(Fingerprint.place).where(Fingerprint.grading_id == grading_id)).scalar_one_or_none()


def list_changes(db: Session, group_id: str) -> Sequence[tuple[str, int]]:
    """Return the kinds of changes that mend programs of a group, each with how many, the most frequent first."""
    query = (
        select(Fingerprint.changes, func.count())
        .where(Fingerprint.group_id == group_id, Fingerprint.changes.is_not(None))
        .group_by(Fingerprint.changes)
        .order_by(func.count().desc(), Fingerprint.changes)
    )
    return [(str(row[0]), row[1]) for row in db.execute(query)]
