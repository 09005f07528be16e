"""What the templates of regrades receive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from server.desk.schemas import ClassHead
from server.web.schemas import ExerciseTexts

Tone = Literal["good", "bad", "plain"]


@dataclass(frozen=True)
class OutdatedExerciseRow:
    """An exercise that has changed since attempts at it were graded."""

    exercise: str
    title: str
    words: str


@dataclass(frozen=True)
class RegradeRow:
    """A regrade in a list; `state` in words, `scope` too."""

    href: str
    title: str
    scope: str
    policy: str
    when: str
    when_text: str
    state: str
    tone: Literal["", "good", "warn"]


@dataclass(frozen=True)
class RegradesPage:
    """The class's regrades, and the form to prepare one: choices are values with their words."""

    head: ClassHead
    outdated: tuple[OutdatedExerciseRow, ...]
    exercises: tuple[tuple[str, str], ...]
    assignments: tuple[tuple[str, str], ...]
    students: tuple[tuple[str, str], ...]
    rows: tuple[RegradeRow, ...]


@dataclass(frozen=True)
class RegradeFormValues:
    """What is filled in of the form, and why it is refused."""

    exercise: str = ""
    policy: str = "keep_best"
    assignment: str = ""
    student: str = ""
    problem: str = ""


@dataclass(frozen=True)
class MarkChangeRow:
    """A student: points before and after (empty where nothing counts), the difference with its sign, reasons, notes.

    `attempt` is the address of the attempt that the reasons are about, empty without any.
    """

    student: str
    before: str
    after: str
    difference: str
    why: tuple[str, ...]
    notes: tuple[str, ...]
    attempt: str


@dataclass(frozen=True)
class OutcomeGroup:
    """Students to whom the same happens. `folded`: where nothing does, they are out of the way."""

    id: str
    title: str
    sign: str
    tone: Tone
    folded: bool
    rows: tuple[MarkChangeRow, ...]


@dataclass(frozen=True)
class RegradePage:
    """One regrade. `texts` renders the titles in the reasons, in an exercise answered without code."""

    head: ClassHead
    regrade: RegradeRow
    state: str
    graded: int
    total: int
    progress: str
    failed: int
    groups: tuple[OutcomeGroup, ...]
    texts: ExerciseTexts | None

    @property
    def changes_nothing(self) -> bool:
        """Nobody would have another mark, as far as could be graded."""
        return not self.failed and all(group.folded for group in self.groups)
