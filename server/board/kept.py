"""What the classes looked at last have done. The database is asked each time; what it tells as it did before is not
read, nor reckoned, again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.caches import Lately
from server.board import repository
from server.board.done import Done
from server.board.repository import Scope, Told
from server.board.trails import Trail
from server.course import Course

MOST_ATTEMPTS = 30_000  # of all classes that are kept: about 1 kB each

Attempts = Mapping[tuple[object, object], tuple[Sequence[Told], Trail]]


@dataclass(frozen=True)
class Kept:
    """A class's attempts as the database told them, by student and exercise with what was read, and what they are."""

    told: Sequence[Told]
    attempts: Attempts
    done: Done


_KEPT: Lately[UUID, Kept] = Lately(MOST_ATTEMPTS, size=lambda kept: len(kept.told))


def done(db: Session, course: Course, scope: Scope, students: Sequence[UUID]) -> Done:
    """What the students of a class have done by now."""
    told = repository.history(db, scope)
    kept = _KEPT.get(scope.class_id)
    if kept is not None and kept.told == told and _same(kept.done, course, scope, students):
        return kept.done
    attempts = _read(db, told, kept.attempts if kept is not None else {})
    trails = {(trail[0].account, trail[0].exercise): trail for _, trail in attempts.values()}
    found = Done(course, tuple(students), tuple(scope.exercises), trails)
    return _KEPT.put(scope.class_id, Kept(told, attempts, found)).done


def _same(done: Done, course: Course, scope: Scope, students: Sequence[UUID]) -> bool:
    asked = (tuple(students), tuple(scope.exercises))
    return done.course is course and (done.students, done.exercises) == asked


def _read(db: Session, told: Sequence[Told], before: Attempts) -> Attempts:
    sent = repository.reader(db)
    attempts = {}
    for pair, group in groupby(told, key=lambda one: one[:2]):
        rows, known = list(group), before.get(pair)
        attempts[pair] = known if known is not None and known[0] == rows else (rows, Trail(map(sent, rows)))
    return attempts
