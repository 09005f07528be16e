"""Builds the contexts of the pages of objectives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import groupby
from typing import Any
from uuid import UUID

from markupsafe import Markup
from sqlalchemy.orm import Session

from server.base import school_time
from server.board.catalogue import find_misconception
from server.board.objective_loading import ClassObjectives, load_student_objective_states
from server.board.objectives import RULE, ClassObjective, Mastery
from server.board.schemas import FEWEST_FOR_A_SHARE
from server.board.service import load_class_progress
from server.classes.models import SchoolClass
from server.course import Course
from server.course.kinds import SEANCE
from server.course.models import Lesson
from server.desk.board.links import BoardLinks, misconception_href
from server.desk.schemas import ClassHead
from server.desk.views import class_head, class_href
from server.rights.service import ClassAccess
from server.web.fragments import FRAGMENTS
from server.web.own_objectives import (
    SHOWN_STATES,
    SIGNS,
    WORDS,
    LessonObjectiveGroup,
    Link,
    StudentObjectiveRow,
    build_objective_row,
    count_states_in_words,
    find_lesson,
    group_objectives_by_lesson,
    lesson_title,
)
from server.web.rendering import jinja_environment

WEEK, WEEKS_SHOWN = timedelta(days=7), 6
MAX_NEXT_STEPS = 3
MAX_MISTAKES = 4

#: The order in which a student goes on: what went wrong, what was begun, what comes next.
NEXT_ORDER = {Mastery.weak: 0, Mastery.started: 1, Mastery.none: 2}


@dataclass(frozen=True)
class ClassObjectiveGroup:
    """The objectives of one lesson in a class, unfolded where `is_open`; `rows`: rendered `ObjectiveRow`s."""

    title: str
    is_open: bool
    rows: tuple[Markup, ...]


@dataclass(frozen=True)
class StateCount:
    """The students of a class in one state: `share` is for the width of a bar, `people` their names and pages."""

    state: Mastery
    sign: str
    word: str
    count: int
    share: float
    people: tuple[Link, ...]


@dataclass(frozen=True)
class ObjectiveRow:
    """An objective in a class. `percent`: of those who have begun it, who have mastered it; empty for few students."""

    id: str
    short: str
    text: str
    counts: tuple[StateCount, ...]
    weekly: str
    percent: str
    exercises: tuple[Link, ...]
    mistakes: tuple[tuple[str, str, int], ...]


@dataclass(frozen=True)
class ClassObjectivesPage:
    head: ClassHead
    has_students: bool
    body: Markup


@dataclass(frozen=True)
class StudentObjectivesPage:
    """The objectives of a student; `is_own`: read by the student."""

    head: ClassHead
    name: str
    href: str
    is_own: bool
    groups: tuple[LessonObjectiveGroup, ...]
    steps: tuple[StudentObjectiveRow, ...]
    counts: str
    rule: str
    gone: str = ""


def load_class_objectives(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> ClassObjectives:
    return ClassObjectives(load_class_progress(db, course, school_class, now), school_class.module)


def build_class_page(db: Session, course: Course, access: ClassAccess, now: datetime) -> ClassObjectivesPage:
    """Build the page of a class; its body is rendered anew where something changed, or a day has gone by."""
    loaded = load_class_objectives(db, course, access.school_class, now)
    today = school_time.to_local(loaded.progress.now).date()
    key = ("objectives", loaded.progress.version, today, school_time.time_zone().key)
    return ClassObjectivesPage(
        head=class_head(course, access, "/objectifs"),
        has_students=bool(loaded.progress.students),
        body=FRAGMENTS.get_or_render(key, lambda: _render_body(loaded, access.school_class)),
    )


def _render_body(loaded: ClassObjectives, school_class: SchoolClass) -> str:
    progress = loaded.progress
    links = BoardLinks(progress.course, class_href(school_class), progress.students)
    week_ends = [progress.now - WEEK * weeks for weeks in reversed(range(WEEKS_SHOWN))]
    people = {student.id: (student.name, f"{links.href}/eleves/{student.id}/objectifs") for student in links.students}
    macros: Any = jinja_environment().get_template("classes/objective_parts.html").module

    def render(objective: ClassObjective) -> Markup:
        """Render what most verdicts leave as it was only where it is not cached."""
        row = _class_row(links, people, objective)
        return FRAGMENTS.get_or_render(("objective row", row), lambda: str(macros.class_objective(row)))

    groups = [
        ClassObjectiveGroup(lesson_title(lesson), lesson.kind is SEANCE, tuple(map(render, own)))
        for lesson, own in _group_by_lesson(
            progress.course, school_class.module, loaded.summarise_objectives(week_ends)
        )
    ]
    return str(macros.class_objectives(groups, RULE))


def _group_by_lesson(
    course: Course, module: str, rows: Sequence[ClassObjective]
) -> Iterator[tuple[Lesson, Sequence[ClassObjective]]]:
    for slug, own in groupby(rows, key=lambda row: row.practised.objective.lesson):
        yield find_lesson(course, module, slug), list(own)


def _class_row(links: BoardLinks, people: Mapping[UUID, Link], row: ClassObjective) -> ObjectiveRow:
    students = len(people)
    begun = students - row.count_students(Mastery.none)
    percent = f"{round(100 * row.count_students(Mastery.mastered) / begun)} %" if begun >= FEWEST_FOR_A_SHARE else ""
    shown = [number for number in row.weekly if number] or [0]
    return ObjectiveRow(
        id=row.practised.objective.id,
        short=row.practised.objective.short,
        text=row.practised.objective.text,
        counts=tuple(
            StateCount(
                state,
                SIGNS[state],
                WORDS[state],
                row.count_students(state),
                round(100 * row.count_students(state) / max(1, students), 1),
                tuple(people[account] for account in row.students[state]),
            )
            for state in SHOWN_STATES
        ),
        weekly=" → ".join(map(str, shown)),
        percent=percent,
        exercises=tuple((links.title(name), links.exercise_href(name)) for name in row.practised.exercises),
        mistakes=tuple(
            (
                find_misconception(links.course, exercise, mistake).diagnosis.title,
                misconception_href(links.href, exercise, mistake),
                count,
            )
            for (exercise, mistake), count in row.mistakes[:MAX_MISTAKES]
        ),
    )


def build_student_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    student: UUID,
    name: str,
    now: datetime,
    *,
    is_own: bool,
    until: datetime | None = None,
    gone: str = "",
) -> StudentObjectivesPage:
    """Build the page of one student, for their teacher or for themselves: nothing on it is of other students."""
    school_class = access.school_class
    states = load_student_objective_states(db, course, school_class, student, now, until, as_student=is_own)
    rows = [build_objective_row(course, school_class.module, state) for state in states]
    return StudentObjectivesPage(
        head=class_head(course, access, "" if is_own else "/objectifs"),
        name=name,
        href=f"{class_href(school_class)}/eleves/{student}",
        is_own=is_own,
        groups=group_objectives_by_lesson(course, school_class.module, rows),
        steps=choose_steps(rows),
        counts=count_states_in_words(rows),
        rule=RULE,
        gone=gone,
    )


def choose_steps(rows: Sequence[StudentObjectiveRow]) -> tuple[StudentObjectiveRow, ...]:
    """Return what a student does next: each an exercise of its own, the most pressing first."""
    steps: dict[Link, StudentObjectiveRow] = {}
    waiting = [row for row in rows if row.state in NEXT_ORDER and row.next_exercise_link is not None]
    for row in sorted(waiting, key=lambda row: NEXT_ORDER[row.state]):
        if row.next_exercise_link is not None:
            steps.setdefault(row.next_exercise_link, row)
    return tuple(steps.values())[:MAX_NEXT_STEPS]
