"""What the classes looked at last have done. The database is asked each time; what it tells as it did before is not
read, nor reckoned, again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.caches import Lately
from server.board import repository
from server.board.done import Done
from server.board.repository import TOLD, Scope, Sent
from server.board.trails import Trail
from server.course import Course
from server.database import Told
from server.database import told as database

MOST_KEPT = 60_000  # attempts and cells of all classes that are kept: 1 kB each at most

Attempts = database.Kept[Trail]


@dataclass(frozen=True)
class Kept:
    """A class's attempts as the database told them, by student and exercise with what was read, and what they are."""

    told: Sequence[Told]
    attempts: Attempts
    done: Done

    @property
    def size(self) -> int:
        return len(self.told) + len(self.done.students) * len(self.done.exercises) + 1


_KEPT: Lately[tuple[UUID, Sequence[str]], Kept] = Lately(MOST_KEPT, size=lambda kept: kept.size)


def done(db: Session, course: Course, scope: Scope, students: Sequence[UUID]) -> Done:
    """What the students of a class have done by now."""
    told, key = repository.history(db, scope), (scope.class_id, tuple(scope.exercises))
    kept = _KEPT.get(key)
    if kept is not None and kept.told == told and kept.done.course is course and kept.done.students == tuple(students):
        return kept.done
    attempts = _attempts(db, told, kept.attempts if kept is not None else {})
    trails = {(trail[0].account, trail[0].exercise): trail for _, trail in attempts.values()}
    found = Done(course, tuple(students), tuple(scope.exercises), trails)
    return _KEPT.put(key, Kept(told, attempts, found)).done


def _attempts(db: Session, told: Sequence[Told], before: Attempts) -> Attempts:
    read = TOLD.reader(db)
    return database.kept(told, itemgetter(0, 1), before, lambda rows: Trail(Sent(*read(row)) for row in rows))
