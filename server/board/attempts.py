"""Properties of one student's attempts at one exercise: pure. Attempts are in the order in which they were sent."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from typing import NamedTuple, TypeVar
from uuid import UUID

from graders.core.contract.outcomes import OPENS_HINTS, Blame, Outcome, outcomes_blamed_on
from server.gradebook.histories import Attempts, cached_per_series, cached_totals

FAILURES = frozenset(outcome.value for outcome in outcomes_blamed_on(Blame.STUDENT))
#: Failures of programs that run and answer wrongly.
WRONG_ANSWERS = frozenset((Outcome.WRONG_ANSWER.value, Outcome.INVALID_OUTPUT.value, Outcome.RUNTIME_ERROR.value))

Pair = tuple[UUID, str]


Value = TypeVar("Value")


def group_by_student(by_pair: Mapping[Pair, Value]) -> Mapping[UUID, Mapping[str, Value]]:
    """Return what belongs to each student, such as their attempts, by exercise."""
    by_student: dict[UUID, dict[str, Value]] = {}
    student, own = None, dict[str, Value]()
    for (account, exercise), value in by_pair.items():
        if account is not student:
            student, own = account, by_student.setdefault(account, {})
        own[exercise] = value
    return by_student


@dataclass(frozen=True, slots=True)
class MisconceptionEpisode:
    """A student's misconception at an exercise.

    `attempts`: from the first attempt that shows it to the first that shows it no more for good, None while the last
    one shows it. `followed`: another attempt came after the first that shows it; `improved`: and scored more.
    """

    account: UUID
    attempts: int | None
    followed: bool
    improved: bool


class FirstSuccess(NamedTuple):
    """The number of the first successful attempt, from 1, and the minutes from the first attempt to it."""

    attempts: int
    minutes: float


@cached_per_series
def find_misconception_episodes(attempts: Attempts) -> Sequence[tuple[str, MisconceptionEpisode]]:
    """Return each misconception that some attempt shows, with its episode."""
    episodes = []
    indices: dict[str, list[int]] = {}
    for index, attempt in enumerate(attempts):
        if attempt.diagnosis is not None:
            indices.setdefault(attempt.diagnosis, []).append(index)
    for misconception, (first, *later) in indices.items():
        last = later[-1] if later else first
        overcome = last < len(attempts) - 1
        followed = first < len(attempts) - 1
        improved = followed and attempts[first + 1].score > attempts[first].score
        episode = MisconceptionEpisode(
            attempts[first].account_id, last - first + 1 if overcome else None, followed, improved
        )
        episodes.append((misconception, episode))
    return episodes


def first_success_time(attempts: Attempts) -> datetime | None:
    """Return when the first of the attempts, of which there may be none, has succeeded."""
    return cached_totals(attempts).first_success_at if attempts else None


def is_solved(attempts: Attempts) -> bool:
    """Whether one of the attempts, of which there may be none, has succeeded."""
    return first_success_time(attempts) is not None


@cached_per_series
def find_first_success(attempts: Attempts) -> FirstSuccess | None:
    for number, attempt in enumerate(attempts, 1):
        if attempt.outcome == Outcome.OK:
            return FirstSuccess(number, (attempt.sent_at - attempts[0].sent_at).total_seconds() / 60)
    return None


def iter_improvements_after_hints(
    attempts: Attempts, starter: str | None, opens_after: Collection[int]
) -> Iterator[tuple[int, bool]]:
    """Yield each number of different failures that opened a hint, and whether the next attempt scored more.

    A hint that no attempt followed is left out. `starter`: the digest of the starter code, which opens nothing.
    """
    failed: set[str] = set()
    for attempt, following in pairwise(attempts):
        if attempt.outcome in OPENS_HINTS and attempt.digest != starter and attempt.digest not in failed:
            failed.add(attempt.digest)
            if len(failed) in opens_after:
                yield len(failed), following.score > attempt.score


def is_latest_failure_unexplained(attempts: Attempts) -> bool:
    """Whether the latest attempt answers wrongly without a known misconception."""
    return attempts[-1].diagnosis is None and attempts[-1].outcome in WRONG_ANSWERS
