"""What students have sent, for their marks: of what is as it was before, nothing is read nor reckoned again."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property, lru_cache
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.counting import Sent, result
from server.assignments.models import Counts
from server.assignments.rules import Rules
from server.base.caches import Lately
from server.gradebook.sent import Attempt, Histories, Revisions
from server.gradebook.sent import until as sent_until
from server.marks.schemas import AssignmentMark, ExerciseMark, StudentExercise

MOST_KEPT = 60_000  # attempts of all who were asked about last, 1 kB each at most
MOST_TERMS = 8  # under which one student's attempts at an exercise are kept reckoned
MOST_EMPTY = 4096


@dataclass(frozen=True)
class Graded(Sent):
    """An attempt, with the name of the grading that counts."""

    grading: str


class Terms(NamedTuple):
    """All that a mark at an exercise depends on, but for what was sent and what a teacher has set."""

    due_at: datetime | None
    closes_at: datetime | None
    late: str
    late_per_day: float
    counts: str
    weight: float

    @classmethod
    def of(cls, rules: Rules, counts: Counts, weight: float) -> Terms:
        return cls(rules.due_at, rules.closes_at, rules.late.value, rules.late_per_day, counts.value, weight)


class Trail(tuple[Graded, ...]):
    """What one student sent to one exercise, with the marks that it comes to."""

    @cached_property
    def marks(self) -> dict[Terms, ExerciseMark]:
        return {}


Trails = Mapping[StudentExercise, Trail]


def mark_of(exercise: str, sent: Sequence[Graded], rules: Rules, terms: Terms) -> ExerciseMark:
    """As the attempts make it; `terms` are those of the rules."""
    if not sent:
        return _nothing(exercise, terms.weight)
    found = result(rules, Counts(terms.counts), sent)
    counted = None if found.counted is None else next(one for one in sent if one.id == found.counted.attempt)
    return ExerciseMark(
        exercise=exercise,
        weight=terms.weight,
        counted=found.counted,
        grading=None if counted is None else counted.grading,
        sent_at=None if counted is None else counted.sent_at,
        attempts=found.attempts,
        override=None,
    )


def known_mark(exercise: str, sent: Trail, rules: Rules, terms: Terms) -> ExerciseMark:
    """The same, reckoned once."""
    mark = sent.marks.get(terms)
    if mark is None:
        if len(sent.marks) >= MOST_TERMS:
            sent.marks.clear()
        mark = sent.marks[terms] = mark_of(exercise, sent, rules, terms)
    return mark


def known(mark: AssignmentMark, of: tuple[UUID, UUID]) -> AssignmentMark:
    """The same mark as it was made last, `of` this assignment and student, with all that it was found to come to."""
    before = _MADE.get(of)
    return before if before == mark else _MADE.put(of, mark)


@lru_cache(maxsize=MOST_EMPTY)
def _nothing(exercise: str, weight: float) -> ExerciseMark:
    return ExerciseMark(exercise, weight, None, None, None, 0, None)


_MADE: Lately[tuple[UUID, UUID], AssignmentMark] = Lately(MOST_KEPT, size=lambda mark: len(mark.exercises) + 1)


def _trails(attempts: Sequence[Attempt]) -> Mapping[str, Trail]:
    """By exercise, errors of ours left out."""
    counted = (one for one in attempts if one.score is not None)
    return {exercise: _trail(group) for exercise, group in groupby(counted, attrgetter("exercise"))}


def _trail(attempts: Iterable[Attempt]) -> Trail:
    return Trail(Graded(one.submission, one.sent_at, one.score or 0.0, str(one.grading)) for one in attempts)


_SENT = Histories.of(_trails, MOST_KEPT)


def graded(
    db: Session, revisions: Revisions, exercises: Collection[str], until: datetime | None
) -> tuple[Trails, Revisions]:
    """The graded attempts at exercises of those whose `revisions` were just asked for, errors of ours left out; and the
    revisions that they have.

    `until`: when the class was archived; nothing that is sent later is its business.
    """
    told = _SENT.told(db, revisions)
    found = {
        (account, exercise): sent_until(trail, until)
        for account, known in told.items()
        for exercise, trail in known.value.items()
        if exercise in exercises
    }
    return {key: trail for key, trail in found.items() if trail}, {one: known.revision for one, known in told.items()}
