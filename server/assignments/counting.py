"""Which of a student's attempts at an exercise counts in an assignment: pure."""

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


One = TypeVar("One", bound=ScoredAttempt)


@dataclass(frozen=True)
class AttemptMark:
    """Points out of 20 of the attempt that counts, as lateness leaves them; what it was worth on time; days late."""

    attempt: UUID
    points: float
    full_points: float
    days_late: int


@dataclass(frozen=True)
class ExerciseResult:
    """What counts, and what was best before the due date; None where there is nothing. `attempts` within the dates."""

    counted: AttemptMark | None
    before_due: AttemptMark | None
    attempts: int


NO_RESULT = ExerciseResult(None, None, 0)


def mark_attempts(rules: Rules, counts: AttemptSelection, attempts: Sequence[ScoredAttempt]) -> ExerciseResult:
    """Of a student's attempts at one exercise, in any order, but errors of ours.

    Of equals the earliest counts as best. An attempt outside the dates is as if it had not been sent.
    """
    if not attempts:
        return NO_RESULT
    marks = _marks(rules, sorted(attempts, key=lambda one: (one.sent_at, one.id.int)))
    on_time = _best([mark for mark in marks if not mark.days_late])
    if counts is AttemptSelection.last:
        counted = marks[-1] if marks else None
    else:
        counted = on_time if counts is AttemptSelection.best_before_due else _best(marks)
    return ExerciseResult(counted, on_time, len(marks))


def attempts_in_sitting(attempts: Iterable[One], began_at: datetime | None, ended_at: datetime | None) -> list[One]:
    """Those of a test that were sent while its student sat it; none where they never began.

    Others may stand between its dates too: what a guest had sent, whom the student then turned out to be.
    """
    if began_at is None:
        return []
    return [one for one in attempts if began_at <= one.sent_at and (ended_at is None or one.sent_at <= ended_at)]


def _marks(rules: Rules, attempts: Iterable[ScoredAttempt]) -> Sequence[AttemptMark]:
    found = []
    for one in attempts:
        worth = rules.apply_lateness(one.sent_at, MAX_POINTS * one.score)
        if worth.points is not None:
            found.append(AttemptMark(one.id, worth.points, MAX_POINTS * one.score, worth.days_late))
    return found


def _best(marks: Sequence[AttemptMark]) -> AttemptMark | None:
    return max(marks, key=lambda mark: mark.points, default=None)
