"""What a student's attempts come to in their assignments: the one place where the desk asks for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.counting import Result, Sent, result
from server.assignments.mine import Mine
from server.assignments.models import Counts
from server.database import utc_now
from server.desk import repository
from server.gradebook import service as gradebook
from server.marks import repository as marks
from server.marks.schemas import Set, held_back

Results = Mapping[tuple[UUID, str], Result]


def set_by_hand(db: Session, class_id: UUID, account_id: UUID, found: Sequence[Mine]) -> Mapping[str, Set]:
    """The marks that a teacher has set, by exercise, which go before the automatic ones; one query."""
    exercises = {row.exercise for one in found for row in one.exercises}
    kept = marks.active(db, class_id, [account_id], exercises) if exercises else {}
    return {exercise: one for (_, exercise), one in kept.items()}


def of_student(db: Session, account_id: UUID, found: Sequence[Mine]) -> Results:
    """By assignment and exercise, the attempt that counts, without what a test holds back; two queries.

    Of the test itself everything is here: whoever tells of it says no more than how many there are.
    """
    exercises = {row.exercise for one in found for row in one.exercises}
    attempts = repository.sent(db, account_id, exercises) if exercises else {}
    held = gradebook.held_since(db, account_id) if exercises else {}
    now = utc_now()

    def told(one: Mine, exercise: str) -> Sequence[Sent]:
        sent, since = attempts.get(exercise, ()), held.get(exercise)
        if since is None or held_back(one.assignment, now):
            return sent
        return [each for each in sent if each.sent_at < since]

    return {
        (one.assignment.id, row.exercise): result(one.rules, Counts(one.assignment.counts), told(one, row.exercise))
        for one in found
        for row in one.exercises
    }
