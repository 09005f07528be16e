"""What the course holds: modules, exercises, and the problems found while reading them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, cast

from graders.core.contract.kits import scenario_kit
from server.course.editions import latest_editions, parse_edition
from server.course.exercises import ExerciseTable
from server.course.families import NO_FILING, FamilyFiling, MisconceptionFamily
from server.course.functions import FunctionSpec
from server.course.kinds import LessonKind
from server.course.objectives import Objective
from server.sandbox.policy import Policy
from server.text.markup import CodeCell, Heading, MarkdownText, ModuleNames, Section
from server.text.markup.text import no_module_names
from server.text.prose import render_author_line, render_author_text

if TYPE_CHECKING:
    from graders.core.answers import AnswersGrader
    from graders.core.contract.protocol import Grader

__all__ = [
    "CodeCell", "Course", "CourseFault", "Drawing", "Exercise", "FunctionSpec", "Heading", "Lesson", "Module",
    "Problem", "ReadingPath", "Section", "Term",
]  # fmt: skip


UNKNOWN_VERSION = "inconnue"
#: Of the seed of a grading: a number that JSON carries whole.
SEED_BITS = 53


@dataclass(frozen=True)
class Problem:
    """A fault in the course's own files. `line` counts from 1; None when the fault is not in one line."""

    path: Path
    line: int | None
    message: str

    def __str__(self) -> str:
        place = str(self.path) if self.line is None else f"{self.path}:{self.line}"
        return f"{place}: {self.message}"


