"""From assignments to what the templates of their staff show."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import editing, repository
from server.assignments.models import Assignment, Mode
from server.assignments.rules import Rules, is_assigned_to, rules_in_force
from server.assignments.schemas import AssignmentInput
from server.assignments.stages import AssignmentStage, assignment_stage
from server.assignments.team_repository import load_current_members
from server.assignments.team_rules import team_word
from server.base import school_time
from server.classes import repository as classes
from server.course import Course
from server.database import utc_now
from server.desk import repository as desk
from server.desk import views
from server.desk.assignments import exam_papers, words
from server.desk.assignments.late_line import draw_late_line
from server.desk.assignments.schemas import (
    AssignmentFormPage,
    AssignmentPage,
    AssignmentRow,
    AssignmentsPage,
    AssignmentValues,
    ExerciseOption,
    FormattedDate,
    StageView,
    TeamsSummary,
    WeightedExerciseRow,
)
from server.desk.sitting.views import release_view
from server.marks.rubrics_repository import load_rubric_titles
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.studio import service as studio
from server.web.time_warnings import compute_time_warnings
from server.web.views import exercise_href, exercises_in_reading_order
from server.web.words import format_iso_time, format_long_time, join_names_with_limit

NOBODY = UUID(int=0)
TAB = "/devoirs"
OWN_EXERCISES = "Exercices des enseignants de la classe"


def format_date(date: datetime | None) -> FormattedDate:
    return FormattedDate() if date is None else FormattedDate(format_iso_time(date), format_long_time(date))


def stage_view(at: AssignmentStage) -> StageView:
    sign, name = words.STAGE_WORDS[at]
    return StageView(at.value, sign, name)


def common_rules(frame: Assignment | AssignmentInput) -> Rules:
    """Those of who has no exemption."""
    return rules_in_force(frame, (), NOBODY, ())


def assignment_href(assignment: Assignment) -> str:
    return f"/classes/{assignment.class_id}/devoirs/{assignment.id}"


def build_assignments_page(db: Session, course: Course, access: ClassAccess) -> AssignmentsPage:
    """Seven queries, however many there are."""
    rows = repository.load_class_assignments(db, access.school_class.id)
    names = [assignment.id for assignment in rows]
    exercises, exempted = repository.load_exercises(db, names), repository.count_exemptions(db, names)
    work = _load_class_work(db, access, rows)
    now = utc_now()
    shown = tuple(
        _assignment_row(
            assignment,
            len(exercises.get(assignment.id, ())),
            exempted.get(assignment.id, 0),
            work,
            now,
        )
        for assignment in rows
    )
    given = exam_papers.paper_links(course, access.school_class.module, views.class_href(access.school_class))
    head, zone = views.class_head(course, access, TAB), school_time.time_zone_name()
    removed = repository.load_removed_assignments(db, access.school_class.id) if may_manage(access) else ()
    return AssignmentsPage(head, shown, may_manage(access), zone, given, removed)


@dataclass(frozen=True)
class _ClassWork:
    """By assignment: the students to whom it is given, and those of them who have finished and begun it."""

    students: Mapping[UUID, int]
    finished: Mapping[UUID, int]
    begun: Mapping[UUID, int]


def _load_class_work(db: Session, access: ClassAccess, rows: Sequence[Assignment]) -> _ClassWork:
    """Load it in four queries."""
    class_id, ids = access.school_class.id, [assignment.id for assignment in rows]
    students = classes.load_active_students(db, class_id)
    concerned = {
        assignment.id: {student.id for student in students if is_assigned_to(assignment, student.groups)}
        for assignment in rows
    }
    grouped = [assignment.id for assignment in rows if assignment.groups]
    finished = dict(desk.count_finished_students(db, class_id, [name for name in ids if name not in grouped]))
    for name, student in desk.load_finished_students(db, class_id, grouped) if grouped else ():
        finished[name] = finished.get(name, 0) + (student in concerned[name])
    counts = {name: len(own) for name, own in concerned.items()}
    return _ClassWork(counts, finished, desk.count_begun_students(db, class_id, ids))


def may_manage(access: ClassAccess) -> bool:
    return access.has(Right.manage_assignments) and access.school_class.archived_at is None


def _assignment_row(
    assignment: Assignment, exercises: int, exemptions: int, work: _ClassWork, now: datetime
) -> AssignmentRow:
    return AssignmentRow(
        href=assignment_href(assignment),
        title=assignment.title,
        mode=words.MODE_WORDS[Mode(assignment.mode)],
        is_test=assignment.mode == Mode.test,
        stage=stage_view(assignment_stage(common_rules(assignment), now)),
        opens=format_date(assignment.opens_at),
        due=format_date(assignment.due_at),
        closes=format_date(assignment.closes_at),
        exercises=exercises,
        exemptions=exemptions,
        finished=work.finished.get(assignment.id, 0),
        begun=work.begun.get(assignment.id, 0),
        students=work.students.get(assignment.id, 0),
        groups=tuple(assignment.groups),
    )


def build_assignment_page(db: Session, course: Course, access: ClassAccess, assignment: Assignment) -> AssignmentPage:
    wanted = editing.load_editable_fields(db, assignment)
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    members = classes.load_members(db, access.school_class.id)
    exempted = sum(each.revoked_at is None for each in exemptions)
    work = _load_class_work(db, access, [assignment])
    rubric_titles = load_rubric_titles(db, [assignment.id])
    return AssignmentPage(
        head=views.class_head(course, access, TAB),
        row=_assignment_row(assignment, len(wanted.exercises), exempted, work, utc_now()),
        exercises=tuple(_weighted_exercise_row(course, each.exercise, each.weight) for each in wanted.exercises),
        facts=tuple(_rule_facts(wanted)),
        line=draw_late_line(common_rules(assignment)),
        may_keep=may_manage(access),
        may_compare=access.has(Right.compare_codes),
        release=release_view(db, assignment)
        if assignment.mode == Mode.test and access.has(Right.release_feedback)
        else None,
        warnings=compute_time_warnings(db, assignment, exemptions, members),
        may_mark=access.has(Right.read_marks),
        rubric=rubric_titles.get(assignment.id, ("", False))[0],
        teams=_summarise_teams(db, assignment, work) if assignment.team_size > 1 else None,
    )


def _summarise_teams(db: Session, assignment: Assignment, work: _ClassWork) -> TeamsSummary:
    current = load_current_members(db, assignment.id)
    alone = work.students.get(assignment.id, 0) - len(current)
    word = f"{team_word(assignment.team_size)}s"
    return TeamsSummary(word, len({member.team_id for member in current}), max(0, alone))


def _weighted_exercise_row(course: Course, name: str, weight: float) -> WeightedExerciseRow:
    exercise = course.exercises.get(name)
    if exercise is None:
        return WeightedExerciseRow(f"{name} (n’est plus dans le cours)", "", words.format_number(weight))
    return WeightedExerciseRow(exercise.title, exercise_href(exercise), words.format_number(weight))


def _rule_facts(wanted: AssignmentInput) -> list[tuple[str, str]]:
    facts = [
        ("Donné à", f"{join_names_with_limit(wanted.groups)}" if wanted.groups else "toute la classe"),
        ("Mode", words.MODE_WORDS[wanted.mode]),
        ("Rendu", words.TEAM_SIZE_WORDS[str(wanted.team_size)]),
        ("En retard", words.describe_late_policy(wanted.late, wanted.late_per_day)),
        ("Essai retenu", words.SELECTION_WORDS[wanted.counts]),
        ("Coefficient", words.format_number(wanted.weight)),
        ("Indices", words.VISIBILITY_WORDS[wanted.hints]),
        ("Diagnostic", words.VISIBILITY_WORDS[wanted.diagnosis]),
        ("Corrigé", words.VISIBILITY_WORDS[wanted.solution]),
    ]
    if wanted.duration_minutes is not None:
        facts.insert(2, ("Durée", words.format_duration(wanted.duration_minutes)))
    return facts


def build_form_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    values: AssignmentValues,
    *,
    assignment: Assignment | None = None,
    problems: Mapping[str, str] | None = None,
    drawn: AssignmentInput | None = None,
    version: str = "",
) -> AssignmentFormPage:
    """Build the form of a new assignment, or of `assignment` in this version; `drawn` is what the line shows."""
    home = f"{views.class_href(access.school_class)}/devoirs"
    return AssignmentFormPage(
        head=views.class_head(course, access, TAB),
        action=home if assignment is None else f"{assignment_href(assignment)}/modifier",
        back=home if assignment is None else assignment_href(assignment),
        is_new=assignment is None,
        version=version,
        values=values,
        choices=tuple(_exercise_options(db, course, access, values.weights)),
        problems=problems or {},
        line=None if drawn is None else draw_late_line(common_rules(drawn)),
        zone=school_time.time_zone_name(),
        counts=tuple((selection.value, told) for selection, told in words.SELECTION_WORDS.items()),
        team_sizes=tuple(words.TEAM_SIZE_WORDS.items()),
        shown=tuple((visibility.value, told) for visibility, told in words.VISIBILITY_WORDS.items()),
        groups=_group_sizes(db, access, values.groups),
    )


def _group_sizes(db: Session, access: ClassAccess, chosen: Collection[str]) -> Mapping[str, int]:
    """Return the number of students of each group, also of chosen ones that have become empty."""
    students = classes.load_active_students(db, access.school_class.id)
    return dict.fromkeys(chosen, 0) | views.count_students_by_label(student.groups for student in students)


def _exercise_options(
    db: Session, course: Course, access: ClassAccess, chosen: Mapping[str, str]
) -> Sequence[ExerciseOption]:
    """In the order in which one meets them; the teachers' own; then those that have left the course, and were given."""
    module = course.modules.get(access.school_class.module)
    exercises = [] if module is None else exercises_in_reading_order(module)
    labels = {} if module is None else {lesson.slug: lesson.label for lesson in module.lessons}
    found, last = [], ""
    for each in exercises:
        after = labels.get(each.seance, "Sans séance")
        weight = chosen.get(each.id, "1")
        found.append(ExerciseOption(each.id, each.title, each.id in chosen, weight, "" if after == last else after))
        last = after
    own = studio.list_exercises_of_class_teachers(db, access.school_class)
    own = dict(own) | {
        name: course.title_of_exercise(name) for name in chosen if name in course.exercises and name not in own
    }
    known = {each.id for each in exercises}
    for name, title in own.items():
        if name not in known:
            head = "" if last == OWN_EXERCISES else OWN_EXERCISES
            found.append(ExerciseOption(name, title, name in chosen, chosen.get(name, "1"), head))
            known.add(name)
            last = OWN_EXERCISES
    gone = [name for name in chosen if name not in known]
    return [*found, *(ExerciseOption(name, f"{name} (n’est plus dans le cours)", True, chosen[name]) for name in gone)]
