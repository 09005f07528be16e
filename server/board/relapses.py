"""Whether a mended mistake that was asked again is rarer in the next exercise that needs it. Pure.

A student who mended a mistake of a family, and then begins another exercise that has mistakes of this family, makes one
of them again there or does not. In between they have answered a question about the family, or have not.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from server.course import Course
from server.gradebook.histories import Attempts, AttemptsByPair
from server.gradebook.mistakes import iter_past_mistakes
from server.recall.models import RecallAnswer

#: Cases of each kind under which no share is told.
FEWEST_CASES = 20


@dataclass(frozen=True)
class RelapseStats:
    """Cases of a student and a family: those asked again in between and those not, and how many made it again."""

    asked: int
    asked_again: int
    unasked: int
    unasked_again: int

    @property
    def relapse_shares(self) -> tuple[float, float] | None:
        """The shares of those asked and of those not who made it again; None for too few of either."""
        if min(self.asked, self.unasked) < FEWEST_CASES:
            return None
        return self.asked_again / self.asked, self.unasked_again / self.unasked


@dataclass(frozen=True)
class NextFamilyExercise:
    """The first exercise that a student began after mending a mistake of a family, of those that have some of it."""

    mended_at: datetime
    begun_at: datetime
    again: bool


def count_relapses(course: Course, attempts: AttemptsByPair, answers: Iterable[RecallAnswer]) -> RelapseStats:
    """Count, over the students of a class and the families, who was asked again and who made the mistake again."""
    own: dict[UUID, dict[str, Attempts]] = defaultdict(dict)
    for (account, exercise), series in attempts.items():
        own[account][exercise] = series
    asked_at: dict[tuple[UUID, str], list[datetime]] = defaultdict(list)
    for answer in answers:
        asked_at[answer.account_id, answer.subject].append(answer.answered_at)
    counts = {True: [0, 0], False: [0, 0]}
    for account, by_exercise in own.items():
        for family in course.families:
            need = find_next_family_exercise(course, by_exercise, family)
            if need is not None:
                between = [at for at in asked_at[account, family] if need.mended_at <= at < need.begun_at]
                counts[bool(between)][0] += 1
                counts[bool(between)][1] += need.again
    return RelapseStats(*counts[True], *counts[False])


def find_next_family_exercise(
    course: Course, by_exercise: Mapping[str, Attempts], family: str
) -> NextFamilyExercise | None:
    """Return the case of a student and a family; None where nothing was mended, or nothing begun since."""
    mended = [
        (mistake.mended.sent_at, exercise)
        for exercise, series in by_exercise.items()
        for mistake in iter_past_mistakes(series)
        if mistake.mended is not None
        and family in _families_of_misconceptions(course, exercise, [mistake.misconception])
    ]
    if not mended:
        return None
    mended_at, first = min(mended)
    later = [
        (series[0].sent_at, exercise)
        for exercise, series in by_exercise.items()
        if exercise != first and series[0].sent_at > mended_at and _has_family(course, exercise, family)
    ]
    if not later:
        return None
    begun_at, following = min(later)
    diagnoses = [attempt.diagnosis for attempt in by_exercise[following] if attempt.diagnosis is not None]
    return NextFamilyExercise(mended_at, begun_at, family in _families_of_misconceptions(course, following, diagnoses))


def _families_of_misconceptions(course: Course, exercise: str, misconceptions: Sequence[str]) -> set[str | None]:
    served = course.exercises.get(exercise)
    return set() if served is None else {served.filing.families.get(name) for name in misconceptions}


def _has_family(course: Course, exercise: str, family: str) -> bool:
    served = course.exercises.get(exercise)
    return served is not None and family in served.filing.families.values()
