"""The marks of a class, of a student, and of one exercise. Points are out of 20."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from functools import cached_property
from uuid import UUID

from server.assignments.counting import AttemptMark
from server.assignments.models import Assignment, Mode, WeightedExercise
from server.assignments.rules import Rules
from server.classes.models import SchoolClass
from server.classes.schemas import StudentRecord
from server.marks.means import mean, median, weighted_mean

StudentExercise = tuple[UUID, str]


@dataclass(frozen=True)
class ActiveOverride:
    """An override in force. `by`: the name of its author, empty once the account is gone."""

    points: float | None
    excused: bool
    reason: str
    by: str
    at: datetime
    based_on: frozenset[str | None]


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
    those within the dates.
    """

    exercise: str
    weight: float
    counted: AttemptMark | None
    grading: str | None
    sent_at: datetime | None
    attempts: int
    override: ActiveOverride | None

    @cached_property
    def effective(self) -> EffectivePoints:
        return EffectivePoints(None if self.counted is None else self.counted.points, self.override)

    @cached_property
    def points(self) -> float | None:
        return self.effective.points

    @cached_property
    def excused(self) -> bool:
        return self.effective.excused

    @property
    def stale(self) -> bool:
        """Whether another grading makes the automatic mark than when the override was set."""
        return self.override is not None and self.grading not in self.override.based_on

    @property
    def days_late(self) -> int:
        """Days that the counting attempt is late; 0 where an override is in force."""
        return 0 if self.counted is None or self.override is not None else self.counted.days_late


class MarkState(StrEnum):
    """`upcoming`: not open yet; `open`: work may still be sent; `absent`: it is over and nothing was sent."""

    upcoming = "upcoming"
    open = "open"
    done = "done"
    absent = "absent"
    excused = "excused"


@dataclass(frozen=True)
class AssignmentMark:
    """A student's mark at an assignment. `ended`: it is a test in which the student can send nothing more.

    Once the assignment is over, exercises without an attempt count 0; before, only those with an attempt count. There
    may be attempts before the opening.
    """

    rules: Rules
    state: MarkState
    exercises: tuple[ExerciseMark, ...]
    ended: bool = False

    @cached_property
    def points(self) -> float | None:
        """The weighted mean of its exercises, excused ones left out; None where nothing counts."""
        if self.state is MarkState.excused:
            return None
        over = self.state in {MarkState.done, MarkState.absent} and not self.endless
        counted = [
            exercise for exercise in self.exercises if not exercise.excused and (over or exercise.points is not None)
        ]
        return weighted_mean(
            [(0.0 if exercise.points is None else exercise.points, exercise.weight) for exercise in counted]
        )

    @property
    def endless(self) -> bool:
        """Whether it has neither a due or closing date nor another end."""
        return not self.ended and self.rules.last_counted_at is None and self.rules.due_at is None

    @property
    def in_average(self) -> float | None:
        """The points that count in the student's average: None while it is not over."""
        return self.points if self.state in {MarkState.done, MarkState.absent} else None

    @cached_property
    def days_late(self) -> int:
        return max((exercise.days_late for exercise in self.exercises), default=0)

    @cached_property
    def overridden(self) -> bool:
        return any(exercise.override is not None for exercise in self.exercises)

    @cached_property
    def stale(self) -> bool:
        return any(exercise.stale for exercise in self.exercises)


@dataclass(frozen=True)
class StudentMarks:
    """A student's marks, in the order of the gradebook's assignments."""

    member: StudentRecord
    marks: tuple[AssignmentMark, ...]
    weights: tuple[float, ...]

    @cached_property
    def average(self) -> float | None:
        """The weighted mean of the assignments that are over, those excused left out."""
        weighted = [(mark.in_average, weight) for mark, weight in zip(self.marks, self.weights, strict=True)]
        return weighted_mean([(points, weight) for points, weight in weighted if points is not None])


@dataclass(frozen=True)
class MarkSummary:
    """Number, mean and median of the marks of those who sent something."""

    count: int
    mean: float | None
    median: float | None


def summarise(points: Sequence[float]) -> MarkSummary:
    return MarkSummary(len(points), mean(points), median(points))


@dataclass(frozen=True)
class Gradebook:
    """The marks of a class at one moment, its students sorted as a list of names."""

    school_class: SchoolClass
    at: datetime
    assignments: tuple[Assignment, ...]
    rows: tuple[StudentMarks, ...]
    titles: Mapping[str, str] = field(default_factory=dict)
    exercises: Mapping[UUID, tuple[WeightedExercise, ...]] = field(default_factory=dict)

    def title_of(self, exercise: str) -> str:
        """Return the title of an exercise, or its id once it has left the course."""
        return self.titles.get(exercise, exercise)

    def summary_of(self, index: int) -> MarkSummary:
        """Summarise the marks at one assignment, absent and excused students left out."""
        marks = [row.marks[index] for row in self.rows]
        points_sent = [mark.points for mark in marks if mark.state in {MarkState.done, MarkState.open}]
        return summarise([points for points in points_sent if points is not None])

    @cached_property
    def averages(self) -> MarkSummary:
        return summarise([row.average for row in self.rows if row.average is not None])


def is_withheld(assignment: Assignment, now: datetime) -> bool:
    """Whether it is a test whose results are not released yet."""
    released = assignment.released_at
    return assignment.mode == Mode.test and (released is None or released > now)


@dataclass(frozen=True)
class OwnMark:
    """A mark as its student sees it: None while a test withholds it, or one of its exercises.

    `exercises`: the marks of exercises that are shown all the same.
    """

    assignment: Assignment
    rules: Rules
    mark: AssignmentMark | None
    exercises: Mapping[str, ExerciseMark] = field(default_factory=dict)


@dataclass(frozen=True)
class OwnMarks:
    """A student's own marks, in the order of the assignments, and the average of those that are shown."""

    marks: tuple[OwnMark, ...] = ()
    average: float | None = None
    titles: Mapping[str, str] = field(default_factory=dict)

    @staticmethod
    def from_gradebook(gradebook: Gradebook, withheld_exercises: Collection[str]) -> OwnMarks:
        """Return the marks of the only student of a gradebook, none where it has no row.

        `withheld_exercises`: those of which a test withholds attempts from this student.
        """
        if not gradebook.rows:
            return OwnMarks()
        (row,) = gradebook.rows
        visible = [
            not is_withheld(assignment, gradebook.at)
            and not any(
                exercise.exercise in withheld_exercises for exercise in gradebook.exercises.get(assignment.id, ())
            )
            for assignment in gradebook.assignments
        ]
        visible_row = StudentMarks(
            row.member,
            tuple(mark for mark, is_visible in zip(row.marks, visible, strict=True) if is_visible),
            tuple(weight for weight, is_visible in zip(row.weights, visible, strict=True) if is_visible),
        )
        marks = []
        for assignment, mark, is_visible in zip(gradebook.assignments, row.marks, visible, strict=True):
            visible_marks = () if is_withheld(assignment, gradebook.at) else mark.exercises
            exercises = {own.exercise: own for own in visible_marks if own.exercise not in withheld_exercises}
            marks.append(OwnMark(assignment, mark.rules, mark if is_visible else None, exercises))
        return OwnMarks(tuple(marks), visible_row.average, gradebook.titles)
