"""From the marks of a class to what the templates show."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime
from functools import lru_cache
from typing import Any
from urllib.parse import urlencode

from markupsafe import Markup

from server.assignments.models import Assignment
from server.base.errors import NotFound
from server.course import Course
from server.desk.marks import kept
from server.desk.marks.schemas import (
    CellView,
    Choice,
    ColumnView,
    GradebookPage,
    GradebookWork,
    MoodleView,
    RowView,
    TableView,
)
from server.desk.views import group_counts, head, href_of, regrade_href
from server.marks.files import (
    ABSENT,
    EXCUSED,
    NOTES,
    MoodleIdentifier,
    column_text,
    mark_cell,
    moodle_file,
    unique_titles,
)
from server.marks.means import format_number, format_points
from server.marks.schemas import (
    AssignmentMark,
    ExerciseMark,
    Gradebook,
    MarkState,
    MarkSummary,
    StudentMarks,
    is_withheld,
    summarise,
)
from server.rights.models import Right
from server.rights.service import Place
from server.web.rendering import environment
from server.web.words import moment, moment_text

NONE = "—"
TOTAL = "moyenne"
A_PAGE = 200  # students
MOST_CELLS = 8192  # kept as they were drawn
UNKNOWN = "La classe n’a pas ce devoir, ou cet élève."
BY = {MoodleIdentifier.email: "par adresse électronique", MoodleIdentifier.id: "par identifiant"}

Score = Callable[[StudentMarks], float | None]


def shown(points: float | None) -> str:
    return NONE if points is None else format_points(points)


class GradebookPageBuilder:
    """The page of a book, as somebody asks for it: a group, one assignment or all, an order, a column to copy.

    `number`, from 1, is that of the page, where the class has more students than one shows.
    """

    def __init__(
        self, place: Place, book: Gradebook, group: str, assignment: str, order: str, to_copy: str, number: int = 1
    ) -> None:
        self.place, self.path = place, f"{href_of(place.school_class)}/carnet"
        self.everyone = book
        labels = group_counts(row.member.groups for row in book.rows)
        self.labels = list(labels.items())
        self.group = group if group in labels else ""
        rows = [row for row in book.rows if not self.group or self.group in row.member.groups]
        self.book = replace(book, rows=tuple(rows))
        self.titles = unique_titles(book.assignments)
        self.place_of = {str(one.id): place for place, one in enumerate(book.assignments)}
        if assignment and assignment not in self.place_of:
            raise NotFound(UNKNOWN)
        self.assignment, self.order, self.to_copy = assignment, order, to_copy
        self.number = min(number, max(1, math.ceil(len(rows) / A_PAGE)))

    def asked(self, **changes: str) -> dict[str, str]:
        asked = {"groupe": self.group, "devoir": self.assignment, "tri": self.order, **changes}
        return {name: value for name, value in asked.items() if value}

    def address(self, **changes: str) -> str:
        """This page with something else asked for."""
        query = urlencode(self.asked(**changes))
        return f"{self.path}?{query}" if query else self.path

    def page(self, course: Course) -> GradebookPage:
        book = self.book
        chosen = self.place_of.get(self.assignment)
        about = None if chosen is None else self._about(book.assignments[chosen])
        asked = (self.group, self.assignment, self.order, self.to_copy, self.number, self.place.may(Right.regrade))
        return GradebookPage(
            head=head(course, self.place, "/carnet"),
            at=moment(book.at),
            at_text=moment_text(book.at),
            total=len(book.rows),
            group=self.group,
            assignment="" if chosen is None else self.titles[chosen],
            assignment_href="" if about is None else about[1],
            back=self.address(devoir="", tri=""),
            work=kept.work(self.everyone, self.path, asked, self._work),
        )

    def _work(self) -> GradebookWork:
        book = self.book
        chosen = self.place_of.get(self.assignment)
        copied = {TOTAL: None, **self.place_of}
        return GradebookWork(
            href=href_of(self.place.school_class),
            total=len(book.rows),
            table=self._overview() if chosen is None else self._of_exercises(chosen),
            everyone=self.address(groupe=""),
            everyone_count=len(self.everyone.rows),
            groups=tuple(
                Choice(self.address(groupe=label), f"{label} ({count})", label == self.group)
                for label, count in self.labels
            ),
            group=self.group,
            kept=tuple(self.asked().items()),
            pages=self._pages(),
            assignments=tuple(
                Choice(name, title, name == self.assignment)
                for name, title in zip(self.place_of, self.titles, strict=True)
            ),
            columns=tuple(
                Choice(name, title, name == self.to_copy)
                for name, title in zip([*self.place_of, TOTAL], [*self.titles, "Moyenne"], strict=True)
            ),
            column=column_text(book, copied[self.to_copy]) if self.to_copy in copied else None,
            moodle=tuple(
                MoodleView(one.value, BY[one], moodle_file(self.everyone, one).left_out) for one in MoodleIdentifier
            ),
            notes=NOTES,
        )

    def _pages(self) -> tuple[Choice, ...]:
        """None where one page is enough."""
        numbers = range(1, math.ceil(len(self.book.rows) / A_PAGE) + 1)
        pages = [Choice(self.address(p=str(number)), str(number), number == self.number) for number in numbers]
        return tuple(pages) if len(pages) > 1 else ()

    def _overview(self) -> TableView:
        book = self.book
        columns = [
            self._column(
                str(one.id),
                title,
                book.summary_of(place),
                href=self.address(devoir=str(one.id), tri=""),
                notes=_notes(one, book.at),
                about=self._about(one),
            )
            for place, (one, title) in enumerate(zip(book.assignments, self.titles, strict=True))
        ]
        columns.append(self._column(TOTAL, "Moyenne", book.averages))
        scores = {name: _at(place) for name, place in self.place_of.items()}
        rows = self._sorted({**scores, TOTAL: lambda row: row.average})
        return self._table("Notes des devoirs", columns, [(row, self._cells(row)) for row in rows])

    def _cells(self, row: StudentMarks) -> tuple[CellView, ...]:
        cells = [
            cell_view(mark, self._detail(row, one)) for mark, one in zip(row.marks, self.book.assignments, strict=True)
        ]
        return (*cells, CellView(shown(row.average)))

    def _detail(self, row: StudentMarks, assignment: Assignment) -> str:
        return f"{self.path}/{row.member.id}/{assignment.id}"

    def _of_exercises(self, place: int) -> TableView:
        book = self.book
        assignment = book.assignments[place]
        exercises = book.exercises[assignment.id]
        regrades = self.place.may(Right.regrade)
        columns = [
            self._column(
                one.exercise,
                book.title_of(one.exercise),
                summarise(
                    [points for row in book.rows if (points := row.marks[place].exercises[n].points) is not None]
                ),
                notes=(f"coefficient {format_number(one.weight)}",),
                about=("recorriger", regrade_href(self.path.removesuffix("/carnet"), one.exercise))
                if regrades
                else None,
            )
            for n, one in enumerate(exercises)
        ]
        columns.append(self._column(TOTAL, "Note du devoir", book.summary_of(place)))
        scores = {one.exercise: _at(place, n) for n, one in enumerate(exercises)}
        rows = self._sorted({**scores, TOTAL: _at(place)})
        told = []
        for row in rows:
            mark, href = row.marks[place], self._detail(row, assignment)
            told.append((row, (*(_exercise_cell(one, mark, href) for one in mark.exercises), cell_view(mark, href))))
        return self._table(f"Notes du devoir « {self.titles[place]} »", columns, told)

    def _about(self, assignment: Assignment) -> tuple[str, str] | None:
        """The page of an assignment; none of what a class without assignments has to do."""
        if assignment.id == self.place.school_class.id:
            return None
        return "le devoir", f"{href_of(self.place.school_class)}/devoirs/{assignment.id}"

    def _column(
        self,
        key: str,
        title: str,
        found: MarkSummary,
        *,
        href: str = "",
        notes: tuple[str, ...] = (),
        about: tuple[str, str] | None = None,
    ) -> ColumnView:
        return ColumnView(
            title=title,
            href=href,
            sort_href=self.address(tri=key),
            is_sorted=key == self.order,
            notes=notes,
            count=found.count,
            mean=shown(found.mean),
            median=shown(found.median),
            about=about,
        )

    def _sorted(self, scores: dict[str, Score]) -> Sequence[StudentMarks]:
        """The best first, who has no mark last; the order of the list between equals, and without a known order."""
        first = (self.number - 1) * A_PAGE
        return self._all_sorted(scores)[first : first + A_PAGE]

    def _all_sorted(self, scores: dict[str, Score]) -> Sequence[StudentMarks]:
        if self.order not in scores:
            return self.book.rows
        score = scores[self.order]

        def key(row: StudentMarks) -> tuple[bool, float]:
            points = score(row)
            return points is None, -(points or 0.0)

        return sorted(self.book.rows, key=key)

    def _table(
        self, caption: str, columns: Sequence[ColumnView], rows: Sequence[tuple[StudentMarks, tuple[CellView, ...]]]
    ) -> TableView:
        return TableView(
            caption=caption,
            columns=tuple(columns),
            rows=tuple(RowView(row.member.name, row.member.groups, _drawn(cells)) for row, cells in rows),
            name_href=self.address(tri=""),
            by_name=not any(one.is_sorted for one in columns),
        )


def _drawn(cells: Sequence[CellView]) -> Markup:
    return Markup("").join(map(_drawn_cell, cells))


@lru_cache(maxsize=MOST_CELLS)
def _drawn_cell(cell: CellView) -> Markup:
    """Most marks of a book are what they were when it was looked at last."""
    macros: Any = environment().get_template("classes/marks.html").module
    return Markup("<td>{}</td>").format(Markup(macros.mark(cell)))


def _at(place: int, exercise: int | None = None) -> Score:
    """The points of an assignment, or of one of its exercises."""

    def score(row: StudentMarks) -> float | None:
        mark = row.marks[place]
        return mark.points if exercise is None else mark.exercises[exercise].points

    return score


def _notes(one: Assignment, now: datetime) -> tuple[str, ...]:
    notes = [f"coefficient {format_number(one.weight)}"]
    if one.due_at is not None:
        notes.append(f"pour le {moment_text(one.due_at).partition(' ')[0]}")
    if is_withheld(one, now):
        notes.append("contrôle, pas encore rendu aux élèves")
    return tuple(notes)


def cell_view(mark: AssignmentMark, href: str) -> CellView:
    found = mark_cell(mark)
    text = found if isinstance(found, str) else NONE if found is None else format_number(found)
    pending = mark.state in {MarkState.open, MarkState.upcoming} and found is not None
    excused = mark.state is MarkState.excused
    return CellView(text, href, 0 if excused else mark.days_late, mark.overridden, mark.stale, pending)


def _exercise_cell(one: ExerciseMark, mark: AssignmentMark, href: str) -> CellView:
    if one.excused or mark.state is MarkState.excused:
        return CellView(EXCUSED, href, changed=one.override is not None, stale=one.stale)
    text = ABSENT if mark.state is MarkState.absent else shown(one.points)
    return CellView(text, href, one.days_late, one.override is not None, one.stale)
