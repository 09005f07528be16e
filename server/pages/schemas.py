"""What the templates receive: every page's context is one of these types, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from server.web.values import ValueView

Tone = Literal["good", "partial", "bad", "ours"]


@dataclass(frozen=True)
class AccountView:
    """Who is looking. `key` is stable for one account and safe to show; "visiteur" for nobody yet."""

    role: Literal["visitor", "guest", "student", "teacher"]
    name: str
    key: str

    @property
    def is_teacher(self) -> bool:
        return self.role == "teacher"


@dataclass(frozen=True)
class HereView:
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
class HomePage:
    modules: tuple[ModuleLink, ...]


@dataclass(frozen=True)
class OwnState:
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
    own: OwnState


@dataclass(frozen=True)
class CounterexampleView:
    """`expected` and `got` are None together: the call failed before it gave anything."""

    inputs: tuple[tuple[str, ValueView], ...]
    expected: ValueView | None
    got: ValueView | None
    replay: str


@dataclass(frozen=True)
class FigureView:
    """Addresses of the same drawing in both themes, and what it shows in words."""

    light: str
    dark: str
    alt: str


@dataclass(frozen=True)
class CheckView:
    id: str
    title: str
    passed: bool
    points: str
    max_points: str
    message: str
    hint: str
    counterexample: CounterexampleView | None
    figure: FigureView | None


@dataclass(frozen=True)
class DiagnosisView:
    id: str
    title: str
    paragraphs: tuple[str, ...]


class Texts(Protocol):
    """What renders the texts of an exercise (`server.course.Exercise`)."""

    def prose(self, text: str) -> str: ...
    def line(self, text: str) -> str: ...


@dataclass(frozen=True)
class VerdictView:
    """A verdict in words. `points` is the mark out of 20 in French; empty when the fault is ours.

    `texts` renders its messages, of an exercise answered without code: they are the course's Markdown. `common` is
    what all the checks say when they all say the same.
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
    texts: Texts | None

    @property
    def passed(self) -> int:
        return sum(check.passed for check in self.checks)

    @property
    def announcement(self) -> str:
        """One sentence for screen readers when the verdict arrives."""
        mark = f"{self.points} sur 20. " if self.points else ""
        return f"Verdict : {mark}{self.title}."


@dataclass(frozen=True)
class WorkView:
    """The latest state of one submission: waiting (`waiting` says where) or judged."""

    id: str
    number: int
    status: Literal["queued", "running", "done"]
    waiting: str
    verdict: VerdictView | None
    page: str
    events: str
    fragment: str


@dataclass(frozen=True)
class HintView:
    """A hint: its HTML when it is open, else the sentence that says what opens it."""

    number: int
    html: str
    closed: str


@dataclass(frozen=True)
class SolutionView:
    """The reference solution: highlighted HTML when one may read it. `for_all`: a teacher has opened it to everyone."""

    html: str
    for_all: bool
    action: str


@dataclass(frozen=True)
class AttemptRow:
    number: int
    href: str
    when: str
    when_text: str
    points: str
    outcome: str


@dataclass(frozen=True)
class FunctionView:
    signature: str
    returns: str
    doc: str


@dataclass(frozen=True)
class Results:
    """What changes when a verdict arrives; `solution` is None where it stays out of sight."""

    work: WorkView | None
    hints: tuple[HintView, ...]
    solution: SolutionView | None
    attempts: tuple[AttemptRow, ...]
    all_attempts: str
    own: OwnState


@dataclass(frozen=True)
class ExerciseFrame:
    """What the page of an exercise holds, of whatever kind; `action` is where its form is sent."""

    id: str
    title: str
    summary: str
    stars: int
    origin: str
    module: ModuleLink
    lesson: tuple[str, str] | None
    statement: str
    action: str
    results: Results
    previous: tuple[str, str] | None
    following: tuple[str, str] | None


@dataclass(frozen=True)
class ExercisePage(ExerciseFrame):
    functions: tuple[FunctionView, ...]
    starter: str
    code: str
    taken: bool
    limits: tuple[tuple[str, str], ...]
    kit_href: str
    kit_name: str


@dataclass(frozen=True)
class GivenView:
    """A number drawn for this account; `symbol` is HTML."""

    symbol: str
    name: str
    value: str
    unit: str


@dataclass(frozen=True)
class PieceView:
    """An option or a step. `chosen` and `place` (from 1, 0 for none) put back an earlier answer."""

    id: str
    html: str
    chosen: bool
    place: int


@dataclass(frozen=True)
class QuestionView:
    """A question; `title` is HTML, `field` names its form field, `value` is the number that was typed before."""

    id: str
    number: int
    title: str
    html: str
    form: Literal["number", "one", "several", "order"]
    field: str
    points: str
    unit: str
    value: str
    pieces: tuple[PieceView, ...]


@dataclass(frozen=True)
class AnswersPage(ExerciseFrame):
    """An exercise answered without code, as one account sees it."""

    given: tuple[GivenView, ...]
    questions: tuple[QuestionView, ...]
    seed: str
    taken: bool


@dataclass(frozen=True)
class ToldView:
    """One answer of an attempt, `title` in HTML: its text, or the letters and HTML of what was chosen."""

    title: str
    text: str
    pieces: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class AttemptPage:
    module: ModuleLink
    exercise_title: str
    exercise_href: str
    take_href: str
    when: str
    when_text: str
    code: str
    told: tuple[ToldView, ...] | None
    results: Results


@dataclass(frozen=True)
class AttemptsPage:
    module: ModuleLink
    exercise_title: str
    exercise_href: str
    attempts: tuple[AttemptRow, ...]


@dataclass(frozen=True)
class ErrorPage:
    status: int
    title: str
    detail: str
