"""Statistics over the attempts of a class: its exercises, hints and misconceptions, and its activity. Pure."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from itertools import pairwise
from statistics import correlation
from typing import NamedTuple
from uuid import UUID

from server.board.attempts import FirstSuccess, find_first_success, iter_improvements_after_hints
from server.board.schemas import (
    FEWEST_FOR_A_CORRELATION,
    FEWEST_FOR_A_SHARE,
    ActivitySlot,
    ExerciseStats,
    HintStats,
    ImprovementStats,
    MisconceptionStats,
)
from server.board.stuck import median_or_none
from server.course import Course
from server.gradebook.histories import Attempts, AttemptsByPair, cached_per_history, cached_totals, group_by_account
from server.gradebook.schemas import HINT_OPENS_AFTER
from server.submissions.service import digest_code

LESSON, SLOT = timedelta(hours=2), timedelta(minutes=5)
DAYS = 14
ROUNDING_NOISE = 1e-9


class ScoreSum(NamedTuple):
    """The sum of a student's best scores, and the number of exercises that they have tried."""

    total: float
    exercises: int


def compute_exercise_stats(exercises: Sequence[str], attempts: AttemptsByPair) -> tuple[ExerciseStats, ...]:
    """Return the statistics of each exercise."""
    successes: dict[str, list[FirstSuccess]] = defaultdict(list)
    scores: dict[str, dict[UUID, float]] = defaultdict(dict)
    sums: dict[UUID, ScoreSum] = {}
    for account_id, own in group_by_account(attempts).items():
        rows = _best_scores_and_successes(own, "all")
        for exercise, best_score, success in rows:
            scores[exercise][account_id] = best_score
            if success:
                successes[exercise].append(success)
        sums[account_id] = ScoreSum(sum(best_score for _, best_score, _ in rows), len(rows))
    return tuple(_build_exercise_stats(name, scores.get(name, {}), successes.get(name, []), sums) for name in exercises)


@cached_per_history
def _best_scores_and_successes(
    own: Mapping[str, Attempts], place: str
) -> tuple[tuple[str, float, FirstSuccess | None], ...]:
    """Return the best score and the first success of a student at each exercise."""
    return tuple((name, cached_totals(series).best_score, find_first_success(series)) for name, series in own.items())


def _build_exercise_stats(
    exercise: str, scores: Mapping[UUID, float], successes: Sequence[FirstSuccess], sums: Mapping[UUID, ScoreSum]
) -> ExerciseStats:
    discrimination, paired = item_rest_correlation(scores, sums)
    return ExerciseStats(
        exercise=exercise,
        n=len(scores),
        solved=len(successes),
        success=len(successes) / len(scores) if len(scores) >= FEWEST_FOR_A_SHARE else None,
        median_attempts=median_or_none([success.attempts for success in successes]),
        median_minutes=median_or_none([success.minutes for success in successes]),
        discrimination=discrimination,
        paired=paired,
    )


def item_rest_correlation(scores: Mapping[UUID, float], sums: Mapping[UUID, ScoreSum]) -> tuple[float | None, int]:
    """Return the correlation of the scores at an exercise with the mean of the same students' other scores, and the
    number of students.

    `sums`: the sum of each student's best scores, that at this exercise among them. The correlation is None for few
    students, or where either side does not vary.
    """
    pairs = []
    for account_id, score in scores.items():
        total, count = sums[account_id]
        if count > 1:
            pairs.append((score, (total - score) / (count - 1)))
    if len(pairs) < FEWEST_FOR_A_CORRELATION:
        return None, len(pairs)
    here, elsewhere = zip(*pairs, strict=True)
    if max(here) - min(here) < ROUNDING_NOISE or max(elsewhere) - min(elsewhere) < ROUNDING_NOISE:
        return None, len(pairs)
    return round(correlation(here, elsewhere), 3), len(pairs)


def improvements_after_misconceptions(misconceptions: Sequence[MisconceptionStats]) -> tuple[ImprovementStats, ...]:
    """Return how often the attempt after each misconception's first one scored more, the commonest first."""
    improved = [
        ImprovementStats(stats.exercise, stats.title, stats.followed, stats.improved)
        for stats in misconceptions
        if stats.followed
    ]
    return tuple(sorted(improved, key=lambda stats: -stats.n))


def compute_hint_stats(course: Course, exercises: Sequence[str], attempts: AttemptsByPair) -> tuple[HintStats, ...]:
    """Return how often the attempt after the opening of each hint scored more; who has read it is not known."""
    starters = {
        name: digest_code(known.starter) for name in exercises if (known := course.exercises.get(name)) is not None
    }
    improved: dict[str, dict[int, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for own in group_by_account(attempts).values():
        for exercise, failures, better in _find_opened_hints(own, "all", starters):
            improved[exercise][failures].append(better)
    return tuple(
        HintStats(name, _improvement_stats_by_hint(name, improved[name])) for name in exercises if name in improved
    )


@cached_per_history
def _find_opened_hints(
    own: Mapping[str, Attempts],
    place: str,
    starters: Mapping[str, str],
) -> tuple[tuple[str, int, bool], ...]:
    """Return each hint opened to a student: exercise, failures before it, whether the next attempt scored more."""
    return tuple(
        (exercise, failures, better)
        for exercise, series in own.items()
        for failures, better in iter_improvements_after_hints(series, starters.get(exercise), HINT_OPENS_AFTER)
    )


def _improvement_stats_by_hint(exercise: str, improved: Mapping[int, Sequence[bool]]) -> tuple[ImprovementStats, ...]:
    return tuple(
        ImprovementStats(exercise, f"Indice {level}", len(improved.get(failures, ())), sum(improved.get(failures, ())))
        for level, failures in enumerate(HINT_OPENS_AFTER, 1)
    )


def activity_slot_start(now: datetime) -> datetime:
    """Return the begin of the present slot, on which alone the edges of `count_recent_activity` depend."""
    return now.replace(minute=now.minute - now.minute % 5, second=0, microsecond=0)


def count_recent_activity(
    times: Sequence[datetime], now: datetime
) -> tuple[tuple[ActivitySlot, ...], tuple[ActivitySlot, ...]]:
    """Count the attempts of the last two hours by slots of five minutes, and of the last two weeks by days (UTC).

    `times`: when each was sent, the oldest first.
    """
    begin = activity_slot_start(now) - LESSON + SLOT
    today = now.replace(hour=0, minute=0, second=0, microsecond=0)
    lesson = [begin + SLOT * index for index in range(LESSON // SLOT + 1)]
    days = [today + timedelta(days=index - DAYS + 1) for index in range(DAYS + 1)]
    return _count_by_slot(times, lesson), _count_by_slot(times, days)


def _count_by_slot(times: Sequence[datetime], edges: Sequence[datetime]) -> tuple[ActivitySlot, ...]:
    indices = [bisect_left(times, edge) for edge in edges]
    return tuple(
        ActivitySlot(edge, after - before) for edge, (before, after) in zip(edges, pairwise(indices), strict=False)
    )
