"""The pages of one student's mark at one assignment, and of one student's average."""

from __future__ import annotations

from collections.abc import Mapping

from server.base.errors import NotFound
from server.course import Course
from server.desk.marks.cells import COUNTS_ZERO, assignment_cell, cell_text, counts_as_blank, points_text
from server.desk.marks.schemas import AveragePage, ExerciseView, MarkForm, MarkPage
from server.desk.marks.views import UNKNOWN
from server.desk.views import class_head
from server.marks.files import distinct_assignment_titles, exercise_value_cell
from server.marks.means import format_number
from server.marks.own import list_average_terms
from server.marks.schemas import ActiveDecision, ActiveOverride, AssignmentMark, Gradebook
from server.marks.states import DecidedState, MarkState
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.form_version import form_version_tag
from server.web.words import count_with_noun, format_short_time

#: What is said beside the mark itself, which says the state where there are no points.
STATE_DETAILS: Mapping[MarkState, str] = {
    MarkState.upcoming: "pas encore ouvert",
    MarkState.open: "en cours",
    MarkState.done: "fini",
    MarkState.not_handed_in: "fini, rien n’a été envoyé",
    MarkState.late_refused: "fini, tout est venu trop tard",
    MarkState.not_concerned: "donné à d’autres groupes",
}
WHOLE = "Tout le devoir"
DECISION_WORDS: Mapping[str, str] = {
    DecidedState.absent: "absent",
    DecidedState.excused: "dispensé",
    DecidedState.zero: "compte 0",
}
SENT_AHEAD = "pas encore ouvert, et déjà travaillé"


def mark_page(course: Course, access: ClassAccess, gradebook: Gradebook, assignment_id: str) -> MarkPage:
    """Build the page from a gradebook of one student. Raise NotFound for an unknown assignment."""
    ids = [str(assignment.id) for assignment in gradebook.assignments]
    if assignment_id not in ids or not gradebook.rows:
        raise NotFound(UNKNOWN)
    index = ids.index(assignment_id)
    (row,) = gradebook.rows
    mark, titles = row.marks[index], distinct_assignment_titles(gradebook.assignments)
    is_open = access.school_class.archived_at is None and mark.state is not MarkState.not_concerned
    may_change = access.has(Right.change_marks) and is_open
    is_assignment = gradebook.assignments[index].id != access.school_class.id
    asking: dict[str, list[str]] = {}
    for title, assignment in zip(titles, gradebook.assignments, strict=True):
        for exercise in gradebook.exercises[assignment.id]:
            if assignment.id != gradebook.assignments[index].id:
                asking.setdefault(exercise.exercise, []).append(title)
    return MarkPage(
        head=class_head(course, access, "/carnet"),
        student=row.member.name,
        assignment=titles[index],
        cell=assignment_cell(mark, ""),
        mark=mark,
        notes=_mark_notes(mark),
        exercises=tuple(
            ExerciseView(
                title=gradebook.exercise_title(exercise.exercise),
                points=cell_text(exercise_value_cell(exercise, mark)),
                counts=COUNTS_ZERO if counts_as_blank(exercise, mark) else "",
                mark=exercise,
                others=tuple(asking.get(exercise.exercise, ())),
            )
            for exercise in mark.exercises
        ),
        may_change=may_change,
        may_decide=may_change and is_assignment,
        version=form_version_tag(stored_texts(gradebook, assignment_id)),
    )


def _mark_notes(mark: AssignmentMark) -> tuple[str, ...]:
    """Return the state in full, the dates in force for this student, and how late the work is."""
    sent_ahead = mark.state is MarkState.upcoming and mark.points is not None
    detail = SENT_AHEAD if sent_ahead else STATE_DETAILS.get(mark.state, "")
    dates = (("Ouvre", mark.rules.opens_at), ("Date limite", mark.rules.due_at), ("Ferme", mark.rules.closes_at))
    texts = [f"{word} le {format_short_time(date)}" for word, date in dates if date is not None]
    late = count_with_noun(mark.days_late, "jour de retard", "jours de retard") if mark.days_late else ""
    return tuple(text for text in (detail, *texts, late) if text)


def stored_texts(gradebook: Gradebook, assignment_id: str) -> Mapping[str, str]:
    """Return what teachers have set for one student at one assignment, by exercise; empty where nothing is set."""
    for row in gradebook.rows:
        for assignment, mark in zip(gradebook.assignments, row.marks, strict=True):
            if str(assignment.id) == assignment_id:
                texts = {each.exercise: _override_text(each.override) for each in mark.exercises}
                return {WHOLE: "" if mark.decision is None else _decision_text(mark.decision), **texts}
    return {}


def _override_text(override: ActiveOverride | None) -> str:
    if override is None:
        return ""
    scope = "" if override.assignment_id is None else ", dans ce devoir"
    points = "dispense" if override.points is None else format_number(override.points)
    return f"{points}{scope} ({override.by or 'compte effacé'}, {format_short_time(override.at)}) : {override.reason}"


def _decision_text(decision: ActiveDecision) -> str:
    return f"{DECISION_WORDS[decision.state]} ({decision.by or 'compte effacé'}, {format_short_time(decision.at)})"


def changed_texts(stored: Mapping[str, str], state: str, form: MarkForm) -> list[tuple[str, str, str]]:
    """Return label, stored and typed text of what a form is about."""
    name = form.exercise or WHOLE
    typed = " ".join(filter(None, (DECISION_WORDS.get(state, ""), form.points, form.reason)))
    return [(name, stored.get(name, ""), typed)]


def average_page(course: Course, access: ClassAccess, gradebook: Gradebook) -> AveragePage:
    """Build « Pourquoi cette moyenne ? » from a gradebook of one student. Raise NotFound where there is none."""
    if not gradebook.rows:
        raise NotFound(UNKNOWN)
    (row,) = gradebook.rows
    return AveragePage(
        head=class_head(course, access, "/carnet"),
        student=row.member.name,
        average=points_text(row.average),
        terms=list_average_terms(row, distinct_assignment_titles(gradebook.assignments)),
    )
