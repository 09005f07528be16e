"""What the templates of the gradebook and of the log receive."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from server.audit.wording import ValueChange
from server.desk.schemas import ClassHead


@dataclass(frozen=True)
class CellView:
    """A mark in the table. `late`: days; `pending`: work may still be sent; `href` is empty for what does not open."""

    text: str
    href: str = ""
    late: int = 0
    changed: bool = False
    stale: bool = False
    pending: bool = False


@dataclass(frozen=True)
class ColumnView:
    """`href` leads to what the column is made of, `sort_href` sorts by it; `notes` are said below its title.

    `about`: words and address of another page about it, where there is one.
    """

    title: str
    href: str
    sort_href: str
    is_sorted: bool
    notes: tuple[str, ...]
    count: int
    mean: str
    median: str
    about: tuple[str, str] | None = None


@dataclass(frozen=True)
class TableRow:
    name: str
    cells: tuple[CellView, ...]


@dataclass(frozen=True)
class TableView:
    caption: str
    columns: tuple[ColumnView, ...]
    rows: tuple[TableRow, ...]
    name_href: str
    by_name: bool


@dataclass(frozen=True)
class Choice:
    """One of a list, with its address or its value."""

    value: str
    label: str
    chosen: bool


@dataclass(frozen=True)
class GradebookBody:
    """The cached part of the page. `href` is that of the class; `column`: the text of the column to copy.

    `query_fields`: the present query, for a form that adds to it; `moodle`: identifier, its words and the students that
    are left out, for each of Moodle's files.
    """

    href: str
    total: int
    table: TableView
    everyone: str
    everyone_count: int
    groups: tuple[Choice, ...]
    group: str
    query_fields: tuple[tuple[str, str], ...]
    pages: tuple[Choice, ...]
    assignments: tuple[Choice, ...]
    columns: tuple[Choice, ...]
    column: str | None
    moodle: tuple[tuple[str, str, tuple[str, ...]], ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class GradebookPage:
    """`assignment`: the title of the one that is detailed; `body`: a rendered `GradebookBody`."""

    head: ClassHead
    at: str
    at_text: str
    total: int
    group: str
    assignment: str
    assignment_href: str
    back: str
    body: Markup


@dataclass(frozen=True)
class OverrideView:
    text: str
    by: str
    at: str
    at_text: str
    reason: str
    stale: bool


@dataclass(frozen=True)
class ExerciseView:
    """One exercise of an assignment, for one student. `attempt` leads to the attempt that counts."""

    exercise: str
    title: str
    weight: str
    points: str
    automatic: str
    late: int
    attempts: int
    attempt: str
    sent: str
    sent_text: str
    override: OverrideView | None


@dataclass(frozen=True)
class MarkPage:
    head: ClassHead
    student: str
    assignment: str
    path: str
    mark: CellView
    state: str
    notes: tuple[str, ...]
    exercises: tuple[ExerciseView, ...]
    may_change: bool


@dataclass(frozen=True)
class MarkForm:
    """What was refused, with what had been written."""

    exercise: str = ""
    points: str = ""
    reason: str = ""
    problem: str = ""


@dataclass(frozen=True)
class EventView:
    at: str
    at_text: str
    by: str
    words: str
    student: str
    about: str
    changes: tuple[ValueChange, ...]
    reason: str


@dataclass(frozen=True)
class LogPage:
    """`first`: the number of the first event shown, from 1; `newer`, `older`: where one goes on, empty at the ends."""

    head: ClassHead
    events: tuple[EventView, ...]
    total: int
    first: int
    students: tuple[Choice, ...]
    kinds: tuple[Choice, ...]
    newer: str
    older: str
    file_query: str
    filtered: bool
