"""What the attempts of a class say of its exercises, of their hints and of its misconceptions."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from itertools import pairwise
from statistics import correlation
from uuid import UUID

from server.board.schemas import (
    FEWEST_FOR_A_CORRELATION,
    FEWEST_FOR_A_SHARE,
    ActivitySlot,
    ExerciseStats,
    HintStats,
    ImprovementStats,
    MisconceptionStats,
)
from server.board.states import median_of
from server.board.trails import Pair, Trails, after_hints
from server.course import Course
from server.gradebook.schemas import HINT_OPENS_AFTER
from server.gradebook.standings import StandingTotals
from server.submissions.service import digest

LESSON, SLOT = timedelta(hours=2), timedelta(minutes=5)
DAYS = 14
DUST = 1e-9  # what rounding leaves where nothing varies
Whole = tuple[float, int]


def items(
    exercises: Sequence[str], standings: Mapping[Pair, StandingTotals], trails: Trails
) -> tuple[ExerciseStats, ...]:
    """Of each exercise."""
    solved: dict[str, list[tuple[int, float]]] = defaultdict(list)
    for (_, exercise), trail in trails.items():
        if found := trail.first_success:
            solved[exercise].append(found)
    tried, whole = _scores(standings)
    return tuple(_item(name, tried.get(name, {}), solved.get(name, []), whole) for name in exercises)


def _scores(
    standings: Mapping[Pair, StandingTotals],
) -> tuple[Mapping[str, Mapping[UUID, float]], Mapping[UUID, Whole]]:
    """By exercise, the best score of each student who has tried it; and what these come to for each student."""
    found: dict[str, dict[UUID, float]] = defaultdict(dict)
    whole: dict[UUID, Whole] = defaultdict(lambda: (0.0, 0))
    for (account, exercise), sums in standings.items():
        found[exercise][account] = sums.best_score
        total, count = whole[account]
        whole[account] = (total + sums.best_score, count + 1)
    return found, whole


def _item(
    exercise: str, mine: Mapping[UUID, float], solved: Sequence[tuple[int, float]], whole: Mapping[UUID, Whole]
) -> ExerciseStats:
    correlation, paired = item_rest(mine, whole)
    return ExerciseStats(
        exercise=exercise,
        n=len(mine),
        solved=len(solved),
        success=len(solved) / len(mine) if len(mine) >= FEWEST_FOR_A_SHARE else None,
        median_attempts=median_of([attempts for attempts, _ in solved]),
        median_minutes=median_of([minutes for _, minutes in solved]),
        discrimination=correlation,
        paired=paired,
    )


def item_rest(mine: Mapping[UUID, float], whole: Mapping[UUID, Whole]) -> tuple[float | None, int]:
    """The correlation of scores here with the mean of the same students' scores elsewhere; over how many students.

    `whole`: the sum of each student's scores, this one among them, and how many there are.
    """
    pairs = []
    for account, score in mine.items():
        total, count = whole[account]
        if count > 1:
            pairs.append((score, (total - score) / (count - 1)))
    if len(pairs) < FEWEST_FOR_A_CORRELATION:
        return None, len(pairs)
    here, elsewhere = zip(*pairs, strict=True)
    if max(here) - min(here) < DUST or max(elsewhere) - min(elsewhere) < DUST:
        return None, len(pairs)
    return round(correlation(here, elsewhere), 3), len(pairs)


def helped(misconceptions: Sequence[MisconceptionStats]) -> tuple[ImprovementStats, ...]:
    """What came after each misconception was first told, the commonest first."""
    told = [
        ImprovementStats(one.exercise, one.title, one.followed, one.improved) for one in misconceptions if one.followed
    ]
    return tuple(sorted(told, key=lambda one: -one.n))


def hints(course: Course, exercises: Sequence[str], trails: Trails) -> tuple[HintStats, ...]:
    """What came after each hint had opened; it is not known who has read it."""
    starters = {name: digest(one.starter) for name in exercises if (one := course.exercises.get(name)) is not None}
    found: dict[str, dict[int, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for (_, exercise), trail in trails.items():
        for failures, better in after_hints(trail, starters.get(exercise), HINT_OPENS_AFTER):
            found[exercise][failures].append(better)
    return tuple(HintStats(name, _levels(name, found[name])) for name in exercises if name in found)


def _levels(exercise: str, found: Mapping[int, Sequence[bool]]) -> tuple[ImprovementStats, ...]:
    return tuple(
        ImprovementStats(exercise, f"Indice {level}", len(found.get(failures, ())), sum(found.get(failures, ())))
        for level, failures in enumerate(HINT_OPENS_AFTER, 1)
    )


def activity(times: Sequence[datetime], now: datetime) -> tuple[tuple[ActivitySlot, ...], tuple[ActivitySlot, ...]]:
    """The attempts of a lesson's time by slots of some minutes, and of two weeks by days (UTC), until now.

    `times`: when each was sent, the oldest first.
    """
    minute = now.replace(second=0, microsecond=0)
    begins = minute - timedelta(minutes=minute.minute % 5) - LESSON + SLOT
    today = now.replace(hour=0, minute=0, second=0, microsecond=0)
    lesson = [begins + SLOT * place for place in range(LESSON // SLOT + 1)]
    days = [today + timedelta(days=place - DAYS + 1) for place in range(DAYS + 1)]
    return _slots(times, lesson), _slots(times, days)


def _slots(times: Sequence[datetime], edges: Sequence[datetime]) -> tuple[ActivitySlot, ...]:
    places = [bisect_left(times, edge) for edge in edges]
    return tuple(
        ActivitySlot(edge, after - before) for edge, (before, after) in zip(edges, pairwise(places), strict=False)
    )
