"""What the board of a class holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from functools import cached_property
from hashlib import blake2b
from uuid import UUID


class ProgressState(StrEnum):
    """Of a student in an exercise."""

    none = "none"
    trying = "trying"
    stuck = "stuck"
    solved = "solved"


@dataclass(frozen=True)
class BoardStudent:
    """Who is on the board, in the order of a list of names; `seen_at`: when they were last there."""

    id: UUID
    name: str
    groups: tuple[str, ...]
    seen_at: datetime | None


@dataclass(frozen=True, slots=True)
class ProgressCell:
    """A student in an exercise. `points` out of 20, in force; `misconception` is that of the latest attempt."""

    student: UUID
    exercise: str
    points: float | None
    attempts: int
    state: ProgressState
    misconception: str | None
    told: str = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """In words, once: these cells are compared and looked up a thousand times a page."""
        values = (str(self.student), self.exercise, self.points, self.attempts, self.state.value, self.misconception)
        object.__setattr__(self, "told", repr(values))

    def __hash__(self) -> int:
        return hash(self.told)


@dataclass(frozen=True)
class ClassCounts:
    """Students: of the class; who have an attempt; who solved all that counts; who are stuck somewhere now."""

    students: int
    started: int
    finished: int
    stuck: int


@dataclass(frozen=True)
class MisconceptionStats:
    """In one exercise. Each student counts once: who has it in the latest attempt (`students`, `now` of them); who had
    it ever; who had it and has it no more, and in how many attempts (median, from the first that had it to the first
    without it). `followed`: who sent another attempt after the first that had it; `improved`: to whom that one brought
    more points."""

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

    @cached_property
    def told(self) -> str:
        """In words, once."""
        return repr(self)


@dataclass(frozen=True)
class Shown:
    """What is on a board but for its students' names. `cells` has one for each student and each exercise that counts,
    in order."""

    cells: Mapping[tuple[UUID, str], ProgressCell]
    counts: ClassCounts
    misconceptions: tuple[MisconceptionStats, ...]

    @cached_property
    def version(self) -> str:
        told = [repr(self.counts), *(cell.told for cell in self.cells.values())]
        told += [one.told for one in self.misconceptions]
        return blake2b("\n".join(told).encode(), digest_size=12).hexdigest()


@dataclass(frozen=True)
class Board:
    """A class at one time."""

    class_id: UUID
    generated_at: datetime
    students: tuple[BoardStudent, ...]
    exercises: tuple[str, ...]
    shown: Shown

    @property
    def cells(self) -> Mapping[tuple[UUID, str], ProgressCell]:
        return self.shown.cells

    @property
    def counts(self) -> ClassCounts:
        return self.shown.counts

    @property
    def misconceptions(self) -> tuple[MisconceptionStats, ...]:
        return self.shown.misconceptions

    @cached_property
    def version(self) -> str:
        """The same for two boards that show the same, whenever they were read."""
        told = repr((self.students_shown, self.exercises, self.shown.version))
        return blake2b(told.encode(), digest_size=12).hexdigest()

    @cached_property
    def rows(self) -> Mapping[UUID, Sequence[ProgressCell]]:
        """The cells of each student."""
        cells, width = list(self.cells.values()), len(self.exercises)
        return {one.id: cells[place * width : (place + 1) * width] for place, one in enumerate(self.students)}

    def changed_since(self, before: Board) -> Sequence[ProgressCell]:
        """The cells that `before` had not, or had otherwise."""
        return [cell for pair, cell in self.cells.items() if before.cells.get(pair) != cell]

    @cached_property
    def titles(self) -> Mapping[tuple[str, str], str]:
        """Of the misconceptions, by exercise and id."""
        return {(one.exercise, one.id): one.title for one in self.misconceptions}

    @property
    def students_shown(self) -> Sequence[tuple[UUID, str, tuple[str, ...]]]:
        return [(one.id, one.name, one.groups) for one in self.students]


@dataclass(frozen=True)
class UnexplainedFailure:
    """A failure that no misconception names: whose latest attempt shows it, and one of these attempts to read.

    `group` is None where a failure stands alone; `name` is what a teacher has called the group, if anything.
    """

    exercise: str
    group: str | None
    students: tuple[UUID, ...]
    submission: UUID
    name: str | None


@dataclass(frozen=True)
class ExerciseStats:
    """An exercise as its students show it: `n` have tried it, `solved` of them have solved it.

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
    """Of `n` students, to how many the next attempt brought more points: `share` of them, None where they are few."""

    exercise: str
    label: str
    n: int
    improved: int

    @property
    def share(self) -> float | None:
        return self.improved / self.n if self.n >= FEWEST_FOR_A_SHARE else None


@dataclass(frozen=True)
class HintStats:
    """Of an exercise: what followed the opening of each of its hints."""

    exercise: str
    levels: tuple[ImprovementStats, ...]


@dataclass(frozen=True)
class ActivitySlot:
    """The attempts that were sent from a time on, until the next slot or now."""

    begins_at: datetime
    attempts: int


@dataclass(frozen=True)
class Insights:
    """What is read at leisure beside the board.

    `made`: the same object where all is made of the same attempts of the same students; slots of the same times are the
    same then.
    """

    unnamed: tuple[UnexplainedFailure, ...]
    items: tuple[ExerciseStats, ...]
    helped: tuple[ImprovementStats, ...]
    hints: tuple[HintStats, ...]
    lesson: tuple[ActivitySlot, ...]
    days: tuple[ActivitySlot, ...]
    made: object = field(compare=False, repr=False)


FEWEST_FOR_A_SHARE = 10
FEWEST_FOR_A_CORRELATION = 20
FEWEST_TO_PROJECT = 5
