"""Marks as their student sees them, and « Pourquoi cette moyenne ? »: pure."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from server.assignments.models import Assignment
from server.assignments.rules import Rules
from server.marks.means import format_number, format_points
from server.marks.schemas import AssignmentMark, ColumnMark, ExerciseMark, Gradebook, StudentMarks, is_test_withheld
from server.marks.states import STATE_WORDS, MarkState


@dataclass(frozen=True)
class VisibleMark:
    """A mark as its student sees it: None while a test withholds it, or one of its exercises.

    `exercises`: the marks of exercises that are shown all the same.
    """

    assignment: Assignment
    rules: Rules
    mark: AssignmentMark | None
    exercises: Mapping[str, ExerciseMark] = field(default_factory=dict)


@dataclass(frozen=True)
class VisibleMarks:
    """A student's own marks, in the order of the assignments, the average of those that are shown, and its terms."""

    marks: tuple[VisibleMark, ...] = ()
    average: float | None = None
    titles: Mapping[str, str] = field(default_factory=dict)
    columns: tuple[ColumnMark, ...] = ()
    terms: tuple[AverageTerm, ...] = ()

    @staticmethod
    def from_gradebook(gradebook: Gradebook, withheld_exercises: Collection[str]) -> VisibleMarks:
        """Return the marks of the only student of a gradebook, none where it has no row.

        `withheld_exercises`: those of which a test withholds attempts from this student.
        """
        if not gradebook.rows:
            return VisibleMarks()
        gradebook = _keep_concerned_assignments(gradebook)
        (row,) = gradebook.rows
        visible = [
            not is_test_withheld(assignment, gradebook.at)
            and not any(
                exercise.exercise in withheld_exercises for exercise in gradebook.exercises.get(assignment.id, ())
            )
            for assignment in gradebook.assignments
        ]
        published = tuple(mark for mark in row.columns if mark.column.is_published)
        visible_row = StudentMarks(
            row.member,
            tuple(mark for mark, is_visible in zip(row.marks, visible, strict=True) if is_visible),
            tuple(weight for weight, is_visible in zip(row.weights, visible, strict=True) if is_visible),
            published,
        )
        marks = []
        for assignment, mark, is_visible in zip(gradebook.assignments, row.marks, visible, strict=True):
            visible_marks = () if is_test_withheld(assignment, gradebook.at) else mark.exercises
            exercises = {own.exercise: own for own in visible_marks if own.exercise not in withheld_exercises}
            marks.append(VisibleMark(assignment, mark.rules, mark if is_visible else None, exercises))
        titles = [
            assignment.title
            for assignment, is_visible in zip(gradebook.assignments, visible, strict=True)
            if is_visible
        ]
        return VisibleMarks(
            tuple(marks), visible_row.average, gradebook.titles, published, list_average_terms(visible_row, titles)
        )


def _keep_concerned_assignments(gradebook: Gradebook) -> Gradebook:
    """Return the gradebook of one student without the assignments of other groups."""
    (row,) = gradebook.rows
    own = [n for n, mark in enumerate(row.marks) if mark.state is not MarkState.not_concerned]
    if len(own) == len(row.marks):
        return gradebook
    weights = tuple(row.weights[n] for n in own)
    own_row = StudentMarks(row.member, tuple(row.marks[n] for n in own), weights, row.columns)
    return replace(gradebook, rows=(own_row,), assignments=tuple(gradebook.assignments[n] for n in own))


@dataclass(frozen=True)
class AverageTerm:
    """A line of « Pourquoi cette moyenne ? »: a mark as it is shown, and what of it counts (None: it does not)."""

    title: str
    shown: str
    weight: float
    counted: float | None
    bonus: bool = False


def list_average_terms(row: StudentMarks, titles: Sequence[str]) -> tuple[AverageTerm, ...]:
    """Explain a student's average. `titles`: those of the assignments, in the order of the marks."""
    assignments = [
        AverageTerm(title, describe_assignment_mark(mark), weight, mark.points_in_average)
        for title, mark, weight in zip(titles, row.marks, row.weights, strict=True)
    ]
    columns = [
        AverageTerm(
            mark.column.title, describe_column_mark(mark), mark.column.weight, mark.points_in_average, mark.column.bonus
        )
        for mark in row.columns
    ]
    return (*assignments, *columns)


def describe_assignment_mark(mark: AssignmentMark) -> str:
    """Return what a mark is, in words: « 12,5 / 20 », « non rendu », « 8 / 20, en cours »."""
    if mark.state in {MarkState.open, MarkState.upcoming} and mark.points is not None:
        return f"{format_points(mark.points)} / 20, en cours"
    if mark.state is MarkState.done and mark.points is not None:
        return f"{format_points(mark.points)} / 20"
    return STATE_WORDS[mark.state]


def describe_column_mark(mark: ColumnMark) -> str:
    """Return the same of a mark in a column: « 7 / 10 », « absent »."""
    if mark.typed.points is None:
        return STATE_WORDS[mark.state]
    return f"{format_number(mark.typed.points)} / {format_number(mark.column.out_of)}"
