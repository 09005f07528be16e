"""The contents of the board of a class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple
from uuid import UUID


class ProgressState(StrEnum):
    """The state of a student in an exercise."""

    none = "none"
    trying = "trying"
    stuck = "stuck"
    solved = "solved"


@dataclass(frozen=True)
class BoardStudent:
    """A student on the board, in the order of a list of names; `seen_at`: when they last opened a page."""

    id: UUID
    name: str
    groups: tuple[str, ...]
    seen_at: datetime | None


class ProgressCell(NamedTuple):
    """A student in an exercise. `points` out of 20, in force; `misconception` is that of the latest attempt.

    `is_concerned`: the exercise is given to the class, or to a group of the student. `partner`: who has sent for them
    both, where the student has sent nothing; points and state are then those of what the partner sent.
    """

    student: UUID
    exercise: str
    points: float | None
    attempts: int
    state: ProgressState
    misconception: str | None
    is_concerned: bool = True
    partner: str = ""


@dataclass(frozen=True)
class StudentCounts:
    """Numbers of students: in the class; with an attempt; who have solved all that counts; who are stuck now."""

    students: int
    started: int
    finished: int
    stuck: int


@dataclass(frozen=True)
class MisconceptionStats:
    """A misconception in one exercise, each student counted once.

    `students`: those whose latest attempt shows it, `now` of them; `ever`: of whom some attempt shows it; `overcome`:
    those who had it and have it no more; `median_attempts`: of theirs, from the first attempt with it to the first
    without it. `followed`: who sent another attempt after the first with it; `improved`: and scored more.
    """

    exercise: str
    id: str
    title: str
    now: int
    ever: int
    overcome: int
    median_attempts: float | None
    students: tuple[UUID, ...]
    followed: int
    improved: int


@dataclass(frozen=True)
class Board:
    """The board of a class at one time. `rows`: the cells of each student, in the order of the exercises.

    `version`: boards with the same one show the same, at whatever time they were read.
    """

    class_id: UUID
    generated_at: datetime
    students: tuple[BoardStudent, ...]
    exercises: tuple[str, ...]
    rows: Mapping[UUID, tuple[ProgressCell, ...]]
    counts: StudentCounts
    misconceptions: tuple[MisconceptionStats, ...]
    version: str

    @cached_property
    def cells_by_pair(self) -> Mapping[tuple[UUID, str], ProgressCell]:
        """One cell for each student and exercise, in their orders."""
        return {(cell.student, cell.exercise): cell for row in self.rows.values() for cell in row}

    def cells_changed_since(self, before: Board) -> Sequence[ProgressCell]:
        """Return the cells that are not in `before`, or are other ones there."""
        changed: list[ProgressCell] = []
        for student, row in self.rows.items():
            earlier = before.rows.get(student, ())
            if row != earlier:
                known = {cell.exercise: cell for cell in earlier}
                changed += (cell for cell in row if known.get(cell.exercise) != cell)
        return changed

    @cached_property
    def misconception_titles(self) -> Mapping[tuple[str, str], str]:
        """The titles of misconceptions, by exercise and id."""
        return {(stats.exercise, stats.id): stats.title for stats in self.misconceptions}

    @property
    def list_shown_students(self) -> Sequence[tuple[UUID, str, tuple[str, ...]]]:
        return [(student.id, student.name, student.groups) for student in self.students]


@dataclass(frozen=True)
class UnexplainedFailure:
    """Latest attempts that fail without a known misconception, of these students; `submission` is one of them.

    `group` is None for a failure that is in no group of equal behaviour; `name`: a teacher's name of the group.
    """

    exercise: str
    group: str | None
    students: tuple[UUID, ...]
    submission: UUID
    name: str | None


@dataclass(frozen=True)
class ExerciseStats:
    """Statistics of an exercise: `n` students have tried it, `solved` of them have solved it.

    `success` is a share, None under `FEWEST_FOR_A_SHARE` students. Medians are over who solved it: attempts until the
    first success, and minutes from the first attempt to it. `discrimination` is the correlation between the best score
    here and the mean of the best scores elsewhere, over the `paired` students who have tried something else too; None
    under `FEWEST_FOR_A_CORRELATION`, or where nothing varies.
    """

    exercise: str
    n: int
    solved: int
    success: float | None
    median_attempts: float | None
    median_minutes: float | None
    discrimination: float | None
    paired: int


@dataclass(frozen=True)
class ImprovementStats:
    """How many of `n` students scored more at the next attempt; `share` is None for few students."""

    exercise: str
    label: str
    n: int
    improved: int

    @property
    def share(self) -> float | None:
        return self.improved / self.n if self.n >= FEWEST_FOR_A_SHARE else None


@dataclass(frozen=True)
class HintStats:
    """Improvements after the opening of each hint of an exercise."""

    exercise: str
    levels: tuple[ImprovementStats, ...]


@dataclass(frozen=True)
class ActivitySlot:
    """The number of attempts sent in a slot of time."""

    begins_at: datetime
    attempts: int


@dataclass(frozen=True)
class BoardStatistics:
    """Statistics beside the board."""

    unnamed: tuple[UnexplainedFailure, ...]
    items: tuple[ExerciseStats, ...]
    helped: tuple[ImprovementStats, ...]
    hints: tuple[HintStats, ...]
    lesson: tuple[ActivitySlot, ...]
    days: tuple[ActivitySlot, ...]


FEWEST_FOR_A_SHARE = 10
FEWEST_FOR_A_CORRELATION = 20
FEWEST_TO_PROJECT = 5
