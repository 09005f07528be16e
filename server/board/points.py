"""The points that are in force on the board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import MAX_POINTS
from server.board.repository import Scope
from server.board.trails import Pair
from server.gradebook.standings import Sums
from server.marks import repository as marks
from server.marks.schemas import InForce


def in_force(
    db: Session, scope: Scope, students: Sequence[UUID], standings: Mapping[Pair, Sums]
) -> Mapping[Pair, InForce]:
    """Of each student and exercise where there are any: what a teacher has set, else those of the best attempt."""
    found = {pair: InForce(round(MAX_POINTS * sums.best_score, 4)) for pair, sums in standings.items()}
    for pair, one in marks.active(db, scope.class_id, students, scope.exercises).items():
        found[pair] = InForce(found[pair].automatic if pair in found else None, one)
    return found
