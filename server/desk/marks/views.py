"""From the marks of a class to the page of its gradebook."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import urlencode

from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.base import school_time
from server.base.errors import NotFound
from server.classes.folding import normalise_name
from server.classes.schemas import StudentRecord
from server.desk.marks.cells import (
    assignment_cell,
    assignment_notes,
    column_mark_cell,
    column_notes,
    exercise_mark_cell,
    points_text,
)
from server.desk.marks.schemas import (
    GradebookBody,
    GradebookOption,
    GradebookPage,
    MarkCell,
    MarkColumn,
    MarkRow,
    MarkTable,
)
from server.desk.views import class_head, class_href, count_students_by_label, regrade_href
from server.marks.files import (
    MoodleIdentifier,
    build_moodle_table,
    distinct_assignment_titles,
    explain_marking_rules,
    marks_as_lines,
)
from server.marks.loading import GradebookInputs, build_gradebook
from server.marks.means import format_number
from server.marks.schemas import (
    ColumnRecord,
    Gradebook,
    MarkStatistics,
    StudentMarks,
    compute_statistics,
)
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.fragments import FRAGMENTS
from server.web.rendering import jinja_environment
from server.web.words import format_iso_time, format_short_time

AVERAGE = "moyenne"
STUDENTS_PER_PAGE = 200
#: Up to so many, a list needs no search.
FEW_STUDENTS = 12
UNKNOWN = "La classe n’a pas ce devoir, ou cet élève."
IDENTIFIED_BY = {MoodleIdentifier.email: "par adresse électronique", MoodleIdentifier.id: "par identifiant"}

Score = Callable[[StudentMarks], float | None]


@dataclass(frozen=True)
class GradebookQuery:
    """The query of the address: a group, one assignment or all, a sort key, a column to copy, a page from 1, and what
    the names or logins contain."""

    group: str = ""
    assignment: str = ""
    sort_key: str = ""
    copied_column: str = ""
    page_number: int = 1
    search: str = ""

    def matches(self, student: StudentRecord) -> bool:
        """Whether a student is in the group, and has all words of the search; accents and case aside."""
        if self.group and self.group not in student.groups:
            return False
        known = normalise_name(f"{student.name} {student.login}") if self.search else ""
        return all(word in known for word in normalise_name(self.search).split())

    def fields(self, **changes: str) -> dict[str, str]:
        """Return the fields of the address that are not empty, but for `changes`."""
        fields = {"groupe": self.group, "devoir": self.assignment, "tri": self.sort_key, "q": self.search, **changes}
        return {name: value for name, value in fields.items() if value}


def gradebook_page(db: Session, access: ClassAccess, inputs: GradebookInputs, query: GradebookQuery) -> GradebookPage:
    """Build the page, whose body is rendered only where it is not cached. Raise NotFound for an unknown assignment."""
    assignments = inputs.assigned.assignments
    titles = {
        str(assignment.id): title
        for assignment, title in zip(assignments, distinct_assignment_titles(assignments), strict=True)
    }
    if query.assignment and query.assignment not in titles:
        raise NotFound(UNKNOWN)
    group_sizes = count_students_by_label(student.groups for student in inputs.students)
    group = query.group if query.group in group_sizes else ""
    query = replace(query, group=group)
    total = sum(map(query.matches, inputs.students))
    number = min(query.page_number, max(1, math.ceil(total / STUDENTS_PER_PAGE)))
    query = replace(query, page_number=number)

    def render() -> str:
        builder = _BodyBuilder(access, build_gradebook(db, inputs), query, titles, group_sizes)
        macros: Any = jinja_environment().get_template("classes/gradebook_body.html").module
        return str(macros.body(builder.body()))

    may_change = access.has(Right.change_marks) and access.school_class.archived_at is None
    key = ("gradebook", inputs.version, query, access.has(Right.regrade), may_change, school_time.time_zone().key)
    home = class_href(access.school_class)
    chosen = next((assignment for assignment in assignments if str(assignment.id) == query.assignment), None)
    about = None if chosen is None else _assignment_link(chosen, access)
    return GradebookPage(
        head=class_head(inputs.course, access, "/carnet"),
        at=format_iso_time(inputs.now),
        at_text=format_short_time(inputs.now),
        total=total,
        group=group,
        search=query.search,
        search_href=f"{home}/carnet",
        search_fields=tuple(query.fields(q="").items()),
        unsearched=_gradebook_href(f"{home}/carnet", query, q=""),
        is_long=len(inputs.students) > FEW_STUDENTS,
        assignment=titles.get(query.assignment, ""),
        assignment_href="" if about is None else about[1],
        back=_gradebook_href(f"{home}/carnet", query, devoir="", tri=""),
        rules_href=f"{home}/reglages#moyenne" if access.has(Right.configure_class) else "",
        rules_unchosen=not inputs.marking.is_chosen,
        columns_href=f"{home}/carnet/colonnes" if may_change else "",
        body=FRAGMENTS.get_or_render(key, render),
    )


def _gradebook_href(path: str, query: GradebookQuery, **changes: str) -> str:
    """Return the address of the gradebook with this query, but for `changes`."""
    fields = urlencode(query.fields(**changes))
    return f"{path}?{fields}" if fields else path


def _assignment_link(assignment: Assignment, access: ClassAccess) -> tuple[str, str] | None:
    """Return words and address of an assignment's page; None for the exercises of a class without assignments."""
    if assignment.id == access.school_class.id:
        return None
    return "le devoir", f"{class_href(access.school_class)}/devoirs/{assignment.id}"


