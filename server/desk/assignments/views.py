"""From assignments to what the templates of their staff show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import editing, repository
from server.assignments.models import Assignment, Mode
from server.assignments.rules import Rules, rules_in_force
from server.assignments.schemas import AssignmentInput
from server.assignments.stages import AssignmentStage, assignment_stage
from server.classes import repository as classes
from server.course import Course
from server.database import utc_now
from server.desk import repository as desk
from server.desk import views
from server.desk.assignments import papers, words
from server.desk.assignments.late_line import line_of
from server.desk.assignments.schemas import (
    AssignmentFormPage,
    AssignmentPage,
    AssignmentRow,
    AssignmentsPage,
    AssignmentValues,
    Choice,
    StageView,
    WeightedRow,
    When,
)
from server.desk.sitting.views import release_view
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web import school_time
from server.web.views import exercise_href, exercises_in_reading_order
from server.web.words import iso_moment, long_moment

NOBODY = UUID(int=0)
TAB = "/devoirs"


def when(date: datetime | None) -> When:
    return When() if date is None else When(iso_moment(date), long_moment(date))


def stage_view(at: AssignmentStage) -> StageView:
    sign, name = words.STAGES[at]
    return StageView(at.value, sign, name)


def common_rules(frame: Assignment | AssignmentInput) -> Rules:
    """Those of who has no exemption."""
    return rules_in_force(frame, (), NOBODY, ())


def href_of(assignment: Assignment) -> str:
    return f"/classes/{assignment.class_id}/devoirs/{assignment.id}"


def assignments_page(db: Session, course: Course, place: ClassAccess) -> AssignmentsPage:
    """Six queries, however many there are."""
    rows = repository.load_class_assignments(db, place.school_class.id)
    names = [one.id for one in rows]
    exercises, exempted = repository.load_exercises(db, names), repository.count_exemptions(db, names)
    finished = desk.finished(db, place.school_class.id, names)
    now = utc_now()
    shown = tuple(
        _row(one, len(exercises.get(one.id, ())), exempted.get(one.id, 0), finished.get(one.id, 0), now) for one in rows
    )
    students = classes.count_students(db, [place.school_class.id])[place.school_class.id][0]
    given = papers.links(course, place.school_class.module, views.href_of(place.school_class))
    head, zone = views.head(course, place, TAB), school_time.time_zone_name()
    return AssignmentsPage(head, shown, students, may_keep(place), zone, given)


def may_keep(place: ClassAccess) -> bool:
    return place.has(Right.manage_assignments) and place.school_class.archived_at is None


def _row(one: Assignment, exercises: int, exemptions: int, finished: int, now: datetime) -> AssignmentRow:
    return AssignmentRow(
        href=href_of(one),
        title=one.title,
        mode=words.MODES[Mode(one.mode)],
        is_test=one.mode == Mode.test,
        stage=stage_view(assignment_stage(common_rules(one), now)),
        opens=when(one.opens_at),
        due=when(one.due_at),
        closes=when(one.closes_at),
        exercises=exercises,
        exemptions=exemptions,
        finished=finished,
    )


def assignment_page(db: Session, course: Course, place: ClassAccess, one: Assignment) -> AssignmentPage:
    wanted = editing.load_assignment_input(db, one)
    exempted = repository.count_exemptions(db, [one.id]).get(one.id, 0)
    finished = desk.finished(db, place.school_class.id, [one.id]).get(one.id, 0)
    return AssignmentPage(
        head=views.head(course, place, TAB),
        row=_row(one, len(wanted.exercises), exempted, finished, utc_now()),
        exercises=tuple(_weighted(course, each.exercise, each.weight) for each in wanted.exercises),
        facts=tuple(_facts(wanted)),
        line=line_of(common_rules(one)),
        students=classes.count_students(db, [place.school_class.id])[place.school_class.id][0],
        may_keep=may_keep(place),
        may_compare=place.has(Right.compare_codes),
        release=release_view(db, one) if one.mode == Mode.test and place.has(Right.release_feedback) else None,
    )


def _weighted(course: Course, name: str, weight: float) -> WeightedRow:
    exercise = course.exercises.get(name)
    if exercise is None:
        return WeightedRow(f"{name} (n’est plus dans le cours)", "", words.number(weight))
    return WeightedRow(exercise.title, exercise_href(exercise), words.number(weight))


def _facts(wanted: AssignmentInput) -> list[tuple[str, str]]:
    facts = [
        ("Mode", words.MODES[wanted.mode]),
        ("En retard", words.lateness(wanted.late, wanted.late_per_day)),
        ("Ce qui compte", words.COUNTS[wanted.counts]),
        ("Coefficient", words.number(wanted.weight)),
        ("Indices", words.SHOWN[wanted.hints]),
        ("Diagnostic", words.SHOWN[wanted.diagnosis]),
        ("Corrigé", words.SHOWN[wanted.solution]),
    ]
    if wanted.duration_minutes is not None:
        facts.insert(1, ("Durée", words.duration(wanted.duration_minutes)))
    return facts


def form_page(
    course: Course,
    place: ClassAccess,
    values: AssignmentValues,
    *,
    one: Assignment | None = None,
    problems: Mapping[str, str] | None = None,
    drawn: AssignmentInput | None = None,
) -> AssignmentFormPage:
    """To make an assignment, or to change `one`; `drawn` is what the line shows."""
    home = f"{views.href_of(place.school_class)}/devoirs"
    return AssignmentFormPage(
        head=views.head(course, place, TAB),
        action=home if one is None else f"{href_of(one)}/modifier",
        back=home if one is None else href_of(one),
        is_new=one is None,
        values=values,
        choices=tuple(_choices(course, place, values.weights)),
        problems=problems or {},
        line=None if drawn is None else line_of(common_rules(drawn)),
        zone=school_time.time_zone_name(),
        counts=tuple((one.value, told) for one, told in words.COUNTS.items()),
        shown=tuple((one.value, told) for one, told in words.SHOWN.items()),
    )


def _choices(course: Course, place: ClassAccess, chosen: Mapping[str, str]) -> Sequence[Choice]:
    """In the order in which one meets them; then those that have left the course, and were given."""
    module = course.modules.get(place.school_class.module)
    exercises = [] if module is None else exercises_in_reading_order(module)
    labels = {} if module is None else {lesson.slug: lesson.label for lesson in module.lessons}
    found, last = [], ""
    for each in exercises:
        after = labels.get(each.seance, "Sans séance")
        weight = chosen.get(each.id, "1")
        found.append(Choice(each.id, each.title, each.id in chosen, weight, "" if after == last else after))
        last = after
    known = {each.id for each in exercises}
    gone = [name for name in chosen if name not in known]
    return [*found, *(Choice(name, f"{name} (n’est plus dans le cours)", True, chosen[name]) for name in gone)]
