"""The types that the templates of the gradebook and of the log receive."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from server.audit.wording import ValueChange
from server.desk.schemas import ClassHead
from server.marks.own import AverageTerm
from server.marks.schemas import AssignmentMark, ExerciseMark


@dataclass(frozen=True)
class MarkCell:
    """A mark in the table. `late`: days; `pending`: work may still be sent; `href` is empty where there is no link;
    `state`: a `MarkState`, empty for a mean; `counts`: how a state counts in the mean, where it does."""

    text: str
    href: str = ""
    late: int = 0
    changed: bool = False
    stale: bool = False
    pending: bool = False
    state: str = ""
    counts: str = ""


@dataclass(frozen=True)
class MarkColumn:
    """A column. `href`: the details of the column; `sort_href`: the table sorted by it; `notes` stand below its title.

    `about`: words and address of a page about it, where there is one.
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
class MarkRow:
    name: str
    cells: tuple[MarkCell, ...]


@dataclass(frozen=True)
class MarkTable:
    caption: str
    columns: tuple[MarkColumn, ...]
    rows: tuple[MarkRow, ...]
    name_href: str
    by_name: bool


@dataclass(frozen=True)
class GradebookOption:
    """An option of a list, with its address or value."""

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
    table: MarkTable
    everyone: str
    everyone_count: int
    groups: tuple[GradebookOption, ...]
    group: str
    query_fields: tuple[tuple[str, str], ...]
    pages: tuple[GradebookOption, ...]
    assignments: tuple[GradebookOption, ...]
    columns: tuple[GradebookOption, ...]
    column: str | None
    moodle: tuple[tuple[str, str, tuple[str, ...]], ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class GradebookPage:
    """`assignment`: the title of the one that is detailed; `body`: a rendered `GradebookBody`.

    `search`: what names contain; `search_fields`: the rest of the address, and
    `unsearched` all of it without a search; `is_long`: a search is worth its place.
    `rules_unchosen`: no teacher has chosen yet how states count in the mean of this older class; `rules_href` and
    `columns_href` are empty for those who may not change them.
    """

    head: ClassHead
    at: str
    at_text: str
    total: int
    group: str
    search: str
    search_href: str
    search_fields: tuple[tuple[str, str], ...]
    unsearched: str
    is_long: bool
    assignment: str
    assignment_href: str
    back: str
    rules_href: str
    rules_unchosen: bool
    columns_href: str
    body: Markup


@dataclass(frozen=True)
class ExerciseView:
    """One exercise of an assignment, for one student. `others`: the titles of the other assignments that ask it;
    `counts`: how it counts where it has no points."""

    title: str
    points: str
    counts: str
    mark: ExerciseMark
    others: tuple[str, ...]


@dataclass(frozen=True)
class MarkPage:
    """`may_decide`: whether a decision about the whole assignment may be made; none is about a class's bare module."""

    head: ClassHead
    student: str
    assignment: str
    cell: MarkCell
    mark: AssignmentMark
    notes: tuple[str, ...]
    exercises: tuple[ExerciseView, ...]
    may_change: bool
    may_decide: bool
    version: str


@dataclass(frozen=True)
class AveragePage:
    """« Pourquoi cette moyenne ? » of one student, with everything that counts for the teachers."""

    head: ClassHead
    student: str
    average: str
    terms: tuple[AverageTerm, ...]


@dataclass(frozen=True)
class MarkForm:
    """A refused form, with its fields and the problem. `everywhere`: the override holds in all assignments."""

    exercise: str = ""
    points: str = ""
    reason: str = ""
    everywhere: bool = False
    problem: str = ""


@dataclass(frozen=True)
class LogEntryView:
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
    """`first`: the number of the first entry, from 1; `newer`, `older`: addresses, empty at the ends."""

    head: ClassHead
    entries: tuple[LogEntryView, ...]
    total: int
    first: int
    students: tuple[GradebookOption, ...]
    kinds: tuple[GradebookOption, ...]
    newer: str
    older: str
    file_query: str
    filtered: bool
