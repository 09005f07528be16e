"""The review of a lesson or of a week: whom to see, what to explain again, which exercise is at fault. Pure.

Numbers are of students, each counted once; no share is given, as classes are small.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from types import MappingProxyType
from uuid import UUID

from server.base import school_time
from server.board import stuck
from server.board.attempts import FAILURES, Pair, group_by_student, is_latest_failure_unexplained, is_solved
from server.board.progress import ClassProgress
from server.board.stuck import PRESENCE, StuckStudent, find_stuck_students, trailing_failures_without_progress
from server.gradebook.histories import Attempts, AttemptsByPair, cached_per_series

#: Different failures without progress at the end of the period, from which a student is to be seen; fewer are enough
#: for a student whom the lesson's page showed as stuck until its end.
MIN_FAILURES = 3
#: The same of a week, where a student is to be seen for what they worked at last; and the days of it on which the same
#: mistake makes a student to be seen at any exercise.
MIN_FAILURES_OF_WEEK, MIN_DAYS = 4, 2
MAX_TO_SEE, MAX_TO_EXPLAIN, MAX_OVERCOME = 8, 5, 8
#: Students who still make a mistake, from which it is to be explained to the class.
MIN_STILL = 3
#: An exercise is at fault where so many have tried it and a third of them fail for a reason that the course does not
#: know, or three quarters have not solved it.
MIN_TRIED = 8
UNEXPLAINED_SHARE, UNSOLVED_SHARE = 1 / 3, 3 / 4


@dataclass(frozen=True)
class StudentToSee:
    """A student who ended the period without progress: `failures` different ones; `mistake` is that of the last, whose
    grading is `grading`. `stuck`: how the lesson's page showed them at its end, at this exercise, if it did.

    `days`: those of a week on which they made it, on the school's clock; empty of a lesson.
    """

    account: UUID
    exercise: str
    failures: int
    mistake: str | None
    grading: UUID
    days: tuple[date, ...] = ()
    stuck: StuckStudent | None = None


@dataclass(frozen=True)
class MistakeToExplain:
    """A misconception that `still` have at the end of the period; `example` is the submission of one of them."""

    exercise: str
    id: str
    still: tuple[UUID, ...]
    example: UUID


@dataclass(frozen=True)
class SuspectExercise:
    """An exercise that its students can hardly be blamed for: numbers of students at the end of the period."""

    exercise: str
    tried: int
    solved: int
    unexplained: int


@dataclass(frozen=True)
class OvercomeMistake:
    """A misconception that these students had in the period and have overcome in it."""

    exercise: str
    id: str
    students: tuple[UUID, ...]


@dataclass(frozen=True)
class LessonReview:
    """The review of a period. `more_to_see` and `more_to_explain` are those for whom there is no room.

    Of the students to whom an exercise of the period is given and who have sent nothing to any: `elsewhere` worked at
    other exercises then, `idle` were there, `absent` were not seen since it began. Of `unknown`, seen after it, nobody
    knows whether they were there.
    """

    to_see: tuple[StudentToSee, ...]
    more_to_see: tuple[StudentToSee, ...]
    to_explain: tuple[MistakeToExplain, ...]
    more_to_explain: int
    at_fault: tuple[SuspectExercise, ...]
    elsewhere: tuple[UUID, ...]
    idle: tuple[UUID, ...]
    absent: tuple[UUID, ...]
    unknown: tuple[UUID, ...]
    overcome: tuple[OvercomeMistake, ...]


def build_lesson_review(
    progress: ClassProgress,
    exercises: Collection[str],
    since: datetime,
    until: datetime,
    partners: Mapping[UUID, Collection[UUID]] = MappingProxyType({}),
    *,
    is_week: bool = False,
) -> LessonReview:
    """Review what was sent to these exercises in a period. `progress` is as of `until` or later; `partners`: those who
    hand in with a student, whose attempts are the student's work too. `is_week`: the period holds several lessons."""
    period = _attempts_of_period(progress.attempts, exercises, since, until)
    senders = {account for account, _ in period}
    active = senders | {student for student, others in partners.items() if not senders.isdisjoint(others)}
    quiet = [
        student
        for student in progress.students
        if student.id not in active
        and any(progress.is_assigned_to_student(student, exercise) for exercise in exercises)
    ]
    by_student = group_by_student(progress.attempts)
    elsewhere = {
        student.id
        for student in quiet
        if any(_has_attempt_in_period(series, since, until) for series in by_student.get(student.id, {}).values())
    }
    silent = [student for student in quiet if student.id not in elsewhere]
    seen = {student.id: student.seen_at for student in silent if student.seen_at and student.seen_at >= since}
    present = {account for account, at in seen.items() if at <= until + PRESENCE}
    to_see = (
        _find_students_to_see_of_week(period, since)
        if is_week
        else _find_students_to_see(period, until, _find_stuck_at(progress, until))
    )
    to_explain = _find_mistakes_to_explain(period)
    return LessonReview(
        to_see=to_see[:MAX_TO_SEE],
        more_to_see=to_see[MAX_TO_SEE:],
        to_explain=to_explain[:MAX_TO_EXPLAIN],
        more_to_explain=len(to_explain[MAX_TO_EXPLAIN:]),
        at_fault=_find_exercises_at_fault(period, exercises),
        elsewhere=tuple(student.id for student in quiet if student.id in elsewhere),
        idle=tuple(student.id for student in silent if student.id in present),
        absent=tuple(student.id for student in silent if student.id not in seen),
        unknown=tuple(account for account in seen if account not in present),
        overcome=_find_overcome_mistakes(period)[:MAX_OVERCOME],
    )


