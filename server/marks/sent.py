"""What students have sent, for their marks. The database is asked each time; of what it tells as it did before, nothing
is read nor reckoned again."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache
from operator import itemgetter
from typing import NamedTuple
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.counting import Sent, result
from server.assignments.models import Counts
from server.assignments.rules import Rules
from server.base.caches import Lately
from server.database import Told
from server.database import told as database
from server.marks import repository
from server.marks.schemas import AssignmentMark, ExerciseMark, Key

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

    marks: dict[Terms, ExerciseMark]


Trails = Mapping[Key, Trail]


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


@dataclass(frozen=True)
class _Kept:
    told: Sequence[Told]
    attempts: database.Kept[tuple[Key, Trail]]
    trails: Trails


_KEPT: Lately[tuple[Sequence[UUID], frozenset[str], datetime | None], _Kept] = Lately(
    MOST_KEPT, size=lambda kept: len(kept.told) + 1
)

_MADE: Lately[tuple[UUID, UUID], AssignmentMark] = Lately(MOST_KEPT, size=lambda mark: len(mark.exercises) + 1)


def graded(db: Session, students: Collection[UUID], exercises: Collection[str], until: datetime | None) -> Trails:
    """The graded attempts of students at exercises, errors of ours left out.

    `until`: when the class was archived; nothing that is sent later is its business.
    """
    told, key = repository.graded(db, students, exercises, until), (tuple(students), frozenset(exercises), until)
    kept = _KEPT.get(key)
    if kept is not None and kept.told == told:
        return kept.trails
    read = repository.TOLD.reader(db)

    def trail(rows: Sequence[Told]) -> tuple[Key, Trail]:
        found = [read(row) for row in rows]
        made = Trail(Graded(name, at, score, str(grading)) for _, _, name, at, score, grading in found)
        made.marks = {}
        return (found[0][0], found[0][1]), made

    attempts = database.kept(told, itemgetter(0, 1), kept.attempts if kept is not None else {}, trail)
    return _KEPT.put(key, _Kept(told, attempts, dict(made for _, made in attempts.values()))).trails
