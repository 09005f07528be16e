"""From the columns of a class to what the templates show, and from their forms to marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from uuid import UUID

from sqlalchemy.orm import Session
from starlette.datastructures import FormData

from server.base.errors import Invalid
from server.classes import repository as classes
from server.course import Course
from server.desk.schemas import ClassHead
from server.desk.views import class_head
from server.marks import columns, columns_repository
from server.marks.columns import MarkEntry
from server.marks.means import format_number
from server.marks.models import ManualColumn
from server.marks.schemas import NEVER_TYPED, ColumnRecord, TypedMark
from server.marks.typed import format_typed_mark, parse_mark_comment, parse_typed_mark
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.form_version import form_version_tag
from server.web.words import count_with_noun

SEPARATOR = "|"  # between the mark and the comment of a cell as it was drawn: no mark has one
MAX_PASTED = 200_000  # characters
TOO_LONG = "{pasted} pour {students} : collez une note par élève, dans l’ordre de la liste, une par ligne."
PASTED = "{pasted} dans l’ordre de la liste : relisez, puis enregistrez."


@dataclass(frozen=True)
class ColumnForm:
    """The fields of a column as they are typed, and by field what is wrong."""

    title: str = ""
    out_of: str = "20"
    taken_on: str = ""
    weight: str = "1"
    bonus: bool = False
    problems: Mapping[str, str] = field(default_factory=dict)

    def with_problems(self, problems: Mapping[str, str]) -> ColumnForm:
        return replace(self, problems=problems)

    @property
    def texts(self) -> Mapping[str, str]:
        """The fields by their labels, to compare two versions."""
        return {
            "Titre": self.title.strip(),
            "Barème": self.out_of.strip(),
            "Date": self.taken_on.strip(),
            "Coefficient": self.weight.strip(),
            "Bonus": "oui" if self.bonus else "non",
        }


def stored_form(column: ManualColumn) -> ColumnForm:
    taken_on = "" if column.taken_on is None else column.taken_on.isoformat()
    return ColumnForm(column.title, format_number(column.out_of), taken_on, format_number(column.weight), column.bonus)


@dataclass(frozen=True)
class ColumnsPage:
    """`columns` in order, `deleted` newest first; `form` makes another one."""

    head: ClassHead
    columns: Sequence[ColumnRecord]
    deleted: Sequence[ColumnRecord]
    form: ColumnForm
    may_change: bool


@dataclass(frozen=True)
class MarkRowInput:
    """The line of a student: the mark and the comment as they are typed, as they were drawn, and what is wrong."""

    student: UUID
    name: str
    text: str
    comment: str
    drawn: str
    problem: str = ""


@dataclass(frozen=True)
class EnteredMarks:
    """The marks of a form: the rows, the entries to store, those that somebody else changed meanwhile.

    `conflicts`: name, stored and typed text; `version` is that of all stored marks.
    """

    rows: tuple[MarkRowInput, ...]
    entries: tuple[MarkEntry, ...]
    conflicts: tuple[tuple[str, str, str], ...]
    version: str
    out_of: float
    notice: str = ""
    general_problem: str = ""

    @property
    def problems(self) -> bool:
        return bool(self.general_problem) or any(row.problem for row in self.rows)

    def with_pasted(self, text: str) -> EnteredMarks:
        """Fill the marks with pasted lines, from the first student on; nothing is stored yet."""
        lines = text[:MAX_PASTED].rstrip("\r\n").splitlines()
        pasted = count_with_noun(len(lines), "ligne collée", "lignes collées")
        if len(lines) > len(self.rows):
            students = count_with_noun(len(self.rows), "élève")
            return replace(self, general_problem=TOO_LONG.format(pasted=pasted, students=students))
        filled = [
            replace(row, text=line.strip(), problem=_mark_problem(line, row.comment, self.out_of))
            for row, line in zip(self.rows, lines, strict=False)
        ]
        return replace(self, rows=(*filled, *self.rows[len(lines) :]), notice=PASTED.format(pasted=pasted))


@dataclass(frozen=True)
class ColumnPage:
    head: ClassHead
    column: ManualColumn
    record: ColumnRecord
    marks: EnteredMarks
    form: ColumnForm
    version: str
    may_change: bool


def build_columns_page(db: Session, course: Course, access: ClassAccess, form: ColumnForm | None = None) -> ColumnsPage:
    class_id = access.school_class.id
    active, deleted = (columns_repository.list_columns(db, class_id, deleted=deleted) for deleted in (False, True))
    return ColumnsPage(
        head=class_head(course, access, "/carnet"),
        columns=[columns_repository.build_column_record(column) for column in active],
        deleted=[columns_repository.build_column_record(column) for column in deleted],
        form=form or ColumnForm(),
        may_change=_may_change(access),
    )


def _may_change(access: ClassAccess) -> bool:
    return access.has(Right.change_marks) and access.school_class.archived_at is None


def list_active(db: Session, access: ClassAccess) -> Sequence[ManualColumn]:
    return columns_repository.list_columns(db, access.school_class.id)


def build_column_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    column_id: UUID,
    *,
    entered: EnteredMarks | None = None,
    form: ColumnForm | None = None,
) -> ColumnPage:
    """Build the page of a column. Raise NotFound."""
    column = columns.find_column(db, access.school_class, column_id)
    stored = stored_form(column)
    return ColumnPage(
        head=class_head(course, access, "/carnet"),
        column=column,
        record=columns_repository.build_column_record(column),
        marks=entered or read_marks(db, access, column, FormData()),
        form=form or stored,
        version=form_version_tag(stored.texts),
        may_change=_may_change(access) and column.deleted_at is None,
    )


def read_marks(db: Session, access: ClassAccess, column: ManualColumn, fields: FormData) -> EnteredMarks:
    """Read the marks of a form; a field that it does not have is as it is stored.

    A mark that was not touched since it was drawn is not stored again, whatever somebody else typed meanwhile.
    """
    stored = columns_repository.load_column_marks(db, column.id)
    rows, entries, conflicts, texts = [], [], [], {}
    for student in classes.load_student_records(db, access.school_class.id):
        mark = stored.get(student.id)
        current = NEVER_TYPED if mark is None else columns_repository.build_typed_mark(mark)
        current_text = _cell_text(format_typed_mark(current), current.comment)
        texts[str(student.id)] = current_text
        text = str(fields.get(f"n-{student.id}", format_typed_mark(current)))
        comment = str(fields.get(f"r-{student.id}", current.comment))
        drawn = str(fields.get(f"a-{student.id}", current_text))
        problem = ""
        if _cell_text(text, comment) != drawn:
            problem = _mark_problem(text, comment, column.out_of)
            if not problem:
                typed, tidied = parse_typed_mark(text, column.out_of), parse_mark_comment(comment)
                entries.append(MarkEntry(student.id, typed, tidied))
                if drawn != current_text and not _is_same(typed, tidied, current):
                    conflicts.append((student.name, current_text.strip(SEPARATOR), f"{text} {comment}".strip()))
        rows.append(MarkRowInput(student.id, student.name, text, comment, drawn, problem))
    return EnteredMarks(tuple(rows), tuple(entries), tuple(conflicts), form_version_tag(texts), column.out_of)


def _cell_text(mark: str, comment: str) -> str:
    return f"{mark}{SEPARATOR}{comment}"


def _is_same(typed: TypedMark, comment: str, current: TypedMark) -> bool:
    return (typed.points, typed.state, comment) == (current.points, current.state, current.comment)


def _mark_problem(text: str, comment: str, out_of: float) -> str:
    try:
        parse_typed_mark(text, out_of)
        parse_mark_comment(comment)
    except Invalid as refused:
        return refused.detail
    return ""
