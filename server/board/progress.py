"""The attempts of a class at the exercises that count, and statistics of them: pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from uuid import UUID

from server.board import insights
from server.board.attempts import MisconceptionEpisode, Pair, find_misconception_episodes, is_latest_failure_unexplained
from server.board.catalogue import find_misconception
from server.board.repository import BoardScope
from server.board.schemas import BoardStudent, ExerciseStats, HintStats, ImprovementStats, MisconceptionStats
from server.board.stuck import LessonExercises, StuckStudent, find_stuck_students, median_or_none
from server.course import Course
from server.gradebook.histories import AttemptsByPair, GradedAttempt, Revisions, cached_totals
from server.gradebook.standings import StandingTotals


@dataclass(frozen=True, eq=False)
class ClassProgress:
    """The attempts of the present students of a class, as of `now`."""

    course: Course
    scope: BoardScope
    now: datetime
    students: tuple[BoardStudent, ...]
    attempts: AttemptsByPair
    revisions: Revisions

    @property
    def version(self) -> Hashable:
        """Equal versions mean equal progress, but for what changes with time alone: `stuck_pairs`, and recent
        activity."""
        students = tuple((student.id, student.name, student.groups) for student in self.students)
        return self.course, self.scope, students, frozenset(self.revisions.items())

    @cached_property
    def _groups_by_exercise(self) -> Mapping[str, frozenset[str]]:
        return dict(self.scope.groups_by_exercise)

    def is_assigned_to_student(self, student: BoardStudent, exercise: str) -> bool:
        """Whether an exercise that counts is given to the class, or to a group of the student."""
        groups = self._groups_by_exercise.get(exercise) if self.scope.groups_by_exercise else None
        return groups is None or not groups.isdisjoint(student.groups)

    def find_exercises_of_other_groups(self, student: BoardStudent) -> frozenset[str]:
        """Return the exercises that count, and are given to other groups only."""
        if not self.scope.groups_by_exercise:
            return frozenset()
        return frozenset(name for name in self._groups_by_exercise if not self.is_assigned_to_student(student, name))

    @cached_property
    def totals_by_pair(self) -> Mapping[Pair, StandingTotals]:
        return {pair: cached_totals(attempts) for pair, attempts in self.attempts.items()}

    @cached_property
    def stuck_pairs(self) -> frozenset[Pair]:
        return frozenset((row.account, row.exercise) for row in self.find_stuck_students())

    def find_stuck_students(self, expected: LessonExercises | None = None) -> tuple[StuckStudent, ...]:
        """Return the students who are stuck, the longest first; `expected`: in a lesson with these exercises."""
        seen_at = {student.id: student.seen_at for student in self.students}
        return find_stuck_students(self.attempts, seen_at, self.now, expected)

    @cached_property
    def sorted_send_times(self) -> Sequence[datetime]:
        """When attempts were sent, the oldest first."""
        return sorted(attempt.sent_at for attempts in self.attempts.values() for attempt in attempts)

    @cached_property
    def unexplained_latest_attempts(self) -> Sequence[GradedAttempt]:
        """The latest attempts that answer wrongly without a known misconception, by exercise and time."""
        latest = [attempts[-1] for attempts in self.attempts.values() if is_latest_failure_unexplained(attempts)]
        return sorted(latest, key=lambda attempt: (attempt.exercise, attempt.sent_at))

    @cached_property
    def sorted_misconception_stats(self) -> tuple[MisconceptionStats, ...]:
        """By how many students still have it, then by how many ever had it, then in the order of the course."""
        episodes: dict[tuple[str, str], list[MisconceptionEpisode]] = defaultdict(list)
        for (_, exercise), attempts in self.attempts.items():
            for misconception, episode in find_misconception_episodes(attempts):
                episodes[exercise, misconception].append(episode)
        order = {name: index for index, name in enumerate(self.course.exercises)}

        def sort_key(stats: MisconceptionStats) -> tuple[int, int, int, str]:
            return -stats.now, -stats.ever, order.get(stats.exercise, len(order)), stats.id

        all_stats = [_build_misconception_stats(self.course, *key, own) for key, own in episodes.items()]
        return tuple(sorted(all_stats, key=sort_key))

    @property
    def exercise_stats(self) -> tuple[ExerciseStats, ...]:
        return insights.compute_exercise_stats(self.scope.exercises, self.attempts)

    @property
    def improvements(self) -> tuple[ImprovementStats, ...]:
        return insights.improvements_after_misconceptions(self.sorted_misconception_stats)

    @property
    def hint_stats(self) -> tuple[HintStats, ...]:
        return insights.compute_hint_stats(self.course, self.scope.exercises, self.attempts)

    def students_who_had(self, exercise: str, misconception: str) -> frozenset[UUID]:
        return frozenset(
            account_id
            for (account_id, name), attempts in self.attempts.items()
            if name == exercise and any(attempt.diagnosis == misconception for attempt in attempts)
        )


def _build_misconception_stats(
    course: Course, exercise: str, misconception: str, episodes: Sequence[MisconceptionEpisode]
) -> MisconceptionStats:
    still = sorted((episode.account for episode in episodes if episode.attempts is None), key=str)
    overcome = [episode.attempts for episode in episodes if episode.attempts is not None]
    return MisconceptionStats(
        exercise=exercise,
        id=misconception,
        title=find_misconception(course, exercise, misconception).diagnosis.title,
        now=len(still),
        ever=len(episodes),
        overcome=len(overcome),
        median_attempts=median_or_none(overcome),
        students=tuple(still),
        followed=sum(episode.followed for episode in episodes),
        improved=sum(episode.improved for episode in episodes),
    )
