"""The state of a lesson at one time, from the attempts of its class: pure."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from server.board.attempts import Pair, first_success_time, is_solved
from server.board.progress import ClassProgress
from server.board.schemas import FEWEST_TO_PROJECT
from server.board.stuck import PRESENCE, LessonExercises, StuckStudent
from server.gradebook.histories import Attempts, AttemptsByPair, cached_per_series
from server.lesson.models import LiveLesson
from server.lesson.repository import StudentVisit

RECENT_MISTAKES = timedelta(minutes=15)
MAX_MISTAKES, MAX_HELPED = 3, 5
#: How long a student who was seen stands below those who were not, unless another exercise is in their way.
VISIT_LASTS = timedelta(minutes=10)


@dataclass(frozen=True)
class LessonMistake:
    """A misconception of a lesson. `still`: the students whose latest attempt shows it, whenever it was sent, the
    earliest first; `made` counts those too who have made it since the lesson began, and overcome it.

    `latest_at`: when an attempt showed it last.
    """

    exercise: str
    id: str
    still: tuple[UUID, ...]
    made: int
    latest_at: datetime

    @property
    def has_enough_students_to_project(self) -> bool:
        return self.made >= FEWEST_TO_PROJECT


@dataclass(frozen=True)
class ExerciseCount:
    """Numbers of the students to whom an exercise of the day is given and who are not absent: of those who have
    solved it, of those who have tried it without success, and of all."""

    exercise: str
    solved: int
    trying: int
    students: int


@dataclass(frozen=True)
class LessonState:
    """A lesson at one time. `stuck`: the longest first, then those who were `just_seen`; `visits`: to those of them
    who were seen at the exercise at which they are stuck.

    `mistakes`: those that most students still make, then most of the stuck; `more_mistakes`: the number of those for
    which there is no room; `overcome`: those of the last minutes that
    nobody makes any more, where there is room. `finished` have solved all exercises of the day, the latest last;
    `absent` were not there since it began; `working` are all others.
    `helpers`: by stuck student, who has finished and could help them.
    """

    stuck: tuple[StuckStudent, ...]
    just_seen: frozenset[UUID]
    visits: Mapping[UUID, StudentVisit]
    mistakes: tuple[LessonMistake, ...]
    more_mistakes: int
    overcome: tuple[LessonMistake, ...]
    finished: tuple[UUID, ...]
    absent: tuple[UUID, ...]
    working: tuple[UUID, ...]
    exercises: tuple[ExerciseCount, ...]
    helpers: Mapping[UUID, UUID]


def build_lesson_state(progress: ClassProgress, lesson: LiveLesson, visits: Mapping[UUID, StudentVisit]) -> LessonState:
    expected = LessonExercises(tuple(lesson.exercises), lesson.started_at)
    longest_first = progress.find_stuck_students(expected)
    seen = {
        row.account: visits[row.account] for row in longest_first if _was_visited_there(row, visits.get(row.account))
    }
    just_seen = frozenset(account for account, visit in seen.items() if progress.now - visit.visited_at < VISIT_LASTS)
    stuck = tuple(sorted(longest_first, key=lambda row: row.account in just_seen))
    wanted = frozenset(lesson.exercises)
    today = {pair: series for pair, series in progress.attempts.items() if pair[1] in wanted}
    solved = _solved_times(today)
    finished = _find_finished_students(progress, solved, lesson.exercises)
    are_stuck = {row.account for row in stuck}
    mistakes = sorted(
        find_lesson_mistakes(progress, expected),
        key=lambda row: (-len(row.still), -len(are_stuck.intersection(row.still))),
    )
    made_still = tuple(row for row in mistakes if row.still)
    current = made_still[:MAX_MISTAKES]
    absent = _find_absent_students(progress, lesson.started_at)
    listed = {*are_stuck, *finished, *absent}
    return LessonState(
        stuck=stuck,
        just_seen=just_seen,
        visits=seen,
        mistakes=current,
        more_mistakes=len(made_still) - len(current),
        overcome=tuple(row for row in mistakes if _is_just_overcome(row, progress.now))[: MAX_MISTAKES - len(current)],
        finished=finished,
        absent=absent,
        working=tuple(student.id for student in progress.students if student.id not in listed),
        exercises=_count_by_exercise(progress, lesson.exercises, solved, absent),
        helpers=pair_helpers(progress, [row for row in stuck if row.account not in just_seen], finished, MAX_HELPED),
    )


def _was_visited_there(row: StuckStudent, visit: StudentVisit | None) -> bool:
    """Whether a student was seen at the exercise at which they are stuck."""
    return visit is not None and visit.exercise == row.exercise


def _is_just_overcome(row: LessonMistake, now: datetime) -> bool:
    return not row.still and row.latest_at >= now - RECENT_MISTAKES


def find_lesson_mistakes(progress: ClassProgress, expected: LessonExercises) -> tuple[LessonMistake, ...]:
    """Return the misconceptions of a lesson: those at its exercises, and those of attempts since it began at others.

    The first are those that most students still make, however long ago they sent their last attempt: a student who
    falls silent has not overcome a mistake.
    """
    recent = {exercise for (_, exercise), own in progress.attempts.items() if own[-1].sent_at >= expected.started_at}
    worked = recent.union(expected.exercises)
    made: dict[tuple[str, str], list[Attempts]] = defaultdict(list)
    for (_, exercise), attempts in progress.attempts.items():
        if exercise in worked:
            for misconception in _latest_time_by_misconception(attempts):
                made[exercise, misconception].append(attempts)
    rows = (_build_lesson_mistake(*key, own, expected.started_at) for key, own in made.items())
    shown = [row for row in rows if row.exercise in expected.exercises or row.latest_at >= expected.started_at]
    order = {exercise: index for index, exercise in enumerate(progress.scope.exercises)}
    return tuple(sorted(shown, key=lambda row: (-len(row.still), -row.made, order[row.exercise], row.id)))


@cached_per_series
def _latest_time_by_misconception(attempts: Attempts) -> Mapping[str, datetime]:
    """Return when each misconception was shown last."""
    return {attempt.diagnosis: attempt.sent_at for attempt in attempts if attempt.diagnosis is not None}


def _build_lesson_mistake(
    exercise: str, misconception: str, made_by: Sequence[Attempts], since: datetime
) -> LessonMistake:
    made = count_students_with_misconception(made_by, misconception, since)
    still = sorted((own[-1].sent_at, own[-1].account_id) for own in made_by if own[-1].diagnosis == misconception)
    latest_at = max(_latest_time_by_misconception(own)[misconception] for own in made_by)
    return LessonMistake(exercise, misconception, tuple(account for _, account in still), made, latest_at)


def count_students_with_misconception(made_by: Iterable[Attempts], misconception: str, since: datetime) -> int:
    """Count the students who have made a mistake since a lesson began, or whose latest attempt shows it."""
    return sum(
        own[-1].diagnosis == misconception or _latest_time_by_misconception(own)[misconception] >= since
        for own in made_by
    )


def _solved_times(attempts: AttemptsByPair) -> Mapping[Pair, datetime]:
    """Return when each student first solved each exercise that they have solved."""
    times = {pair: first_success_time(series) for pair, series in attempts.items()}
    return {pair: time for pair, time in times.items() if time is not None}


def _find_finished_students(
    progress: ClassProgress, solved: Mapping[Pair, datetime], exercises: Sequence[str]
) -> tuple[UUID, ...]:
    """Return who has solved all of these exercises that are theirs, the latest last."""
    times = []
    for student in progress.students:
        own = [solved.get((student.id, name)) for name in exercises if progress.is_assigned_to_student(student, name)]
        done = [time for time in own if time is not None]
        if own and len(done) == len(own):
            times.append((max(done), student.id))
    return tuple(account for _, account in sorted(times))


def pair_helpers(
    progress: ClassProgress, stuck: Sequence[StuckStudent], finished: Sequence[UUID], limit: int
) -> Mapping[UUID, UUID]:
    """Give each of the first stuck students a helper who has finished: at best one who helps nobody else yet, then one
    who overcame the same mistake."""
    helpless = {row.account for row in stuck}
    free, pairs = [account for account in finished if account not in helpless], dict[UUID, UUID]()
    helped: Counter[UUID] = Counter()
    for row in stuck[:limit]:
        attempts = progress.attempts.get((row.account, row.exercise), ())
        mistake = attempts[-1].diagnosis if attempts else None
        able = [account for account in free if _has_solved(progress, account, row.exercise)]
        overcame = {
            account for account in able if mistake and _has_made_mistake(progress, account, row.exercise, mistake)
        }
        if able:
            helper = min(able, key=lambda account: (helped[account], account not in overcame))
            pairs[row.account] = helper
            helped[helper] += 1
    return pairs


def _has_solved(progress: ClassProgress, account: UUID, exercise: str) -> bool:
    return is_solved(progress.attempts.get((account, exercise), ()))


def _has_made_mistake(progress: ClassProgress, account: UUID, exercise: str, misconception: str) -> bool:
    return any(attempt.diagnosis == misconception for attempt in progress.attempts.get((account, exercise), ()))


def _find_absent_students(progress: ClassProgress, since: datetime) -> tuple[UUID, ...]:
    """Return who was not seen since a time, presence being recorded every few minutes only."""
    sent = {account for (account, _), series in progress.attempts.items() if series[-1].sent_at >= since}
    begun = min(since, progress.now - PRESENCE)
    return tuple(
        student.id
        for student in progress.students
        if student.id not in sent and (student.seen_at is None or student.seen_at < begun)
    )


def _count_by_exercise(
    progress: ClassProgress, exercises: Sequence[str], solved: Mapping[Pair, datetime], absent: Collection[UUID]
) -> tuple[ExerciseCount, ...]:
    away, counts = frozenset(absent), []
    present = [student for student in progress.students if student.id not in away]
    for name in exercises:
        pairs = [(student.id, name) for student in present if progress.is_assigned_to_student(student, name)]
        done = sum(pair in solved for pair in pairs)
        counts.append(ExerciseCount(name, done, sum(pair in progress.attempts for pair in pairs) - done, len(pairs)))
    return tuple(counts)
