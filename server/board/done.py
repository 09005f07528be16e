"""What the students of a class have done, and what it comes to whenever it is looked at: pure, each thing once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from uuid import UUID

from graders.core.contract.verdict import MAX_POINTS
from server.board import insights
from server.board.names import named
from server.board.repository import Sent
from server.board.schemas import ExerciseStats, HintStats, ImprovementStats, MisconceptionStats, ProgressCell, Shown
from server.board.states import Latest, latest_of, median_of, state_of
from server.board.trails import MisconceptionEpisode, Pair, Trails, unexplained
from server.course import Course
from server.gradebook.standings import StandingTotals
from server.marks.schemas import ActiveOverride


@dataclass(frozen=True)
class Looked:
    """Who was stuck, and what teachers had set, when it was looked at; what was shown of it then."""

    stuck: frozenset[Pair]
    marks: Mapping[Pair, ActiveOverride]
    shown: Shown


@dataclass(eq=False)
class Done:
    """The `students` of now, in the `exercises` that count there. `made` stands for all of it where something is kept
    of it elsewhere; `looked`: the last look."""

    course: Course
    students: Sequence[UUID]
    exercises: Sequence[str]
    trails: Trails
    made: object = field(default_factory=object)
    looked: Looked | None = None

    @cached_property
    def standings(self) -> Mapping[Pair, StandingTotals]:
        return {pair: trail.sums for pair, trail in self.trails.items()}

    @cached_property
    def points(self) -> Mapping[Pair, float]:
        """Of the best attempts, out of 20."""
        return {pair: round(MAX_POINTS * sums.best_score, 4) for pair, sums in self.standings.items()}

    @cached_property
    def cells(self) -> Mapping[Pair, ProgressCell]:
        """As they are if nobody is stuck, and no teacher has set a mark."""
        pairs = ((student, exercise) for student in self.students for exercise in self.exercises)
        return {pair: cell_of(pair, self.standings.get(pair), self.points.get(pair)) for pair in pairs}

    @cached_property
    def latest(self) -> Mapping[UUID, Latest]:
        return latest_of(self.standings)

    @cached_property
    def times(self) -> Sequence[datetime]:
        """When something was sent, the oldest first."""
        return sorted(one.sent_at for trail in self.trails.values() for one in trail)

    @cached_property
    def unexplained(self) -> Sequence[Sent]:
        """The latest attempts that answer wrongly and have no name, by exercise and time."""
        found = [trail[-1] for trail in self.trails.values() if unexplained(trail)]
        return sorted(found, key=lambda one: (one.exercise, one.sent_at))

    @cached_property
    def misconceptions(self) -> tuple[MisconceptionStats, ...]:
        """Those that most students still have come first; of these, what most ever had; then in the course's order."""
        had: dict[tuple[str, str], list[MisconceptionEpisode]] = defaultdict(list)
        for (_, exercise), trail in self.trails.items():
            for name, one in trail.had:
                had[exercise, name].append(one)
        order = {name: place for place, name in enumerate(self.course.exercises)}
        found = [_misconception(self.course, exercise, name, rows) for (exercise, name), rows in had.items()]
        return tuple(sorted(found, key=lambda one: (-one.now, -one.ever, order.get(one.exercise, len(order)), one.id)))

    @cached_property
    def items(self) -> tuple[ExerciseStats, ...]:
        return insights.items(self.exercises, self.standings, self.trails)

    @cached_property
    def helped(self) -> tuple[ImprovementStats, ...]:
        return insights.helped(self.misconceptions)

    @cached_property
    def hints(self) -> tuple[HintStats, ...]:
        return insights.hints(self.course, self.exercises, self.trails)

    def ever(self, exercise: str, misconception: str) -> frozenset[UUID]:
        """The students who ever had a misconception."""
        there = ((student, trail) for (student, name), trail in self.trails.items() if name == exercise)
        return frozenset(student for student, trail in there if misconception in dict(trail.had))


def cell_of(pair: Pair, sums: StandingTotals | None, points: float | None, *, stuck: bool = False) -> ProgressCell:
    return ProgressCell(
        student=pair[0],
        exercise=pair[1],
        points=points,
        attempts=sums.attempts if sums else 0,
        state=state_of(sums, stuck=stuck),
        misconception=sums.last_diagnosis if sums else None,
    )


def _misconception(
    course: Course, exercise: str, name: str, rows: Sequence[MisconceptionEpisode]
) -> MisconceptionStats:
    still = sorted((one.account for one in rows if one.attempts is None), key=str)
    overcome = [one.attempts for one in rows if one.attempts is not None]
    return MisconceptionStats(
        exercise=exercise,
        id=name,
        title=named(course, exercise, name).diagnosis.title,
        now=len(still),
        ever=len(rows),
        overcome=len(overcome),
        median_attempts=median_of(overcome),
        students=tuple(still),
        followed=sum(one.followed for one in rows),
        improved=sum(one.improved for one in rows),
    )