class _BodyBuilder:
    """Builds the body for one query; `titles` are those of the assignments, by id."""

    def __init__(
        self,
        access: ClassAccess,
        gradebook: Gradebook,
        query: GradebookQuery,
        titles: Mapping[str, str],
        group_sizes: Mapping[str, int],
    ) -> None:
        self._place, self._query, self._titles, self._group_sizes = access, query, titles, group_sizes
        self._class_href = class_href(access.school_class)
        self._everyone = gradebook
        rows = [row for row in gradebook.rows if query.matches(row.member)]
        self._gradebook = replace(gradebook, rows=tuple(rows))
        self._index_of = {name: index for index, name in enumerate(titles)}

    def body(self) -> GradebookBody:
        query, titles = self._query, self._titles
        manual = {str(column.id): column.full_title for column in self._gradebook.columns}
        columns = {**titles, **manual, AVERAGE: "Moyenne"}
        copied = query.copied_column
        return GradebookBody(
            href=self._class_href,
            total=len(self._gradebook.rows),
            table=self._exercises_table() if query.assignment else self._assignments_table(),
            everyone=self._href(groupe=""),
            everyone_count=len(self._everyone.rows),
            groups=tuple(
                GradebookOption(self._href(groupe=label), f"{label} ({count})", label == query.group)
                for label, count in self._group_sizes.items()
            ),
            group=query.group,
            query_fields=tuple(query.fields().items()),
            pages=self._pages(),
            assignments=tuple(GradebookOption(name, title, name == query.assignment) for name, title in titles.items()),
            columns=tuple(GradebookOption(name, title, name == copied) for name, title in columns.items()),
            column=marks_as_lines(self._gradebook, None if copied == AVERAGE else copied)
            if copied in columns
            else None,
            moodle=tuple(
                (identifier.value, label, build_moodle_table(self._everyone, identifier).left_out)
                for identifier, label in IDENTIFIED_BY.items()
            ),
            notes=explain_marking_rules(self._gradebook.marking),
        )

    def _href(self, **changes: str) -> str:
        return _gradebook_href(f"{self._class_href}/carnet", self._query, **changes)

    def _pages(self) -> tuple[GradebookOption, ...]:
        """Return links to the pages, none where one page is enough."""
        numbers = range(1, math.ceil(len(self._gradebook.rows) / STUDENTS_PER_PAGE) + 1)
        pages = [GradebookOption(self._href(p=str(n)), str(n), n == self._query.page_number) for n in numbers]
        return tuple(pages) if len(pages) > 1 else ()

    def _assignments_table(self) -> MarkTable:
        """Return the table of all assignments."""
        gradebook = self._gradebook
        columns = [
            self._column(
                name,
                title,
                gradebook.assignment_statistics(index),
                href=self._href(devoir=name, tri=""),
                notes=assignment_notes(assignment, gradebook.at),
                about=_assignment_link(assignment, self._place),
            )
            for index, (assignment, (name, title)) in enumerate(
                zip(gradebook.assignments, self._titles.items(), strict=True)
            )
        ]
        scores = {name: _assignment_score(index) for name, index in self._index_of.items()}
        for index, column in enumerate(gradebook.columns):
            name, summary = str(column.id), gradebook.column_statistics(index)
            href, notes = self._column_href(column), column_notes(column)
            columns.append(self._column(name, column.full_title, summary, notes=notes, about=("saisir, régler", href)))
            scores[name] = _column_score(index)
        columns.append(self._column(AVERAGE, "Moyenne", gradebook.average_statistics))
        rows = self._sorted_rows({**scores, AVERAGE: lambda row: row.average})
        return self._table("Notes des devoirs", columns, [(row, self._assignment_cells(row)) for row in rows])

    def _assignment_cells(self, row: StudentMarks) -> tuple[MarkCell, ...]:
        marks = zip(row.marks, self._gradebook.assignments, strict=True)
        cells = [assignment_cell(mark, self._mark_href(row, assignment)) for mark, assignment in marks]
        cells += [column_mark_cell(mark, f"{self._column_href(mark.column)}#e-{row.member.id}") for mark in row.columns]
        return (*cells, MarkCell(points_text(row.average), f"{self._class_href}/carnet/{row.member.id}"))

    def _column_href(self, column: ColumnRecord) -> str:
        return f"{self._class_href}/carnet/colonnes/{column.id}"

    def _mark_href(self, row: StudentMarks, assignment: Assignment) -> str:
        return f"{self._class_href}/carnet/{row.member.id}/{assignment.id}"

    def _exercises_table(self) -> MarkTable:
        """Return the table of the exercises of the chosen assignment."""
        gradebook, index = self._gradebook, self._index_of[self._query.assignment]
        assignment = gradebook.assignments[index]
        exercises = gradebook.exercises[assignment.id]
        may_regrade = self._place.has(Right.regrade)
        columns = [
            self._column(
                exercise,
                gradebook.exercise_title(exercise),
                compute_statistics(
                    [points for row in gradebook.rows if (points := row.marks[index].exercises[n].points) is not None]
                ),
                notes=(f"coefficient {format_number(weight)}",),
                about=("recorriger", regrade_href(self._class_href, exercise)) if may_regrade else None,
            )
            for n, (exercise, weight) in enumerate(exercises)
        ]
        columns.append(self._column(AVERAGE, "Note du devoir", gradebook.assignment_statistics(index)))
        scores = {exercise: _exercise_score(index, n) for n, (exercise, _) in enumerate(exercises)}
        rows = self._sorted_rows({**scores, AVERAGE: _assignment_score(index)})
        cells = []
        for row in rows:
            mark, href = row.marks[index], self._mark_href(row, assignment)
            cells.append(
                (
                    row,
                    (
                        *(exercise_mark_cell(exercise_mark, mark, href) for exercise_mark in mark.exercises),
                        assignment_cell(mark, href),
                    ),
                )
            )
        return self._table(f"Notes du devoir « {self._titles[self._query.assignment]} »", columns, cells)

    def _column(
        self,
        sort_key: str,
        title: str,
        summary: MarkStatistics,
        *,
        href: str = "",
        notes: tuple[str, ...] = (),
        about: tuple[str, str] | None = None,
    ) -> MarkColumn:
        return MarkColumn(
            title=title,
            href=href,
            sort_href=self._href(tri=sort_key),
            is_sorted=sort_key == self._query.sort_key,
            notes=notes,
            count=summary.count,
            mean=points_text(summary.mean),
            median=points_text(summary.median),
            about=about,
        )

    def _sorted_rows(self, scores: Mapping[str, Score]) -> Sequence[StudentMarks]:
        """Return the rows of this page, the best first and those without a mark last; without a known sort key, in the
        order of the list of names."""
        rows: Sequence[StudentMarks] = self._gradebook.rows
        score = scores.get(self._query.sort_key)
        if score is not None:
            rows = sorted(rows, key=lambda row: (score(row) is None, -(score(row) or 0.0)))
        first = (self._query.page_number - 1) * STUDENTS_PER_PAGE
        return rows[first : first + STUDENTS_PER_PAGE]

    def _table(
        self, caption: str, columns: Sequence[MarkColumn], rows: Sequence[tuple[StudentMarks, tuple[MarkCell, ...]]]
    ) -> MarkTable:
        return MarkTable(
            caption=caption,
            columns=tuple(columns),
            rows=tuple(MarkRow(row.member.name, cells) for row, cells in rows),
            name_href=self._href(tri=""),
            by_name=not any(column.is_sorted for column in columns),
        )


def _assignment_score(index: int) -> Score:
    return lambda row: row.marks[index].points


def _column_score(index: int) -> Score:
    return lambda row: row.columns[index].typed.points


def _exercise_score(index: int, exercise_index: int) -> Score:
    return lambda row: row.marks[index].exercises[exercise_index].points
