"""Contexts shared by the templates of several rooms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from server.web.values import ValueView

Tone = Literal["good", "partial", "bad", "ours"]


@dataclass(frozen=True)
class AccountView:
    """The reader. `key` is stable for one account and safe to show; "visiteur" for nobody yet."""

    role: Literal["visitor", "guest", "student", "teacher", "administrator"]
    name: str
    key: str

    @property
    def is_teacher(self) -> bool:
        return self.role in {"teacher", "administrator"}


@dataclass(frozen=True)
class EditionNote:
    """The notice on a module's page about its editions; `href` is the other one's address, if any."""

    words: str
    href: str = ""


@dataclass(frozen=True)
class CurrentModuleView:
    """The module that one is in; `searching` where the page has a search field of its own."""

    slug: str
    number: str
    searching: bool


@dataclass(frozen=True)
class ModuleLink:
    slug: str
    number: str
    title: str
    summary: str
    exercises: int
    done: int


@dataclass(frozen=True)
class SolutionSwitchView:
    """A button that opens a solution to a class, or to everyone (no class), or closes it."""

    class_id: str
    label: str
    is_open: bool


@dataclass(frozen=True)
class StudentExerciseProgress:
    """Where one stands in an exercise: `done` with full marks, `label` in words, `best` out of 20 or empty."""

    attempts: int
    best: str
    done: bool

    @property
    def kind(self) -> str:
        return "done" if self.done else "begun" if self.attempts else "new"


@dataclass(frozen=True)
class ExerciseRow:
    href: str
    title: str
    summary: str
    stars: int
    origin: str
    own: StudentExerciseProgress


@dataclass(frozen=True)
class CounterexampleView:
    """`expected` and `got` are None together: the call failed before it gave anything."""

    inputs: tuple[tuple[str, ValueView], ...]
    expected: ValueView | None
    got: ValueView | None
    code: str


@dataclass(frozen=True)
class FigureView:
    """Addresses of the same drawing in both themes, and what it shows in words: `caption` beside it, `alt` instead."""

    light: str
    dark: str
    alt: str
    caption: str = ""


@dataclass(frozen=True)
class CheckView:
    """A check of a verdict; `replay` is where its counterexample is replayed line by line, or empty.

    `repeats`: an earlier check tells why it failed; `neutral`: there is nothing to hold against the program.
    """

    id: str
    title: str
    passed: bool
    points: str
    max_points: str
    message: str
    hint: str
    counterexample: CounterexampleView | None
    figure: FigureView | None
    filmed: bool = False
    replay: str = ""
    repeats: bool = False
    neutral: bool = False

    @property
    def sign(self) -> str:
        return "✓" if self.passed else "–" if self.neutral else "✗"

    @property
    def word(self) -> str:
        return "Réussi" if self.passed else "Rien à reprocher" if self.neutral else "Échoué"

    @property
    def kind(self) -> str:
        return "passed" if self.passed else "neutral" if self.neutral else "failed"


@dataclass(frozen=True)
class FilmView:
    """The replay of a check; `source` is the address of its data."""

    id: str
    title: str
    passed: bool
    source: str


@dataclass(frozen=True)
class DiagnosisView:
    """`by_teacher`: a teacher says so of all programs that answer alike."""

    id: str
    title: str
    paragraphs: tuple[str, ...]
    by_teacher: bool = False

    @property
    def guiding_questions(self) -> tuple[str, ...]:
        """What the student is asked before the remedy is told."""
        return tuple(paragraph for paragraph in self.paragraphs if paragraph.endswith("?"))


class ExerciseTexts(Protocol):
    """Renders the texts of an exercise (`server.course.Exercise`)."""

    def render_paragraphs(self, text: str) -> str: ...
    def render_line(self, text: str) -> str: ...


@dataclass(frozen=True)
class VerdictView:
    """A verdict in words. `points` is the mark out of 20 in French; empty when the fault is ours.

    `texts` renders its messages, of an exercise answered without code: they are the course's Markdown. `common` is
    what all the checks say when they all say the same. `films` are those of failed checks, then of the others.
    """

    title: str
    sentence: str
    tone: Tone
    points: str
    common: str
    checks: tuple[CheckView, ...]
    diagnosis: DiagnosisView | None
    stdout: str
    timings: tuple[tuple[str, str], ...]
    seed: str
    version: str
    texts: ExerciseTexts | None
    films: tuple[FilmView, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def passed_check_count(self) -> int:
        return sum(check.passed for check in self.checks)

    @property
    def announcement(self) -> str:
        """One sentence for screen readers when the verdict arrives."""
        mark = f"{self.points} sur 20. " if self.points else ""
        return f"Verdict : {mark}{self.title}."
