"""The page of one student's mark at one assignment."""

from __future__ import annotations

from server.base.errors import NotFound
from server.course import Course
from server.desk.marks.schemas import ExerciseView, MarkPage, OverrideView
from server.desk.marks.views import UNKNOWN, assignment_cell, points_text
from server.desk.views import class_head
from server.marks.files import EXCUSED, unique_titles
from server.marks.means import format_number, round_points
from server.marks.schemas import AssignmentMark, ExerciseMark, Gradebook, MarkState
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.words import iso_moment, plural, short_moment

STATES = {
    MarkState.upcoming: "pas encore ouvert",
    MarkState.open: "en cours",
    MarkState.done: "fini",
    MarkState.absent: "fini, rien n’a été envoyé",
    MarkState.excused: "dispensé",
}
SENT_AHEAD = ", et déjà travaillé"


def mark_page(course: Course, access: ClassAccess, gradebook: Gradebook, assignment_id: str) -> MarkPage:
    """Build the page from a gradebook of one student. Raise NotFound for an unknown assignment."""
    ids = [str(assignment.id) for assignment in gradebook.assignments]
    if assignment_id not in ids or not gradebook.rows:
        raise NotFound(UNKNOWN)
    index = ids.index(assignment_id)
    (row,) = gradebook.rows
    mark = row.marks[index]
    sent_ahead = mark.state is MarkState.upcoming and mark.points is not None
    return MarkPage(
        head=class_head(course, access, "/carnet"),
        student=row.member.name,
        assignment=unique_titles(gradebook.assignments)[index],
        mark=assignment_cell(mark, ""),
        state=STATES[mark.state] + (SENT_AHEAD if sent_ahead else ""),
        notes=_dates(mark),
        exercises=tuple(_exercise(gradebook, exercise) for exercise in mark.exercises),
        may_change=access.has(Right.change_marks) and access.school_class.archived_at is None,
    )


def _dates(mark: AssignmentMark) -> tuple[str, ...]:
    """Return the dates in force for this student, and how late the work is."""
    dates = (("Ouvre", mark.rules.opens_at), ("À rendre", mark.rules.due_at), ("Ferme", mark.rules.closes_at))
    texts = [f"{word} le {short_moment(date)}" for word, date in dates if date is not None]
    late = [plural(mark.days_late, "jour de retard", "jours de retard")] if mark.days_late else []
    return (*texts, *late)


def _exercise(gradebook: Gradebook, mark: ExerciseMark) -> ExerciseView:
    counted, sent_at = mark.counted, mark.sent_at
    return ExerciseView(
        exercise=mark.exercise,
        title=gradebook.title_of(mark.exercise),
        weight=format_number(mark.weight),
        points=EXCUSED if mark.excused else points_text(mark.points),
        automatic=points_text(mark.effective.automatic),
        late=0 if counted is None else counted.days_late,
        attempts=mark.attempts,
        attempt="" if counted is None else f"/soumissions/{counted.attempt}",
        sent="" if sent_at is None else iso_moment(sent_at),
        sent_text="" if sent_at is None else short_moment(sent_at),
        override=_override(mark),
    )


def _override(mark: ExerciseMark) -> OverrideView | None:
    override = mark.override
    if override is None:
        return None
    text = "dispense" if override.points is None else f"{format_number(round_points(override.points))} / 20"
    return OverrideView(
        text, override.by, iso_moment(override.at), short_moment(override.at), override.reason, mark.stale
    )
