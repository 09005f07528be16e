"""The types that the templates of the board receive."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from server.desk.schemas import ClassHead, JoinCodeView


@dataclass(frozen=True)
class BoardCell:
    """A student in an exercise: sign and text are seen, `label` is read aloud; `href` is empty without attempts.

    `by` is seen too, where a partner has sent for the student.
    """

    key: str
    kind: str
    sign: str
    text: str
    label: str
    href: str
    by: str = ""


@dataclass(frozen=True)
class BoardRow:
    key: str
    name: str
    href: str
    solved: int
    cells: tuple[BoardCell, ...]


@dataclass(frozen=True)
class SortLink:
    """A link that sorts by a column; `order`: "ascending", "descending" or "none" at present."""

    label: str
    href: str
    order: str


@dataclass(frozen=True)
class BoardLink:
    """A link among others; `here`: it leads to what is shown."""

    label: str
    href: str
    here: bool


@dataclass(frozen=True)
class MisconceptionRow:
    """A misconception in the table; `share` of the class still has it, in percent of a bar's length."""

    key: str
    title: str
    href: str
    exercise: str
    exercise_href: str
    now: int
    share: float
    ever: int
    overcome: int
    attempts: str


@dataclass(frozen=True)
class UnexplainedRow:
    """Failures without a known misconception, with the names of their students and the addresses of their work.

    `group_href` is empty for those in no group of equal behaviour; `name`: what a teacher calls the group.
    """

    exercise: str
    group_href: str
    name: str
    people: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ExerciseRow:
    """The statistics of an exercise; `regrade_href` is empty for who may not regrade."""

    title: str
    href: str
    regrade_href: str
    n: int
    success: str
    attempts: str
    minutes: str
    discrimination: str


@dataclass(frozen=True)
class ActivityBar:
    """A slot of an activity chart, in the units of its drawing."""

    x: float
    y: float
    height: float
    attempts: int
    begin: str
    begin_text: str


@dataclass(frozen=True)
class ActivityChart:
    """`total` attempts, `highest` of them in one slot."""

    title: str
    bars: tuple[ActivityBar, ...]
    total: int
    highest: int
    width: float


@dataclass(frozen=True)
class BoardBody:
    """The misconceptions and the table of students, for one query."""

    misconceptions: tuple[MisconceptionRow, ...]
    more_misconceptions: BoardLink | None
    names: SortLink
    solved: SortLink
    columns: tuple[SortLink, ...]
    sorts: tuple[BoardLink, ...]
    groups: tuple[BoardLink, ...]
    rows: tuple[Markup, ...]
    student_count: int
    pages: tuple[BoardLink, ...]
    #: What names contain; the rest of the address; the board without a search; whether a search is worth its place.
    search: str
    search_href: str
    search_fields: tuple[tuple[str, str | int], ...]
    unsearched: str
    is_long: bool
    #: Whether some exercise is given to other groups than that of some student.
    leaves_out: bool


@dataclass(frozen=True)
class SidePanel:
    """`improvements`: title, exercise and share of each misconception; `hints`: exercise and share for each hint."""

    unexplained: tuple[UnexplainedRow, ...]
    improvements: tuple[tuple[str, str, str], ...]
    hidden_improvements: int
    hints: tuple[tuple[str, tuple[str, ...]], ...]
    exercises: tuple[ExerciseRow, ...]
    charts: tuple[ActivityChart, ...]


@dataclass(frozen=True)
class BoardPage:
    """`counts`, `body` and `side_panel` are rendered fragments: of `StudentCounts`, `BoardBody` and `SidePanel`."""

    head: ClassHead
    has_students: bool
    rule: str
    waiting: int
    code: JoinCodeView | None
    version: str
    stream: str
    again: str
    generated: str
    generated_text: str
    counts: Markup
    body: Markup
    side_panel: Markup


@dataclass(frozen=True)
class MisconceptionPage:
    """A misconception in a class. `extracts` are anonymous.

    `word_href` is empty for who may not write to students, and where nobody has it now.

    `paragraphs` are HTML where `prose` is true, else the course's plain sentences.
    """

    head: ClassHead
    row: MisconceptionRow
    paragraphs: tuple[str, ...]
    prose: bool
    extracts: tuple[str, ...]
    still: tuple[tuple[str, str], ...]
    freed: tuple[tuple[str, str], ...]
    after: str
    lesson: tuple[str, str] | None
    project_href: str
    word_href: str
