"""One mark of a gradebook, and what is set in its place, as its page shows it."""

from __future__ import annotations

from server.base.errors import NotFound
from server.course import Course
from server.desk.marks.schemas import ExerciseView, MarkPage, OverrideView
from server.desk.marks.views import UNKNOWN, assignment_cell, points_text
from server.desk.views import head, href_of
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
AHEAD = ", et déjà travaillé"


def mark_page(course: Course, place: ClassAccess, book: Gradebook, assignment: str) -> MarkPage:
    """Of one student at one assignment. Raises NotFound."""
    at = next((n for n, one in enumerate(book.assignments) if str(one.id) == assignment), None)
    if at is None or not book.rows:
        raise NotFound(UNKNOWN)
    (row,) = book.rows
    mark = row.marks[at]
    path = f"{href_of(place.school_class)}/carnet"
    return MarkPage(
        head=head(course, place, "/carnet"),
        student=row.member.name,
        assignment=unique_titles(book.assignments)[at],
        path=f"{path}/{row.member.id}/{assignment}",
        mark=assignment_cell(mark, ""),
        state=STATES[mark.state] + (AHEAD if mark.state is MarkState.upcoming and mark.points is not None else ""),
        notes=_rules(mark),
        exercises=tuple(_exercise(book, one) for one in mark.exercises),
        may_change=place.has(Right.change_marks) and place.school_class.archived_at is None,
    )


def _rules(mark: AssignmentMark) -> tuple[str, ...]:
    """The dates in force for this student."""
    dates = (("Ouvre", mark.rules.opens_at), ("À rendre", mark.rules.due_at), ("Ferme", mark.rules.closes_at))
    told = [f"{word} le {short_moment(at)}" for word, at in dates if at is not None]
    return (*told, plural(mark.days_late, "jour de retard", "jours de retard")) if mark.days_late else tuple(told)


def _exercise(book: Gradebook, one: ExerciseMark) -> ExerciseView:
    counted, sent = one.counted, one.sent_at
    return ExerciseView(
        exercise=one.exercise,
        title=book.title_of(one.exercise),
        weight=format_number(one.weight),
        points=EXCUSED if one.excused else points_text(one.points),
        automatic=points_text(one.effective.automatic),
        late=0 if counted is None else counted.days_late,
        attempts=one.attempts,
        attempt="" if counted is None else f"/soumissions/{counted.attempt}",
        sent="" if sent is None else iso_moment(sent),
        sent_text="" if sent is None else short_moment(sent),
        override=_override(one),
    )


def _override(one: ExerciseMark) -> OverrideView | None:
    found = one.override
    if found is None:
        return None
    text = "dispense" if found.points is None else f"{format_number(round_points(found.points))} / 20"
    return OverrideView(text, found.by, iso_moment(found.at), short_moment(found.at), found.reason, one.stale)
