"""From the state of a lesson to its page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.base import school_time
from server.board import lesson_loading
from server.board.lesson_state import LessonMistake, LessonState
from server.board.progress import ClassProgress
from server.board.schemas import FEWEST_TO_PROJECT
from server.board.service import load_class_progress
from server.board.stuck import StuckStudent
from server.classes.models import SchoolClass
from server.course import Course
from server.desk.assignments.words import format_duration
from server.desk.board.links import BoardLinks, misconception_href
from server.desk.lesson.remedial import remedial_href
from server.desk.lesson.schemas import (
    DayExercise,
    ExerciseChoice,
    LessonForm,
    LessonPage,
    LessonParts,
    MistakeRow,
    StartPage,
)
from server.desk.lesson.stuck_rows import build_stuck_rows, mistake_title
from server.desk.views import class_head, class_href
from server.lesson import repository, service
from server.lesson.models import Afterwards, LiveLesson
from server.lesson.service import LessonPlan
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.rendering import jinja_environment

SHOWN_STUCK = 5
SHOWN_LESSONS = 10
NEXT_WORDS = {
    Afterwards.none: "rien de particulier",
    Afterwards.help: "aider un camarade",
    Afterwards.challenge: "défi : {title}",
}


def lesson_page(
    db: Session, course: Course, access: ClassAccess, lesson: LiveLesson, now: datetime, refused: LessonForm | None
) -> LessonPage:
    """Build the page of a lesson that goes on; `refused`: the form as it was sent, with the reason."""
    school_class = access.school_class
    progress = load_class_progress(db, course, school_class, now, besides=lesson.exercises)
    return LessonPage(
        head=class_head(course, access, "/seance"),
        loaded=school_time.format_hour(school_time.to_local(now)),
        parts=lesson_parts(db, progress, school_class, lesson),
        form=refused or lesson_form(db, course, school_class, now, current_plan(lesson)),
        may_run=access.has(Right.run_lessons),
        may_comment=access.has(Right.comment),
        may_assign=access.has(Right.manage_assignments),
        stream=f"{class_href(school_class)}/seance/evenements",
    )


def current_plan(lesson: LiveLesson) -> LessonPlan:
    return LessonPlan(tuple(lesson.exercises), Afterwards(lesson.next_step), lesson.challenge or "")


def start_page(
    db: Session, course: Course, access: ClassAccess, now: datetime, refused: LessonForm | None
) -> StartPage:
    """Build the page of a class in which no lesson goes on."""
    school_class = access.school_class
    progress = load_class_progress(db, course, school_class, now)
    available = service.list_available_exercises(db, course, school_class, now)
    proposed = LessonPlan(lesson_loading.propose_lesson_exercises(progress, available))
    past = repository.load_lessons(db, school_class.id)[:SHOWN_LESSONS]
    return StartPage(
        head=class_head(course, access, "/seance"),
        form=refused or _build_lesson_form(course, available, proposed, ""),
        may_run=access.has(Right.run_lessons) and school_class.archived_at is None,
        has_students=bool(progress.students),
        past=tuple((f"{class_href(school_class)}/seance/{row.id}", row.started_at) for row in past),
    )


def lesson_form(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, plan: LessonPlan, problem: str = ""
) -> LessonForm:
    available = service.list_available_exercises(db, course, school_class, now)
    return _build_lesson_form(course, available, plan, problem)


def _build_lesson_form(course: Course, available: Sequence[str], plan: LessonPlan, problem: str) -> LessonForm:
    listed = [*available, *(name for name in plan.exercises if name not in available)]
    choices = [
        ExerciseChoice(name, course.title_of_exercise(name), name in plan.exercises, _stars_of_exercise(course, name))
        for name in listed
    ]
    return LessonForm(tuple(choices), plan.next_step, plan.challenge, problem)


def _stars_of_exercise(course: Course, exercise: str) -> int:
    served = course.exercises.get(exercise)
    return served.stars if served else 0


def lesson_parts(db: Session, progress: ClassProgress, school_class: SchoolClass, lesson: LiveLesson) -> LessonParts:
    """Build what changes on the page, for the attempts of `progress`."""
    state = lesson_loading.load_lesson_state(db, progress, lesson)
    links = BoardLinks(progress.course, class_href(school_class), progress.students)
    names = {student.id: student.name for student in progress.students}
    stuck = {row.account: row for row in state.stuck}
    helpers = state.helpers if lesson.next_step == Afterwards.help else {}
    return LessonParts(
        elapsed=format_duration((progress.now - lesson.started_at).total_seconds() / 60),
        stuck=build_stuck_rows(db, progress, links, names, state, helpers, SHOWN_STUCK),
        more_stuck=tuple(names[row.account] for row in state.stuck[SHOWN_STUCK:]),
        mistakes=tuple(_mistake_row(progress, links, names, stuck, mistake) for mistake in state.mistakes),
        more_mistakes=state.more_mistakes,
        overcome=tuple(
            (mistake_title(progress.course, row.exercise, row.id), misconception_href(links.href, row.exercise, row.id))
            for row in state.overcome
        ),
        finished=tuple(names[account] for account in reversed(state.finished)),
        absent=tuple(names[account] for account in state.absent),
        working=tuple(names[account] for account in state.working),
        exercises=_day_exercises(links, state),
        next_words=next_words(progress.course, lesson),
    )


def next_words(course: Course, lesson: LiveLesson) -> str:
    """Say what a student gets who has finished."""
    return NEXT_WORDS[Afterwards(lesson.next_step)].format(title=course.title_of_exercise(lesson.challenge or ""))


def _mistake_row(
    progress: ClassProgress,
    links: BoardLinks,
    names: Mapping[UUID, str],
    stuck: Mapping[UUID, StuckStudent],
    mistake: LessonMistake,
) -> MistakeRow:
    """Build the row of a mistake; the stuck are named first, the longest first."""
    href = misconception_href(links.href, mistake.exercise, mistake.id)
    held = [row for row in stuck.values() if row.account in mistake.still and row.exercise == mistake.exercise]
    held.sort(key=lambda row: row.since)
    others = [account for account in mistake.still if account not in {row.account for row in held}]
    return MistakeRow(
        title=mistake_title(progress.course, mistake.exercise, mistake.id),
        exercise=links.title(mistake.exercise),
        still=(
            *(names[row.account] for row in held),
            *(names[account] for account in others),
        ),
        made=mistake.made,
        href=href,
        project_href=f"{href}/projeter" if mistake.has_enough_students_to_project else "",
        fewest=FEWEST_TO_PROJECT,
        remedial_href=remedial_href(links.href, mistake.exercise, sorted(mistake.still)),
    )


def _day_exercises(links: BoardLinks, state: LessonState) -> tuple[DayExercise, ...]:
    return tuple(
        DayExercise(
            links.title(count.exercise), links.exercise_href(count.exercise), count.solved, count.trying, count.students
        )
        for count in state.exercises
    )


def render_parts(parts: LessonParts, access: ClassAccess) -> Mapping[str, str]:
    """Render each part of the page that its stream replaces."""
    macros: Any = jinja_environment().get_template("classes/lesson_parts.html").module
    return {
        "clock": str(macros.clock(parts)),
        "tabs": str(macros.tabs(parts)),
        "days": str(macros.days(parts)),
        "stuck": str(macros.stuck(parts, access.has(Right.run_lessons), access.has(Right.comment))),
        "mistakes": str(macros.mistakes(parts, access.has(Right.manage_assignments))),
        "finished": str(macros.finished(parts)),
    }


def render_wall(parts: LessonParts) -> Mapping[str, str]:
    """Render the parts of the view for the projector: numbers alone."""
    macros: Any = jinja_environment().get_template("classes/lesson_parts.html").module
    return {"wall": str(macros.wall(parts))}