class CourseFault(Exception):
    """Raised inside the course's loader only: carries the problem to report."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(str(problem))
        self.problem = problem


@dataclass(frozen=True, eq=False)
class Exercise:
    """One exercise, ready to serve. `id` is "module/slug"; `stars` counts the ★ of a challenge (0 to 3).

    `seance` is the slug of the lesson that it follows.
    `version` is a digest of everything that can change a verdict (see `server.course.version`).
    An exercise answered without code (`answers`) has no function, and neither starter nor solution as files: its grader
    gives questions and correction. `kit` names what its programs find, among the module's; `policy` bounds what they
    may use; `reuses` are the slugs of the exercises whose functions they may import, those that these reuse in their
    turn included (see `server.course.reuse`). `make` gives its grader, loading it if it must; `filing` files its
    misconceptions; `hunts` says who sees its bug hunts.
    """

    module: str
    slug: str
    title: str
    summary: str
    order: int
    stars: int
    origin: str
    functions: tuple[FunctionSpec, ...]
    starter: str
    solution: str
    statement: MarkdownText
    hint_texts: tuple[MarkdownText, MarkdownText, MarkdownText]
    make: Callable[[], Grader]
    version: str
    kind: Literal["code", "answers"] = "code"
    kit: str = ""
    names: Callable[[], ModuleNames] = no_module_names
    seance: str = ""
    policy: Policy = field(default_factory=Policy)
    reuses: tuple[str, ...] = ()
    filing: FamilyFiling = NO_FILING
    hunts: Literal["never", "solved", "always"] = "solved"

    @property
    def id(self) -> str:
        return f"{self.module}/{self.slug}"

    @cached_property
    def grader(self) -> Grader:
        """What grades it, loaded at the first need."""
        return self.make()

    @property
    def answers(self) -> AnswersGrader | None:
        """What grades it, of an exercise answered without code."""
        return cast("AnswersGrader", self.grader) if self.kind == "answers" else None

    def render_paragraphs(self, text: str) -> str:
        return render_author_text(text, self.names)

    def render_line(self, text: str) -> str:
        """Render a text of its questions or of its verdicts in a line; `render_paragraphs` makes paragraphs."""
        return render_author_line(text, self.names)

    @property
    def statement_html(self) -> str:
        return self.statement.html

    @property
    def hints(self) -> tuple[str, str, str]:
        """The three hints as HTML: a question, a pointer to the formula, a commented sketch."""
        first, second, third = self.hint_texts
        return first.html, second.html, third.html


@dataclass(frozen=True, eq=False)
class Lesson:
    """A text to read. What its front matter says is here at once; its text is read and rendered at the first need.

    `solution`: it tells the answers of a paper, and is opened as an exercise's solution is (`id` names it then);
    `skills`: those of its objectives that name what practises them.
    """

    module: str
    slug: str
    kind: LessonKind
    title: str
    label: str
    order: int
    minutes: int
    summary: str
    objectives: tuple[str, ...]
    text: MarkdownText
    solution: bool = False
    skills: tuple[Objective, ...] = ()

    @property
    def id(self) -> str:
        return f"{self.module}/lire/{self.slug}"

    @property
    def html(self) -> str:
        return self.text.html

    @property
    def headings(self) -> tuple[Heading, ...]:
        return self.text.headings

    @property
    def sections(self) -> tuple[Section, ...]:
        return self.text.sections

    @property
    def figures(self) -> tuple[str, ...]:
        """The names of its drawings."""
        return self.text.figures

    @property
    def replays(self) -> tuple[str, ...]:
        return self.text.replays

    @property
    def questions(self) -> tuple[str, ...]:
        """The questions of exercises that it asks, `exercise/question`."""
        return self.text.questions

    @property
    def stills(self) -> tuple[str, ...]:
        """The drawings that stand for its manipulations where there is no script."""
        return self.text.still_drawings

    @property
    def cells(self) -> tuple[CodeCell, ...]:
        return self.text.code_cells


@dataclass(frozen=True, eq=False)
class Term:
    """A word of the glossary. `page` is the slug of the lesson that explains it."""

    id: str
    word: str
    page: str
    definition: MarkdownText

    @property
    def html(self) -> str:
        """The definition, as HTML that fits in a paragraph."""
        return self.definition.html

    @property
    def text(self) -> str:
        return " ".join(section.text for section in self.definition.sections)


@dataclass(frozen=True)
class Drawing:
    """A figure of the texts: `function`, in the module at `path`, draws it. `size` is in inches."""

    name: str
    alt: str
    size: tuple[float, float]
    path: Path
    line: int
    function: str


@dataclass(frozen=True)
class ReadingPath:
    """A way for some readers: `page` is a lesson's slug and a label in it (`chemins#s-un`), `exercises` are slugs.

    By `name`, the lessons say what it leaves for later.
    """

    title: str
    summary: str
    page: str
    exercises: tuple[str, ...] = ()
    name: str = ""


@dataclass(frozen=True, eq=False)
class Module:
    """A module of the course, with its exercises in order, and its lessons in the order of reading.

    `number` is its name in the course ("L20"), `sessions` its length; `previous` and `next` are numbers of modules;
    `folder` is where it stands.
    `retrievals` are the files of its retrieval questions, by their names (`lesson/question`).
    `kits` are what its programs may find: by name, the source texts of its files by their paths. The one that bears the
    slug is of one file, and any program's but for exercises that ask for another.
    """

    slug: str
    title: str
    number: str
    summary: str
    track: str
    sessions: int
    prerequisites: tuple[str, ...]
    objectives: tuple[str, ...]
    references: tuple[str, ...]
    previous: str
    next: str
    order: int
    kits: Mapping[str, Mapping[str, str]]
    exercises: tuple[Exercise, ...]
    lessons: tuple[Lesson, ...] = ()
    glossary: Mapping[str, Term] = field(default_factory=dict)
    drawings: Mapping[str, Drawing] = field(default_factory=dict)
    files: Mapping[str, Path] = field(default_factory=dict)
    paths: tuple[ReadingPath, ...] = ()
    retrievals: Mapping[str, Path] = field(default_factory=dict)
    names: Callable[[], ModuleNames] = no_module_names
    folder: Path = Path()

    @property
    def label(self) -> str:
        """Its number, and its edition where it is not the first."""
        return self.number + parse_edition(self.slug).edition_in_words


@dataclass(frozen=True, eq=False)
class Course:
    """Everything that is served. What is malformed is in `problems` and nowhere else."""

    modules: Mapping[str, Module]
    problems: tuple[Problem, ...]
    families: Mapping[str, MisconceptionFamily] = field(default_factory=dict)

    @cached_property
    def exercises(self) -> ExerciseTable[Exercise]:
        """Exercises by id, in the order of the course."""
        packaged = (exercise for module in self.modules.values() for exercise in module.exercises)
        return ExerciseTable({exercise.id: exercise for exercise in packaged})

    @cached_property
    def latest(self) -> tuple[Module, ...]:
        """What newcomers are offered: the last edition of each module."""
        wanted = latest_editions(self.modules)
        return tuple(module for slug, module in self.modules.items() if slug in wanted)

    def editions(self, slug: str) -> list[Module]:
        """All of a module's that are served, the first one first."""
        family = parse_edition(slug).family
        same = (module for module in self.modules.values() if parse_edition(module.slug).family == family)
        return sorted(same, key=lambda module: parse_edition(module.slug))

    def newer_edition(self, slug: str) -> Module | None:
        """The last edition of a module, where that comes after this one."""
        last = next(reversed(self.editions(slug)), None)
        return last if last and parse_edition(last.slug) > parse_edition(slug) else None

    def title_of_exercise(self, exercise: str) -> str:
        """Return the title of an exercise by its id, or the id of one that has left the course."""
        served = self.exercises.get(exercise)
        return exercise if served is None else served.title

    def title_at_address(self, path: str) -> str:
        """Return the title of the lesson or exercise at an address, empty where nothing is there any more."""
        slug, _, rest = path.strip("/").partition("/")
        kind, _, name = rest.partition("/")
        module = self.modules.get(slug)
        pages: Sequence[Exercise | Lesson] = ()
        if module is not None and kind in {"exercices", "lire"}:
            pages = module.exercises if kind == "exercices" else module.lessons
        return next((page.title for page in pages if page.slug == name), "")

    def version_of_exercise(self, exercise: str) -> str:
        """The version of an exercise by its id, which may have left the course."""
        served = self.exercises.get(exercise)
        return UNKNOWN_VERSION if served is None else served.version

    def required_worker_version(self, exercise: str) -> str | None:
        """The version that a worker must have of an exercise; None of an authored one, read at each grading."""
        return self.version_of_exercise(exercise) if self.exercises.is_packaged(exercise) else None

    def importable_exercises(self, exercise: str) -> Sequence[Exercise]:
        """The exercises whose functions the programs of an exercise may import."""
        served = self.exercises.get(exercise)
        return [self.exercises[f"{served.module}/{slug}"] for slug in served.reuses] if served else []

    @cached_property
    def kits(self) -> Mapping[str, Mapping[str, str]]:
        """The kits of all the modules and that of declared exercises, by name."""
        return MappingProxyType(scenario_kit() | dict(kit for it in self.modules.values() for kit in it.kits.items()))
