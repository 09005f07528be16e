"""Contexts of the reading pages' templates: one type for each page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from markupsafe import Markup
from pydantic import Field

from server.base.validation import RequestBody
from server.polls.models import ANSWER_LENGTH, POLL_LENGTH
from server.web.deadlines import DueAssignmentView
from server.web.next_step import NextExercise
from server.web.schemas import EditionNote, ExerciseRow, FigureView, ModuleLink, SolutionSwitchView


@dataclass(frozen=True)
class ContentsEntry:
    """One line of a table of contents; `html` may hold mathematics."""

    id: str
    html: Markup
    below: tuple[ContentsEntry, ...]


@dataclass(frozen=True)
class LessonLink:
    """A lesson in a list. `duration` is how long it is to read, in words, or empty; `parts` counts its sections."""

    slug: str
    href: str
    label: str
    title: str
    summary: str
    duration: str
    objectives: int
    parts: int


@dataclass(frozen=True)
class SessionCard:
    """A séance with the exercises that follow it; `done_exercise_count` of them have full marks, all take `work`, in
    words."""

    page: LessonLink
    figure: FigureView | None
    exercises: tuple[ExerciseRow, ...]
    work: str = ""

    @property
    def done_exercise_count(self) -> int:
        return sum(row.own.done for row in self.exercises)


@dataclass(frozen=True)
class LessonShelf:
    """Lessons of one kind under their title."""

    id: str
    title: str
    pages: tuple[LessonLink, ...]


@dataclass(frozen=True)
class PathView:
    """A way through the module, and the place where it is said; `name` stores it, empty where it cannot be chosen."""

    title: str
    summary: str
    href: str
    name: str = ""
    is_chosen: bool = False


@dataclass(frozen=True)
class NeighbourModuleView:
    """A module before or after another: « après », « L18 »; `href` is empty where it is not served."""

    word: str
    number: str
    href: str


@dataclass(frozen=True)
class CourseHome:
    """A module's page. `start` is where a newcomer begins; None while the module has nothing to read."""

    slug: str
    number: str
    title: str
    track: str
    summary: str
    facts: tuple[tuple[str, str], ...]
    around: tuple[NeighbourModuleView, ...]
    objectives: tuple[str, ...]
    references: tuple[Markup, ...]
    paths: tuple[PathView, ...]
    start: LessonLink | None
    resumed: NextExercise | None
    sessions: tuple[SessionCard, ...]
    shelves: tuple[LessonShelf, ...]
    exercises: tuple[ExerciseRow, ...]
    challenges: tuple[ExerciseRow, ...]
    terms: int
    kit_href: str
    done: int
    total: int
    due: tuple[DueAssignmentView, ...]
    edition: EditionNote | None = None
    proposed: tuple[ExerciseRow, ...] = ()


@dataclass(frozen=True)
class GlossaryTermView:
    """A word of the glossary; `href` leads to the lesson that explains it, called `where`, or both are empty."""

    id: str
    word: str
    html: Markup
    href: str
    where: str


@dataclass(frozen=True)
class SolutionGate:
    """What stands before the answers of a paper.

    `kept`: one's teacher has not opened them; `warned`: one may go on by `onward`; `online`: an archive has not got
    them; `open`: nothing, and who teaches sees to whom they are open (`doors`, sent to `action`).
    """

    state: Literal["kept", "warned", "online", "open"]
    onward: str = ""
    action: str = ""
    doors: tuple[SolutionSwitchView, ...] = ()


@dataclass(frozen=True)
class LessonPage:
    """A lesson. `terms` are the words whose definition it may be asked for; `said` is, as JSON, what the reader
    answered first to its questions, by name.

    `duration` is how long it is to read, `work` how long the exercises of the reader's path take, `later` what that
    path, called `path`, leaves for later. `exercises` follow the page; `placed` counts those that stand in its text.
    """

    module: ModuleLink
    slug: str
    kind: str
    label: str
    title: str
    summary: str
    duration: str
    work: str
    later: str
    path: str
    placed: int
    objectives: tuple[str, ...]
    html: Markup
    said: str
    contents: tuple[ContentsEntry, ...]
    exercises: tuple[ExerciseRow, ...]
    terms: tuple[GlossaryTermView, ...]
    previous: LessonLink | None
    following: LessonLink | None
    gate: SolutionGate | None = None


@dataclass(frozen=True)
class GlossaryLetter:
    letter: str
    terms: tuple[GlossaryTermView, ...]


@dataclass(frozen=True)
class GlossaryPage:
    """The glossary of a module; `errors`: the names of Python's errors with what they mean."""

    module: ModuleLink
    letters: tuple[GlossaryLetter, ...]
    total: int
    errors: Mapping[str, str]


@dataclass(frozen=True)
class SearchHitView:
    """One place found: `snippet` is escaped text in which the words looked for are marked."""

    href: str
    label: str
    title: str
    part: str
    snippet: Markup


@dataclass(frozen=True)
class SearchPage:
    """`read_as` is the query with other words in the place of those that stand nowhere, or empty."""

    module: ModuleLink
    query: str
    read_as: str
    hits: tuple[SearchHitView, ...]
    examples: tuple[str, ...]


class LessonAnswerInput(RequestBody):
    """An answer to a question of a lesson, both by their ids."""

    question: str = Field(max_length=POLL_LENGTH)
    answer: str = Field(max_length=ANSWER_LENGTH)
