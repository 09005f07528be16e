"""What a student's attempts come to in their assignments: the one place where the desk asks for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.counting import Result, result
from server.assignments.mine import Mine
from server.assignments.models import Counts
from server.desk import repository
from server.marks import repository as marks
from server.marks.schemas import Set

Results = Mapping[tuple[UUID, str], Result]


def set_by_hand(db: Session, class_id: UUID, account_id: UUID, found: Sequence[Mine]) -> Mapping[str, Set]:
    """The marks that a teacher has set, by exercise, which go before the automatic ones; one query."""
    exercises = {row.exercise for one in found for row in one.exercises}
    kept = marks.active(db, class_id, [account_id], exercises) if exercises else {}
    return {exercise: one for (_, exercise), one in kept.items()}


def of_student(db: Session, account_id: UUID, found: Sequence[Mine]) -> Results:
    """By assignment and exercise, the attempt that counts; one query."""
    exercises = {row.exercise for one in found for row in one.exercises}
    attempts = repository.sent(db, account_id, exercises) if exercises else {}
    return {
        (one.assignment.id, row.exercise): result(
            one.rules, Counts(one.assignment.counts), attempts.get(row.exercise, ())
        )
        for one in found
        for row in one.exercises
    }
