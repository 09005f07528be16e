"""Marks as the cells of the gradebook's pages."""

from __future__ import annotations

from datetime import datetime

from server.assignments.models import Assignment
from server.desk.marks.schemas import MarkCell
from server.marks.cells import Cell
from server.marks.files import assignment_value_cell, column_value_cell, exercise_value_cell
from server.marks.means import format_number, format_points
from server.marks.schemas import AssignmentMark, ColumnMark, ColumnRecord, ExerciseMark, is_test_withheld
from server.marks.states import UNMARKED_STATES, WHOLE_STATES, Counting, MarkState
from server.web.words import format_short_time, join_names_with_limit

NO_POINTS = "—"
COUNTS_ZERO = "compte 0"


def points_text(points: float | None) -> str:
    return NO_POINTS if points is None else format_points(points)


def assignment_notes(assignment: Assignment, now: datetime) -> tuple[str, ...]:
    notes = [f"coefficient {format_number(assignment.weight)}"]
    if assignment.groups:
        notes.append(f"pour {join_names_with_limit(assignment.groups)}")
    if assignment.due_at is not None:
        notes.append(f"pour le {format_short_time(assignment.due_at).partition(' ')[0]}")
    if is_test_withheld(assignment, now):
        notes.append("contrôle, pas encore publié")
    return tuple(notes)


def column_notes(column: ColumnRecord) -> tuple[str, ...]:
    notes = ["s’ajoute à la moyenne" if column.bonus else f"coefficient {format_number(column.weight)}"]
    if column.taken_on is not None:
        notes.append(f"du {column.taken_on:%d/%m/%Y}")
    if column.published_at is None:
        notes.append("pas encore publiée aux élèves")
    return tuple(notes)


def cell_text(cell: Cell) -> str:
    """Return a cell as pages show it: points in French, a state in words, « — » for nothing."""
    return NO_POINTS if cell in {None, ""} else cell if isinstance(cell, str) else format_number(cell or 0.0)


def assignment_cell(mark: AssignmentMark, href: str) -> MarkCell:
    pending = mark.state in {MarkState.open, MarkState.upcoming} and mark.points is not None
    return MarkCell(
        text=cell_text(assignment_value_cell(mark)),
        href=href,
        late=0 if mark.state in WHOLE_STATES else mark.days_late,
        changed=mark.has_override_or_decision,
        stale=mark.stale,
        pending=pending,
        state=mark.state,
        counts=COUNTS_ZERO if mark.state in UNMARKED_STATES and mark.points is not None else "",
    )


def exercise_mark_cell(exercise: ExerciseMark, mark: AssignmentMark, href: str) -> MarkCell:
    state = exercise.state_within(mark.state)
    late = 0 if state in WHOLE_STATES else exercise.days_late
    text = cell_text(exercise_value_cell(exercise, mark))
    counts = COUNTS_ZERO if counts_as_blank(exercise, mark) else ""
    return MarkCell(text, href, late, exercise.override is not None, exercise.stale, state=state, counts=counts)


def counts_as_blank(exercise: ExerciseMark, mark: AssignmentMark) -> bool:
    """Whether an exercise without points counts 0 in an assignment that was handed in."""
    is_blank = mark.state is MarkState.done and exercise.state_within(mark.state) in UNMARKED_STATES
    return is_blank and not mark.has_no_end and mark.marking.unanswered is Counting.zero


def column_mark_cell(mark: ColumnMark, href: str) -> MarkCell:
    counts = COUNTS_ZERO if mark.state in UNMARKED_STATES and mark.points_in_average is not None else ""
    return MarkCell(cell_text(column_value_cell(mark)), href, state=mark.state, counts=counts)
