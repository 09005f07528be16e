"""Choose which of a student's attempts at an exercise counts in an assignment. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Protocol
from uuid import UUID

from server.assignments.models import AttemptSelection
from server.assignments.rules import MAX_POINTS, SendTiming


@dataclass(frozen=True)
class ScoredAttempt:
    """A graded attempt; `score` in [0, 1]."""

    id: UUID
    sent_at: datetime
    score: float


class SendTimingJudge(Protocol):
    """`rules.Windows` of a student, or `rules.Rules` where there is no sitting."""

    def judge_timing(self, sent_at: datetime, /) -> SendTiming: ...


@dataclass(frozen=True)
class AttemptMark:
    """Points out of 20 of an attempt after any late penalty; `full_points` before it; days late."""

    attempt: UUID
    points: float
    full_points: float
    days_late: int


@dataclass(frozen=True)
class ExerciseResult:
    """The mark that counts, None without any; `attempts` within the dates."""

    counted: AttemptMark | None
    attempts: int


NO_RESULT = ExerciseResult(None, 0)


def mark_attempts(
    times: SendTimingJudge, counts: AttemptSelection, attempts: Sequence[ScoredAttempt]
) -> ExerciseResult:
    """Mark a student's attempts at one exercise, given in any order and without internal errors.

    Among equal marks the earliest is the best. Attempts that do not count by their time are ignored. Of the last one,
    an attempt that was refused when it arrived, and counts since the rules have changed, only improves the mark.
    """
    if not attempts:
        return NO_RESULT
    timed = _mark_counting_attempts(times, sorted(attempts, key=lambda attempt: (attempt.sent_at, attempt.id.int)))
    marks = [mark for mark, _ in timed]
    if counts is AttemptSelection.last:
        counted = _last_mark(timed)
    elif counts is AttemptSelection.best_before_due:
        counted = _best_mark([mark for mark in marks if not mark.days_late])
    else:
        counted = _best_mark(marks)
    return ExerciseResult(counted, len(marks))


def _mark_counting_attempts(
    times: SendTimingJudge, attempts: Iterable[ScoredAttempt]
) -> Sequence[tuple[AttemptMark, SendTiming]]:
    marks = []
    for attempt in attempts:
        full_points = MAX_POINTS * attempt.score
        timing = times.judge_timing(attempt.sent_at)
        adjusted = timing.apply_late_penalty(full_points)
        if adjusted.points is not None:
            marks.append((AttemptMark(attempt.id, adjusted.points, full_points, adjusted.days_late), timing))
    return marks


def _best_mark(marks: Sequence[AttemptMark]) -> AttemptMark | None:
    return max(marks, key=lambda mark: mark.points, default=None)


def _last_mark(timed: Sequence[tuple[AttemptMark, SendTiming]]) -> AttemptMark | None:
    last = None
    for mark, timing in timed:
        if last is None or timing.counted_on_arrival or mark.points > last.points:
            last = mark
    return last
