"""The marks of a class, of a student, and of one exercise. Points are out of 20."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime
from functools import cached_property
from uuid import UUID

from server.assignments.counting import AttemptMark
from server.assignments.models import Assignment, Mode, WeightedExercise
from server.assignments.rules import Rules
from server.classes.models import SchoolClass
from server.classes.schemas import StudentRecord
from server.marks.means import (
    FULL_POINTS,
    MeanTerm,
    format_number,
    mean,
    mean_of_terms,
    median,
    weighted_mean,
)
from server.marks.states import (
    DEFAULT_RULES,
    LEFT_OUT,
    UNMARKED_STATES,
    WHOLE_STATES,
    Counting,
    DecidedState,
    MarkingRules,
    MarkState,
    TypedState,
)

StudentExercise = tuple[UUID, str]
#: A student, an exercise, and the assignment in which alone an override holds; None: all that ask the exercise.
OverrideKey = tuple[UUID, str, UUID | None]


@dataclass(frozen=True)
class ActiveOverride:
    """An override in force. `by`: the name of its author, empty once the account is gone; `assignment_id`: its scope,
    None for everywhere."""

    points: float | None
    excused: bool
    reason: str
    by: str
    at: datetime
    based_on: frozenset[str | None]
    assignment_id: UUID | None = None


@dataclass(frozen=True)
class ActiveDecision:
    """A decision in force about a student's assignment. `by`: its author's name, empty once the account is gone."""

    id: UUID
    state: DecidedState
    reason: str
    by: str
    at: datetime


@dataclass(frozen=True)
class EffectivePoints:
    """A student's points at an exercise: the override's, else the automatic ones; None where excused or not sent."""

    automatic: float | None
    override: ActiveOverride | None = None

    @property
    def excused(self) -> bool:
        return self.override is not None and self.override.excused

    @property
    def points(self) -> float | None:
        return self.automatic if self.override is None else self.override.points


@dataclass(frozen=True)
class ExerciseMark:
    """A student's mark at one exercise of an assignment.

    `grading`: the id of the grading that makes the automatic mark, of the attempt sent at `sent_at`; `attempts` counts
    those within the dates, `sent` all.
    """

    exercise: str
    weight: float
    counted: AttemptMark | None
    grading: str | None
    sent_at: datetime | None
    attempts: int
    override: ActiveOverride | None
    sent: int = 0

    @property
    def effective(self) -> EffectivePoints:
        return EffectivePoints(None if self.counted is None else self.counted.points, self.override)

    @property
    def points(self) -> float | None:
        if self.override is not None:
            return self.effective.points
        return None if self.counted is None else self.counted.points

    @property
    def excused(self) -> bool:
        return self.override is not None and self.effective.excused

    @property
    def is_refused_as_late(self) -> bool:
        """Whether there are attempts, and all came too late to count."""
        return self.sent > 0 and self.counted is None

    @property
    def stale(self) -> bool:
        """Whether another grading makes the automatic mark than when the override was set."""
        return self.override is not None and self.grading not in self.override.based_on

    @property
    def days_late(self) -> int:
        """Days that the counting attempt is late; 0 where an override is in force."""
        return 0 if self.counted is None or self.override is not None else self.counted.days_late

    def state_within(self, assignment_state: MarkState) -> MarkState:
        """Return the state of this exercise in an assignment of that state."""
        if assignment_state in WHOLE_STATES:
            return assignment_state
        if self.excused:
            return MarkState.excused
        if assignment_state in {MarkState.upcoming, MarkState.open}:
            return assignment_state
        if self.points is not None:
            return MarkState.done
        return MarkState.late_refused if self.is_refused_as_late else MarkState.not_handed_in


@dataclass(frozen=True)
class AssignmentMark:
    """A student's mark at an assignment. `ended`: it is a test in which the student can send nothing more.

    Once the assignment is over, an exercise without an attempt counts as the class's rules say; before, only those with
    an attempt count. There may be attempts before the opening. A decision takes precedence over all. `partners` hand in
    with the student today.
    """

    rules: Rules
    state: MarkState
    exercises: tuple[ExerciseMark, ...]
    ended: bool = False
    marking: MarkingRules = DEFAULT_RULES
    decision: ActiveDecision | None = None
    partners: tuple[str, ...] = ()

    @cached_property
    def points(self) -> float | None:
        """The weighted mean of its exercises, excused ones left out; None where nothing counts."""
        if self.decision is not None and self.decision.state is DecidedState.zero:
            return 0.0
        if self.state in UNMARKED_STATES:
            return self.marking.points_without_mark(self.state)
        if self.state in LEFT_OUT:
            return None
        over = self.state is MarkState.done and not self.has_no_end
        blanks_count = over and self.marking.unanswered is Counting.zero
        counted = [
            exercise
            for exercise in self.exercises
            if not exercise.excused and (blanks_count or exercise.points is not None)
        ]
        points = weighted_mean(
            [(0.0 if exercise.points is None else exercise.points, exercise.weight) for exercise in counted]
        )
        return 0.0 if points is None and over else points

    @property
    def has_no_end(self) -> bool:
        """Whether it has neither a due or closing date nor another end."""
        return not self.ended and self.rules.latest_counting_time is None and self.rules.due_at is None

    @property
    def points_in_average(self) -> float | None:
        """The points that count in the student's average: None while it is not over, or by the class's rules."""
        return None if self.state in {MarkState.open, MarkState.upcoming} else self.points

    @cached_property
    def days_late(self) -> int:
        return max((exercise.days_late for exercise in self.exercises), default=0)

    @cached_property
    def has_override_or_decision(self) -> bool:
        return self.decision is not None or any(exercise.override is not None for exercise in self.exercises)

    @cached_property
    def stale(self) -> bool:
        """Whether an override is stale, or something that would count was sent since the decision."""
        if self.decision is None:
            return any(exercise.stale for exercise in self.exercises)
        decided_at = self.decision.at
        return any(mark.sent_at is not None and mark.sent_at > decided_at for mark in self.exercises)


@dataclass(frozen=True)
class ColumnRecord:
    """A manual column as it is stored; see `models.ManualColumn`."""

    id: UUID
    title: str
    out_of: float
    taken_on: date | None
    weight: float
    bonus: bool
    published_at: datetime | None
    version: int

    @property
    def is_published(self) -> bool:
        return self.published_at is not None

    @property
    def full_title(self) -> str:
        """The title with its scale: « Oral /10 »; of a bonus « Participation (bonus) »."""
        return f"{self.title} (bonus)" if self.bonus else f"{self.title} /{format_number(self.out_of)}"


@dataclass(frozen=True)
class TypedMark:
    """What a teacher typed for a student in a column: points out of the column's, a state, or neither."""

    points: float | None = None
    state: TypedState | None = None
    comment: str = ""
    version: int = 0