def _has_attempt_in_period(attempts: Attempts, since: datetime, until: datetime) -> bool:
    return any(since <= attempt.sent_at <= until for attempt in attempts)


def _attempts_of_period(
    attempts: AttemptsByPair, exercises: Collection[str], since: datetime, until: datetime
) -> Mapping[Pair, Attempts]:
    """Return the attempts until the end of the period, of the pairs with some in it."""
    wanted = frozenset(exercises)
    period: dict[Pair, Attempts] = {}
    for pair, all_series in attempts.items():
        if pair[1] not in wanted or all_series[-1].sent_at < since:
            continue
        series = _attempts_until(all_series, until)
        if series and series[-1].sent_at >= since:
            period[pair] = series
    return period


def _attempts_until(attempts: Attempts, until: datetime) -> Attempts:
    if attempts[-1].sent_at <= until:
        return attempts
    return tuple(attempt for attempt in attempts if attempt.sent_at <= until)


def _find_stuck_at(progress: ClassProgress, until: datetime) -> Mapping[UUID, StuckStudent]:
    """Return who was stuck at the end of a lesson; who was seen later is taken to have been there."""
    cut = {pair: _attempts_until(series, until) for pair, series in progress.attempts.items()}
    before = {pair: series for pair, series in cut.items() if series}
    seen_at = {student.id: student.seen_at for student in progress.students}
    return {row.account: row for row in find_stuck_students(before, seen_at, until)}


def _find_students_to_see(
    period: Mapping[Pair, Attempts], until: datetime, stuck_at_end: Mapping[UUID, StuckStudent]
) -> tuple[StudentToSee, ...]:
    """Return the students without progress, each at the exercise where they failed most."""
    last_work = {account: max(own.values(), key=_last_sent_at) for account, own in group_by_student(period).items()}
    worst: dict[UUID, StudentToSee] = {}
    for (account, exercise), series in period.items():
        run = () if is_solved(series) else trailing_failures_without_progress(series)
        failures, known = len({attempt.digest for attempt in run}), worst.get(account)
        ended_stuck = failures >= stuck.MIN_FAILURES and series is last_work[account] and _has_lasted_long(run, until)
        row = stuck_at_end.get(account)
        shown = row if run and row is not None and row.exercise == exercise else None
        is_to_see = failures >= MIN_FAILURES or ended_stuck or shown is not None
        if is_to_see and (known is None or failures > known.failures):
            last = series[-1]
            worst[account] = StudentToSee(account, exercise, failures, last.diagnosis, last.grading_id, stuck=shown)
    return tuple(sorted(worst.values(), key=lambda row: (-row.failures, str(row.account))))


def _last_sent_at(series: Attempts) -> datetime:
    return series[-1].sent_at


def _has_lasted_long(run: Attempts, until: datetime) -> bool:
    """Whether failures without progress have lasted, at the end of a lesson, long enough for a student to be stuck."""
    return until - run[0].sent_at >= stuck.MIN_DURATION and until - run[-1].sent_at <= stuck.MAX_SILENCE


