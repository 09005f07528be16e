"""Choose which of a student's attempts at an exercise counts in an assignment. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TypeVar
from uuid import UUID

from server.assignments.models import AttemptSelection
from server.assignments.rules import MAX_POINTS, Rules


@dataclass(frozen=True)
class ScoredAttempt:
    """A graded attempt; `score` in [0, 1]."""

    id: UUID
    sent_at: datetime
    score: float


Attempt = TypeVar("Attempt", bound=ScoredAttempt)


@dataclass(frozen=True)
class AttemptMark:
    """Points out of 20 of an attempt after any late penalty; `full_points` before it; days late."""

    attempt: UUID
    points: float
    full_points: float
    days_late: int


@dataclass(frozen=True)
class ExerciseResult:
    """The mark that counts and the best mark before the due date, None without any; `attempts` within the dates."""

    counted: AttemptMark | None
    before_due: AttemptMark | None
    attempts: int


NO_RESULT = ExerciseResult(None, None, 0)


def mark_attempts(rules: Rules, counts: AttemptSelection, attempts: Sequence[ScoredAttempt]) -> ExerciseResult:
    """Mark a student's attempts at one exercise, given in any order and without internal errors.

    Among equal marks the earliest is the best. Attempts outside the dates are ignored.
    """
    if not attempts:
        return NO_RESULT
    marks = _marks(rules, sorted(attempts, key=lambda attempt: (attempt.sent_at, attempt.id.int)))
    on_time = _best([mark for mark in marks if not mark.days_late])
    if counts is AttemptSelection.last:
        counted = marks[-1] if marks else None
    else:
        counted = on_time if counts is AttemptSelection.best_before_due else _best(marks)
    return ExerciseResult(counted, on_time, len(marks))


def attempts_in_sitting(
    attempts: Iterable[Attempt], began_at: datetime | None, ended_at: datetime | None
) -> list[Attempt]:
    """Return the attempts sent during a sitting; none where it never began.

    Attempts outside the sitting may lie between the test's dates: those of a guest who later signed in as the student.
    """
    if began_at is None:
        return []
    return [
        attempt
        for attempt in attempts
        if began_at <= attempt.sent_at and (ended_at is None or attempt.sent_at <= ended_at)
    ]


def _marks(rules: Rules, attempts: Iterable[ScoredAttempt]) -> Sequence[AttemptMark]:
    marks = []
    for attempt in attempts:
        full_points = MAX_POINTS * attempt.score
        adjusted = rules.apply_lateness(attempt.sent_at, full_points)
        if adjusted.points is not None:
            marks.append(AttemptMark(attempt.id, adjusted.points, full_points, adjusted.days_late))
    return marks


def _best(marks: Sequence[AttemptMark]) -> AttemptMark | None:
    return max(marks, key=lambda mark: mark.points, default=None)
