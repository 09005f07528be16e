"""What the classes looked at last have done. The database is asked each time whether it is still so; what has not
changed is not read, nor reckoned, again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from operator import attrgetter
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.caches import Lately
from server.board.done import Done
from server.board.repository import Scope, Sent
from server.board.trails import Trail
from server.course import Course
from server.gradebook.sent import Attempt, Histories, Revisions, revisions, until

MOST_KEPT = 60_000  # attempts and cells of all classes that are kept: 1 kB each at most


@dataclass(frozen=True)
class Kept:
    """What a class has done, and the revisions of what was read of it."""

    revisions: Revisions
    done: Done

    @property
    def size(self) -> int:
        return sum(map(len, self.done.trails.values())) + len(self.done.students) * len(self.done.exercises) + 1


_KEPT: Lately[tuple[UUID, Sequence[str], datetime | None], Kept] = Lately(MOST_KEPT, size=lambda kept: kept.size)


def done(db: Session, course: Course, scope: Scope, students: Sequence[UUID]) -> Done:
    """What the students of a class have done by now."""
    told, key = revisions(db, students), (scope.class_id, tuple(scope.exercises), scope.until)
    kept = _KEPT.get(key)
    if kept is not None and _is_of(kept.done, course, students) and kept.revisions == told:
        return kept.done
    known = _SENT.told(db, told)
    trails = {
        (student, exercise): trail
        for student, one in known.items()
        for exercise, whole in one.value.items()
        if exercise in scope.exercises and (trail := until(whole, scope.until))
    }
    found = Done(course, tuple(students), tuple(scope.exercises), trails)
    return _KEPT.put(key, Kept({student: one.revision for student, one in known.items()}, found)).done


def _is_of(done: Done, course: Course, students: Sequence[UUID]) -> bool:
    return done.course is course and done.students == tuple(students)


def _trails(attempts: Sequence[Attempt]) -> Mapping[str, Trail]:
    """By exercise, errors of ours left out."""
    sent = (_sent(one, one.score) for one in attempts if one.score is not None)
    return {exercise: Trail(group) for exercise, group in groupby(sent, attrgetter("exercise"))}


def _sent(one: Attempt, score: float) -> Sent:
    return Sent(one.account, one.exercise, one.sent_at, one.digest, one.outcome, score, one.diagnosis, one.submission)


_SENT = Histories.of(_trails, MOST_KEPT)