def _find_students_to_see_of_week(period: Mapping[Pair, Attempts], since: datetime) -> tuple[StudentToSee, ...]:
    """Return the students who make the same mistake on several days, and those who ended the week without progress at
    what they worked at last; each at the exercise of most days, then of most failures."""
    worst: dict[UUID, StudentToSee] = {}
    for account, own in group_by_student(period).items():
        ended_at = max(series[-1].sent_at for series in own.values())
        for exercise, series in own.items():
            last = series[-1]
            if is_solved(series) or last.outcome not in FAILURES:
                continue
            same = [attempt for attempt in series if attempt.sent_at >= since and attempt.diagnosis == last.diagnosis]
            days = {school_time.to_local(attempt.sent_at).date() for attempt in same if attempt.diagnosis is not None}
            failures = len({attempt.digest for attempt in trailing_failures_without_progress(series, timedelta.max)})
            is_stuck = failures >= MIN_FAILURES_OF_WEEK and last.sent_at == ended_at
            if is_stuck or len(days) >= MIN_DAYS:
                row = StudentToSee(account, exercise, failures, last.diagnosis, last.grading_id, tuple(sorted(days)))
                worst[account] = min(row, worst.get(account, row), key=_urgency_sort_key)
    return tuple(sorted(worst.values(), key=_urgency_sort_key))


def _urgency_sort_key(row: StudentToSee) -> tuple[int, int, str]:
    """Return what orders the students to see in a week, the most urgent first."""
    return -len(row.days) if len(row.days) >= MIN_DAYS else 0, -row.failures, str(row.account)


def list_student_ids_to_see(
    progress: ClassProgress, exercises: Collection[str], since: datetime, until: datetime
) -> frozenset[UUID]:
    """Return all students whom the review of this lesson says to see."""
    period = _attempts_of_period(progress.attempts, exercises, since, until)
    return frozenset(row.account for row in _find_students_to_see(period, until, _find_stuck_at(progress, until)))


def _find_mistakes_to_explain(period: Mapping[Pair, Attempts]) -> tuple[MistakeToExplain, ...]:
    still: dict[tuple[str, str], list[Attempts]] = defaultdict(list)
    for (_, exercise), series in period.items():
        diagnosis = series[-1].diagnosis
        if diagnosis is not None:
            still[exercise, diagnosis].append(series)
    rows = [
        MistakeToExplain(*key, tuple(series[-1].account_id for series in own), own[0][-1].id)
        for key, own in still.items()
        if len(own) >= MIN_STILL
    ]
    return tuple(sorted(rows, key=lambda row: (-len(row.still), row.exercise, row.id)))


def _find_exercises_at_fault(
    period: Mapping[Pair, Attempts], exercises: Collection[str]
) -> tuple[SuspectExercise, ...]:
    rows = []
    by_exercise: dict[str, list[Attempts]] = defaultdict(list)
    for (_, exercise), series in period.items():
        by_exercise[exercise].append(series)
    for exercise in exercises:
        own = by_exercise[exercise]
        failing = [series for series in own if not is_solved(series)]
        solved, unexplained = len(own) - len(failing), sum(map(is_latest_failure_unexplained, failing))
        is_at_fault = unexplained >= UNEXPLAINED_SHARE * len(own) or len(own) - solved >= UNSOLVED_SHARE * len(own)
        if len(own) >= MIN_TRIED and is_at_fault:
            rows.append(SuspectExercise(exercise, len(own), solved, unexplained))
    return tuple(rows)


def _find_overcome_mistakes(period: Mapping[Pair, Attempts]) -> tuple[OvercomeMistake, ...]:
    """Return the misconceptions that an attempt showed, and the latest attempt, a better one, shows no more."""
    overcame: dict[tuple[str, str], list[UUID]] = defaultdict(list)
    for (account, exercise), series in period.items():
        for misconception in _misconceptions_overcome_in(series):
            overcame[exercise, misconception].append(account)
    rows: Sequence[OvercomeMistake] = [OvercomeMistake(*key, tuple(own)) for key, own in overcame.items()]
    return tuple(sorted(rows, key=lambda row: (-len(row.students), row.exercise, row.id)))


@cached_per_series
def _misconceptions_overcome_in(attempts: Attempts) -> Sequence[str]:
    last, first_with = attempts[-1], {attempt.diagnosis: attempt for attempt in reversed(attempts)}
    return [
        misconception
        for misconception, first in first_with.items()
        if misconception is not None and last.diagnosis != misconception and last.score > first.score
    ]
