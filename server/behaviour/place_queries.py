"""Queries on the places of mistakes that were found after a verdict."""

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from server.behaviour.models import Fingerprint


def load_mistake_places(db: Session, grading_id: UUID) -> tuple[bool, dict[str, Any] | None]:
    """Return whether a grading's program has been observed, and the JSON of the places of its mistakes, if found."""
    row = db.execute(select(Fingerprint.place).where(Fingerprint.grading_id == grading_id)).one_or_none()
    return (False, None) if row is None else (True, row[0])


def count_mending_changes(db: Session, group_id: str) -> Sequence[tuple[str, int]]:
    """Return the kinds of changes that mend programs of a group, each with how many, the most frequent first."""
    query = (
        select(Fingerprint.changes, func.count())
        .where(Fingerprint.group_id == group_id, Fingerprint.changes.is_not(None))
        .group_by(Fingerprint.changes)
        .order_by(func.count().desc(), Fingerprint.changes)
    )
    return [(str(row[0]), row[1]) for row in db.execute(query)]