NEVER_TYPED = TypedMark()


@dataclass(frozen=True)
class ColumnMark:
    """A student's mark in a manual column, counted by the rules of the class."""

    column: ColumnRecord
    typed: TypedMark
    marking: MarkingRules

    @property
    def state(self) -> MarkState:
        if self.typed.state is not None:
            return MarkState(self.typed.state)
        return MarkState.upcoming if self.typed.points is None else MarkState.done

    @property
    def points_in_average(self) -> float | None:
        """The points that count, out of 20, of a bonus as they are; None where nothing counts."""
        if self.typed.points is None:
            return self.marking.points_without_mark(self.state)
        return self.typed.points if self.column.bonus else self.typed.points * FULL_POINTS / self.column.out_of


@dataclass(frozen=True)
class StudentMarks:
    """A student's marks: at the gradebook's assignments, in order, with their weights, and in its columns."""

    member: StudentRecord
    marks: tuple[AssignmentMark, ...]
    weights: tuple[float, ...]
    columns: tuple[ColumnMark, ...] = ()

    @cached_property
    def average(self) -> float | None:
        """The mean of what counts: the assignments that are over and the columns, by their weights, and bonuses."""
        assignments = [
            MeanTerm(mark.points_in_average, weight) for mark, weight in zip(self.marks, self.weights, strict=True)
        ]
        columns = [MeanTerm(mark.points_in_average, mark.column.weight, mark.column.bonus) for mark in self.columns]
        return mean_of_terms([*assignments, *columns])


@dataclass(frozen=True)
class MarkStatistics:
    """Number, mean and median of the marks of those who sent something."""

    count: int
    mean: float | None
    median: float | None


def compute_statistics(points: Sequence[float]) -> MarkStatistics:
    return MarkStatistics(len(points), mean(points), median(points))


@dataclass(frozen=True)
class Gradebook:
    """The marks of a class at one moment, its students sorted as a list of names."""

    school_class: SchoolClass
    at: datetime
    assignments: tuple[Assignment, ...]
    rows: tuple[StudentMarks, ...]
    titles: Mapping[str, str] = field(default_factory=dict)
    exercises: Mapping[UUID, tuple[WeightedExercise, ...]] = field(default_factory=dict)
    columns: tuple[ColumnRecord, ...] = ()
    marking: MarkingRules = DEFAULT_RULES

    def exercise_title(self, exercise: str) -> str:
        """Return the title of an exercise, or its id once it has left the course."""
        return self.titles.get(exercise, exercise)

    def assignment_statistics(self, index: int) -> MarkStatistics:
        """Summarise the marks at one assignment that have points of their own: neither states nor rules count."""
        marks = [row.marks[index] for row in self.rows]
        points_sent = [mark.points for mark in marks if mark.state in {MarkState.done, MarkState.open}]
        return compute_statistics([points for points in points_sent if points is not None])

    def column_statistics(self, index: int) -> MarkStatistics:
        """Summarise the points typed in one column, out of its own scale."""
        typed = [row.columns[index].typed.points for row in self.rows]
        return compute_statistics([points for points in typed if points is not None])

    @cached_property
    def average_statistics(self) -> MarkStatistics:
        return compute_statistics([row.average for row in self.rows if row.average is not None])


def is_test_withheld(assignment: Assignment, now: datetime) -> bool:
    """Whether it is a test whose results are not released yet."""
    released = assignment.released_at
    return assignment.mode == Mode.test and (released is None or released > now)
