"""Which students are stuck, and since when: pure. `RULE` says these rules on the page.

A student is judged on the exercise of their latest attempt alone, and by their own pace: the median time between two
of their attempts. `tests/board/test_stuck.py` measures the rules on simulated classes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum
from itertools import pairwise
from statistics import median
from uuid import UUID

from server.board.attempts import FAILURES, is_solved
from server.board.schemas import ProgressState
from server.gradebook.histories import Attempts, AttemptsByPair, cached_per_series, group_by_account
from server.gradebook.standings import StandingTotals

#: Different failures without progress (a better score than all before), and their least duration.
MIN_FAILURES, MIN_DURATION, PACES_WITHOUT_PROGRESS = 2, timedelta(minutes=8), 3.0
#: Time without any attempt after a failure, of a student who is there.
MIN_SILENCE, PACES_OF_SILENCE = timedelta(minutes=8), 2.5
#: Time without any attempt at the next exercise of a lesson.
MIN_BEGINNING, PACES_OF_BEGINNING = timedelta(minutes=10), 3.0
MAX_SILENCE = timedelta(minutes=40)
PRESENCE = timedelta(minutes=15)
BREAK = timedelta(minutes=60)  # a longer gap between two attempts is no pace, and begins anew
USUAL_PACE, MIN_GAPS = timedelta(minutes=3), 3  # of a student with fewer gaps
RULE = (
    "Un élève est bloqué après deux essais ratés différents, sans progrès depuis 8 minutes au moins et depuis trois "
    "fois le temps qu’il met d’habitude entre deux essais. Il l’est aussi s’il est là et n’envoie plus rien après un "
    "essai raté, depuis 8 minutes au moins et plus longtemps qu’à son habitude."
)


class StuckSign(StrEnum):
    """The sign by which a student is stuck."""

    failures = "failures"
    silence = "silence"
    beginning = "beginning"


@dataclass(frozen=True, slots=True)
class LessonExercises:
    """The exercises of a lesson, in their order, and when it began."""

    exercises: tuple[str, ...]
    started_at: datetime


@dataclass(frozen=True, slots=True)
class StuckStudent:
    """A student who is stuck at an exercise since a time; `failures` counts different ones without progress."""

    account: UUID
    exercise: str
    since: datetime
    sign: StuckSign
    failures: int


def find_stuck_students(
    attempts: AttemptsByPair,
    seen_at: Mapping[UUID, datetime | None],
    now: datetime,
    expected: LessonExercises | None = None,
) -> tuple[StuckStudent, ...]:
    """Return the students who are stuck now, the longest first: an order that whoever reads the page can check.

    `seen_at`: when each last opened a page.

    `expected`: the exercises of a lesson, where a student may also be stuck before the first attempt at the next one.
    """
    own = group_by_account(attempts)
    judged = (
        _judge_student(account, list(own.get(account, {}).values()), seen, now, expected)
        for account, seen in seen_at.items()
    )
    return tuple(sorted((row for row in judged if row is not None), key=lambda row: (row.since, str(row.account))))


def _judge_student(
    account: UUID,
    all_series: Sequence[Attempts],
    seen_at: datetime | None,
    now: datetime,
    expected: LessonExercises | None,
) -> StuckStudent | None:
    if seen_at is None:
        return None
    latest = max(all_series, key=_last_sent_at, default=())
    is_working = bool(latest) and now - latest[-1].sent_at <= MAX_SILENCE
    run = trailing_failures_without_progress(latest) if is_working else ()
    if run:
        return _find_stuck_by_failures(run, all_series, seen_at, now)
    return None if expected is None else _find_stuck_at_beginning(account, latest, all_series, seen_at, now, expected)


def _last_sent_at(series: Attempts) -> datetime:
    return series[-1].sent_at


def _find_stuck_by_failures(
    run: Attempts, all_series: Sequence[Attempts], seen_at: datetime, now: datetime
) -> StuckStudent | None:
    last = run[-1]
    failures = len({attempt.digest for attempt in run})
    silence, duration = now - last.sent_at, now - run[0].sent_at
    # The pace asks for longer times still: it is computed only for those who would be stuck at the quickest one.
    may_repeat = failures >= MIN_FAILURES and duration >= MIN_DURATION
    if not (may_repeat or silence >= MIN_SILENCE) or not _is_present(seen_at, last.sent_at, now):
        return None
    pace = median_pace(all_series)
    least_silence = max(MIN_SILENCE, PACES_OF_SILENCE * pace)
    repeats = may_repeat and duration >= PACES_WITHOUT_PROGRESS * pace
    if not (repeats or silence >= least_silence):
        return None
    return StuckStudent(
        account=last.account_id,
        exercise=last.exercise,
        since=run[0].sent_at if repeats else last.sent_at,
        sign=StuckSign.failures if repeats else StuckSign.silence,
        failures=failures,
    )


def _find_stuck_at_beginning(
    account: UUID,
    latest: Attempts,
    all_series: Sequence[Attempts],
    seen_at: datetime,
    now: datetime,
    expected: LessonExercises,
) -> StuckStudent | None:
    """Judge a student who has sent nothing to the next exercise of the lesson since they were free to."""
    sent_at = latest[-1].sent_at if latest else expected.started_at
    silence = now - max(sent_at, expected.started_at)
    if silence < MIN_BEGINNING or not _is_present(seen_at, expected.started_at, now):
        return None
    by_exercise = {series[0].exercise: series for series in all_series}
    left = [name for name in expected.exercises if not is_solved(by_exercise.get(name, ()))]
    if not left or silence < PACES_OF_BEGINNING * median_pace(all_series):
        return None
    return StuckStudent(account, left[0], now - silence, StuckSign.beginning, 0)


def _is_present(seen_at: datetime, sent_at: datetime, now: datetime) -> bool:
    return seen_at >= sent_at - PRESENCE and now - max(seen_at, sent_at) <= PRESENCE


def trailing_failures_without_progress(attempts: Attempts, pause: timedelta = BREAK) -> Attempts:
    """Return the failures at the end of a series since its last progress, or the last gap longer than `pause`.

    None where one of them is no failure.
    """
    start, best = 0, None
    for index, attempt in enumerate(attempts):
        if index and attempt.sent_at - attempts[index - 1].sent_at > pause:
            start = index
        elif best is not None and attempt.score > best:
            start = index + 1
        best = attempt.score if best is None else max(best, attempt.score)
    run = attempts[start:] or attempts[-1:]
    return run if all(attempt.outcome in FAILURES for attempt in run) else ()


def median_pace(all_series: Sequence[Attempts]) -> timedelta:
    """Return the median time between two attempts of a student, breaks left out; the usual one for few attempts."""
    gaps = [gap for series in all_series for gap in _gaps_in_seconds(series)]
    return timedelta(seconds=median(gaps)) if len(gaps) >= MIN_GAPS else USUAL_PACE


@cached_per_series
def _gaps_in_seconds(attempts: Attempts) -> Sequence[float]:
    """Return the seconds between an attempt and the next, breaks left out."""
    gaps = [later.sent_at - earlier.sent_at for earlier, later in pairwise(attempts)]
    return tuple(gap.total_seconds() for gap in gaps if gap <= BREAK)


def classify_progress(totals: StandingTotals | None, *, stuck: bool) -> ProgressState:
    if totals is None:
        return ProgressState.none
    if totals.first_success_at is not None:
        return ProgressState.solved
    return ProgressState.stuck if stuck else ProgressState.trying


def median_or_none(values: Sequence[float]) -> float | None:
    return float(median(values)) if values else None
