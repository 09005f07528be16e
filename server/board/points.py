"""The points that are in force on the board."""

from __future__ import annotations

from collections.abc import Mapping
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import MAX_POINTS
from server.classes.models import SchoolClass
from server.gradebook.standings import Sums


def in_force(
    _db: Session, _school_class: SchoolClass, standings: Mapping[tuple[UUID, str], Sums]
) -> Mapping[tuple[UUID, str], float]:
    """Points out of 20 of each student and exercise: those of the best attempt."""
    return {pair: round(MAX_POINTS * sums.best_score, 4) for pair, sums in standings.items()}
