"""What goes into the room, and what comes out of it. Points are out of 20."""

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
    """An override in force. `by` is empty where the account is no more; `based_on` as in the table."""

    points: float | None
    excused: bool
    reason: str
    by: str
    at: datetime
    based_on: frozenset[str | None]


@dataclass(frozen=True)
class EffectivePoints:
    """A student's points at an exercise: those set, else those found; None where there are none, or when excused."""

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

    `grading` is the name of the grading that makes the automatic mark, of the attempt sent at `sent_at`.
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
        """What makes the automatic mark is not what made it when the override was set."""
        return self.override is not None and self.grading not in self.override.based_on

    @property
    def days_late(self) -> int:
        """Of the attempt that counts, where it does."""
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
    """A student's mark at an assignment. Over, what was not sent counts 0; before, only what was sent counts.

    Who works ahead has sent something before the opening.
    """

    rules: Rules
    state: MarkState
    exercises: tuple[ExerciseMark, ...]
    ended: bool = False

    @cached_property
    def points(self) -> float | None:
        """The weighted mean of its exercises, excused ones left out; None where there is nothing to say."""
        if self.state is MarkState.excused:
            return None
        over = self.state in {MarkState.done, MarkState.absent} and not self.endless
        known = [(0.0 if one.points is None else one.points, one.weight) for one in self._asked(missing=over)]
        return weighted_mean(known)

    def _asked(self, *, missing: bool) -> Sequence[ExerciseMark]:
        return [one for one in self.exercises if not one.excused and (missing or one.points is not None)]

    @property
    def endless(self) -> bool:
        """Without any date after which work is late or refused, nor any other end (`ended`: of a test)."""
        return not self.ended and self.rules.last_counted_at is None and self.rules.due_at is None

    @property
    def in_average(self) -> float | None:
        """The points that a student's average takes: what is not over yet stays out of it."""
        return self.points if self.state in {MarkState.done, MarkState.absent} else None

    @cached_property
    def days_late(self) -> int:
        return max((one.days_late for one in self.exercises), default=0)

    @cached_property
    def overridden(self) -> bool:
        return any(one.override is not None for one in self.exercises)

    @cached_property
    def stale(self) -> bool:
        return any(one.stale for one in self.exercises)


@dataclass(frozen=True)
class StudentMarks:
    """A student's marks, in the order of the book's assignments."""

    member: StudentRecord
    marks: tuple[AssignmentMark, ...]
    weights: tuple[float, ...]

    @cached_property
    def average(self) -> float | None:
        """The weighted mean of the assignments that are over, those excused left out."""
        known = [(mark.in_average, weight) for mark, weight in zip(self.marks, self.weights, strict=True)]
        return weighted_mean([(points, weight) for points, weight in known if points is not None])


@dataclass(frozen=True)
class MarkSummary:
    """Of the copies that were sent: how many, their mean and their median."""

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
        """An exercise may have left the course."""
        return self.titles.get(exercise, exercise)

    def summary_of(self, place: int) -> MarkSummary:
        """Of one assignment, by its place: who has sent nothing, or is excused, is not counted."""
        marks = [row.marks[place] for row in self.rows]
        sent = [mark.points for mark in marks if mark.state in {MarkState.done, MarkState.open}]
        return summarise([points for points in sent if points is not None])

    @cached_property
    def averages(self) -> MarkSummary:
        return summarise([row.average for row in self.rows if row.average is not None])


def is_withheld(assignment: Assignment, now: datetime) -> bool:
    """A test of which the students are told nothing yet."""
    released = assignment.released_at
    return assignment.mode == Mode.test and (released is None or released > now)


@dataclass(frozen=True)
class OwnMark:
    """A mark as its student sees it: None while the test is held back, or a test holds one of its exercises back.

    `exercises`: those of which the marks are told all the same.
    """

    assignment: Assignment
    rules: Rules
    mark: AssignmentMark | None
    exercises: Mapping[str, ExerciseMark] = field(default_factory=dict)


@dataclass(frozen=True)
class OwnMarks:
    """A student's marks, in the order of the assignments, and their average over those that are told."""

    marks: tuple[OwnMark, ...] = ()
    average: float | None = None
    titles: Mapping[str, str] = field(default_factory=dict)

    @staticmethod
    def of(book: Gradebook, held: Collection[str]) -> OwnMarks:
        """Of a book of one row, or of none. `held`: exercises of which a test holds attempts back from this student."""
        if not book.rows:
            return OwnMarks()
        (row,) = book.rows
        told = [
            not is_withheld(one, book.at) and not any(row.exercise in held for row in book.exercises.get(one.id, ()))
            for one in book.assignments
        ]
        shown = StudentMarks(
            row.member,
            tuple(mark for mark, is_told in zip(row.marks, told, strict=True) if is_told),
            tuple(weight for weight, is_told in zip(row.weights, told, strict=True) if is_told),
        )
        marks = tuple(
            OwnMark(assignment, mark.rules, mark if is_told else None, _told(assignment, mark, held, book.at))
            for assignment, mark, is_told in zip(book.assignments, row.marks, told, strict=True)
        )
        return OwnMarks(marks, shown.average, book.titles)


def _told(
    assignment: Assignment, mark: AssignmentMark, held: Collection[str], now: datetime
) -> dict[str, ExerciseMark]:
    if is_withheld(assignment, now):
        return {}
    return {one.exercise: one for one in mark.exercises if one.exercise not in held}
