"""What the templates of the board receive."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from server.desk.schemas import ClassHead, CodeView


@dataclass(frozen=True)
class CellView:
    """A student in an exercise: sign and text are seen, `label` is read aloud. Without `href` there is nothing yet."""

    key: str
    kind: str
    sign: str
    text: str
    label: str
    href: str


@dataclass(frozen=True)
class RowView:
    key: str
    name: str
    href: str
    groups: tuple[str, ...]
    solved: int
    cells: Markup


@dataclass(frozen=True)
class Sorter:
    """A link that sorts: `order` is that of the column now ("ascending", "descending" or "none")."""

    label: str
    href: str
    order: str


@dataclass(frozen=True)
class Choice:
    """A link among others; `here`: what it leads to is what is shown."""

    label: str
    href: str
    here: bool


@dataclass(frozen=True)
class MistakeRow:
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
class CountsView:
    """The sentence at the head of the board, its numbers marked out by the template."""

    students: int
    started: int
    finished: int
    stuck: int


@dataclass(frozen=True)
class UnnamedView:
    """Failures that no misconception names: whose they are, and where they are read. `group_href` is empty for those
    that answer like no other; `name` is what a teacher has called them."""

    exercise: str
    exercise_href: str
    group_href: str
    name: str
    people: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class HelpedRow:
    """`levels`: what is written of each hint, or the one thing that is written of a misconception."""

    title: str
    exercise: str
    levels: tuple[str, ...]


@dataclass(frozen=True)
class ItemView:
    """`regrade_href` is empty for who may not have the class's attempts graded again."""

    exercise: str
    href: str
    regrade_href: str
    n: int
    success: str
    attempts: str
    minutes: str
    discrimination: str


@dataclass(frozen=True)
class BarView:
    """A slot of the time line, in the units of its drawing."""

    x: float
    y: float
    height: float
    attempts: int
    when: str
    when_text: str


@dataclass(frozen=True)
class ChartView:
    """`total` attempts, `most` of them in one slot; `times`: its slots are minutes of a day, and not days."""

    title: str
    bars: tuple[BarView, ...]
    total: int
    most: int
    width: float
    times: bool


@dataclass(frozen=True)
class WorkView:
    """What the students did, as it is asked for: misconceptions and the table."""

    mistakes: tuple[MistakeRow, ...]
    more_mistakes: Choice | None
    names: Sorter
    solved: Sorter
    columns: tuple[Sorter, ...]
    sorts: tuple[Choice, ...]
    groups: tuple[Choice, ...]
    rows: tuple[RowView, ...]
    found: int
    pages: tuple[Choice, ...]


@dataclass(frozen=True)
class BesideView:
    """What is read at leisure beside it."""

    unnamed: tuple[UnnamedView, ...]
    helped: tuple[HelpedRow, ...]
    helped_hidden: int
    hints: tuple[HelpedRow, ...]
    items: tuple[ItemView, ...]
    charts: tuple[ChartView, ...]


@dataclass(frozen=True)
class BoardPage:
    """`work` and `beside`: a `WorkView` and a `BesideView`, as they were drawn."""

    head: ClassHead
    counts: CountsView
    rule: str
    waiting: int
    code: CodeView | None
    version: str
    stream: str
    again: str
    generated: str
    generated_text: str
    work: Markup
    beside: Markup


@dataclass(frozen=True)
class MistakePage:
    """A misconception in a class. `extracts` are anonymous; `may_project`: enough students had it, or `chosen`.
    `word_href` is empty for who may not write to students, and where nobody has it now.

    `paragraphs` are HTML where `prose` is true, else the course's plain sentences.
    """

    head: ClassHead
    row: MistakeRow
    paragraphs: tuple[str, ...]
    prose: bool
    extracts: tuple[str, ...]
    still: tuple[tuple[str, str], ...]
    freed: tuple[tuple[str, str], ...]
    after: str
    lesson: tuple[str, str] | None
    project_href: str
    word_href: str
    may_project: bool
    fewest: int
