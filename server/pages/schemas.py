"""Contexts of the pages' templates: every page receives one of these types, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from markupsafe import Markup

from graders.core.contract.progress import Progress
from server.course import FunctionSpec
from server.web.deadlines import DueAssignmentView
from server.web.regraded import RegradeNotice
from server.web.schemas import ModuleLink, SolutionSwitchView, StudentExerciseProgress, VerdictView


@dataclass(frozen=True)
class NextStep:
    """The next thing to do in a module; `verb` is the label of its button, `reason` a clause."""

    href: str
    verb: str
    title: str
    reason: str = ""


@dataclass(frozen=True)
class ModuleCard:
    """A module on the first page; `step` is None in a module without anything to read or to do, or all done."""

    link: ModuleLink
    begun: bool
    step: NextStep | None


@dataclass(frozen=True)
class HomePage:
    """`questions` counts what is due of what the reader confused, zero where they want no reminder."""

    modules: tuple[ModuleCard, ...]
    due: tuple[DueAssignmentView, ...] = ()
    questions: int = 0
    streak: int = 0

    @property
    def begun(self) -> bool:
        return any(card.begun for card in self.modules)


#: "none" where there is nothing to say.
MarkTone = Literal["good", "partial", "bad", "blank", "none"]


@dataclass(frozen=True)
class MarkView:
    """The mark of one question. `answered` is text; `message`, `expected` and `hint` are HTML."""

    question: str
    tone: MarkTone
    sign: str
    word: str
    points: str
    max_points: str
    answered: str
    expected: str
    message: str
    hint: str


@dataclass(frozen=True)
class RecalledMistake:
    """A mended misconception of the same family in another exercise, and where its correction is shown.

    `before` and `after` are the first lines that the author changed then, empty where it was answered without code.
    """

    exercise_title: str
    family: str
    href: str
    before: str = ""
    after: str = ""


@dataclass(frozen=True)
class SubmissionView:
    """The latest state of one submission: waiting (`waiting` says where) or judged; `again`: it is sent anew.

    `held` says which test holds its verdict back, which looks the same whether it was graded or not, if it `runs`.

    `marks` are those of the questions, in an exercise answered without code; `progress` is what it mended since the
    attempt before, `regraded` what a regrade has changed since it was sent; `asks`: it is of who looks, and somebody
    would read their question about it; `searched`: the places of its mistakes may still be found; `early` are its
    checks, while the name of the mistake is sought; `recalled` is the same mistake, mended in another exercise.
    """

    id: str
    number: int
    status: Literal["queued", "running", "done"]
    waiting: str
    verdict: VerdictView | None
    page: str
    events: str
    fragment: str
    again: bool
    marks: tuple[MarkView, ...]
    progress: Progress | None = None
    searched: bool = False
    asks: bool = False
    regraded: RegradeNotice | None = None
    held: str = ""
    runs: bool = True
    early: VerdictView | None = None
    recalled: RecalledMistake | None = None

    def mark(self, question: str) -> MarkView | None:
        """The mark of a question, where there is something to say of it."""
        return next((mark for mark in self.marks if mark.question == question and mark.tone != "none"), None)


@dataclass(frozen=True)
class WithheldView:
    """Why something is not shown, in a sentence that ends with until when, where that is known."""

    text: str
    until: datetime | None = None


@dataclass(frozen=True)
class TestBanner:
    """The banner of the test that an exercise belongs to: `now` is the server's time, `ends` may be empty.

    `save` is where what is written is kept, while one sits it; `saved` when it was last, `restored` whether the fields
    hold it. `tests` and `version` are the hidden fields of `server.pages.form_state`.
    """

    __test__ = False  # it is none of pytest's

    title: str
    href: str
    stage: Literal["may_begin", "running", "over"]
    now: datetime
    ends: datetime | None
    save: str
    saved: datetime | None
    restored: bool
    tests: str
    version: str


@dataclass(frozen=True)
class HintView:
    """A hint: its HTML when it is open, else the sentence that says what opens it."""

    number: int
    html: str
    closed: str


@dataclass(frozen=True)
class SolutionView:
    """The reference solution: highlighted HTML when one may read it; why one may, and to whom one may open it."""

    title: str
    html: str
    why: str
    action: str
    doors: tuple[SolutionSwitchView, ...]


@dataclass(frozen=True)
class AttemptRow:
    """`points` are empty where there are none, or where a test holds them back."""

    number: int
    href: str
    when: datetime
    points: str
    outcome: str


@dataclass(frozen=True)
class ReusableExerciseView:
    """An earlier exercise whose functions may be imported.

    `when` says since when one's own are; without it, they are the course's if these are `offered`.
    """

    title: str
    href: str
    functions: tuple[str, ...]
    when: datetime | None
    offered: bool = True

    @property
    def importable(self) -> bool:
        return self.when is not None or self.offered


@dataclass(frozen=True)
class WayOnward:
    """The way on from a solved exercise.

    The address and title of the next exercise (None: nothing is left on the way) with the `reason`, a clause; a harder
    question; where its bug hunts are, or empty; `is_reviewed`: there is a page of remarks on the program.
    """

    following: tuple[str, str] | None
    reason: str
    challenge: tuple[str, str] | None
    hunts: str
    is_reviewed: bool


@dataclass(frozen=True)
class ResultsView:
    """The parts of a page that change when a verdict arrives.

    `solution` is None while it is hidden; the `…_held` fields say why.
    """

    work: SubmissionView | None
    hints: tuple[HintView, ...]
    solution: SolutionView | None
    attempts: tuple[AttemptRow, ...]
    all_attempts: str
    own: StudentExerciseProgress
    hints_held: WithheldView | None = None
    diagnosis_held: WithheldView | None = None
    solution_held: WithheldView | None = None
    onward: WayOnward | None = None


@dataclass(frozen=True)
class CommonExercisePage:
    """The context of an exercise page of any kind; `action` is the address of its form."""

    id: str
    title: str
    summary: str
    stars: int
    origin: str
    module: ModuleLink
    lesson: tuple[str, str] | None
    statement: Markup
    action: str
    results: ResultsView
    test: TestBanner | None
    previous: tuple[str, str] | None
    following: tuple[str, str] | None
    due: tuple[DueAssignmentView, ...]


@dataclass(frozen=True)
class ExercisePage(CommonExercisePage):
    """An exercise of code. `replay` is where one runs a call of one's own, a whole program or, where `is_class`, a
    small program that uses the class.

    `examples` are calls to begin from, each with the name of its function; `names_href` gives the names to propose.
    """

    functions: tuple[FunctionSpec, ...]
    reused: tuple[ReusableExerciseView, ...]
    starter: str
    code: str
    taken: bool
    limits: tuple[tuple[str, str], ...]
    replay: str
    is_class: bool
    examples: tuple[tuple[str, str], ...]
    kit_href: str
    kit_name: str


@dataclass(frozen=True)
class GivenDatumView:
    """A number dealt to this account; `symbol` is HTML."""

    symbol: str
    name: str
    value: str
    unit: str


@dataclass(frozen=True)
class OptionOrStepView:
    """An option or a step. `chosen` puts back an earlier answer; `options` are the places that a step may be given, as
    HTML."""

    id: str
    html: str
    chosen: bool
    options: Markup


@dataclass(frozen=True)
class QuestionView:
    """A question; `title` is HTML, `field` names its form field, `value` is the number that was typed before.

    `section` is the heading that comes before it, if one does.
    """

    id: str
    number: int
    title: str
    html: str
    form: Literal["number", "one", "several", "order"]
    field: str
    points: str
    unit: str
    value: str
    pieces: tuple[OptionOrStepView, ...]
    section: str


@dataclass(frozen=True)
class AnswersPage(CommonExercisePage):
    """An exercise answered without code, as one account sees it."""

    given: tuple[GivenDatumView, ...]
    questions: tuple[QuestionView, ...]
    seed: str
    taken: bool


@dataclass(frozen=True)
class TranscriptView:
    """One answer of an attempt, `title` in HTML: its text, or the letters and HTML of what was chosen.

    `question` is what it answers; neither text nor letters where it was left blank.
    """

    question: str
    title: str
    text: str
    pieces: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class AttemptPage:
    module: ModuleLink
    exercise_title: str
    exercise_href: str
    take_href: str
    when: datetime
    code: str
    transcript: tuple[TranscriptView, ...] | None
    results: ResultsView
