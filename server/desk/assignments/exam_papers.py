"""Papers of the course that a teacher gives as a test: their title, their time, the exercises that they name."""

from __future__ import annotations

import re
from collections.abc import Iterator

from server.assignments.models import LatePolicy, Mode
from server.course import Course, Module
from server.course.kinds import PAPER
from server.course.models import Lesson
from server.desk.assignments.schemas import AssignmentValues, PaperLink

EXERCISE_LINK = re.compile(r'href="/(?P<module>\w+)/exercices/(?P<slug>\w+)"')


def paper_links(course: Course, module: str, home: str) -> tuple[PaperLink, ...]:
    """The papers of a module that can be given: those that last some time, and name exercises."""
    served = course.modules.get(module)
    if served is None:
        return ()
    papers = (lesson for lesson in served.lessons if lesson.kind is PAPER and lesson.minutes)
    return tuple(
        PaperLink(f"{home}/devoirs/nouveau?sujet={lesson.slug}", lesson.title)
        for lesson in papers
        if paper_exercise_ids(served, lesson)
    )


def paper_form_values(course: Course, module: str, slug: str) -> AssignmentValues:
    """The form filled for a paper; as it is where there is no such paper."""
    served = course.modules.get(module)
    paper = (
        next((lesson for lesson in served.lessons if lesson.slug == slug and lesson.kind is PAPER), None)
        if served
        else None
    )
    if served is None or paper is None:
        return AssignmentValues()
    weights = dict.fromkeys(paper_exercise_ids(served, paper), "1")
    duration = str(paper.minutes) if paper.minutes else ""
    return AssignmentValues(
        title=paper.title, late=LatePolicy.accept, mode=Mode.test, duration=duration, weights=weights
    )


def paper_exercise_ids(module: Module, paper: Lesson) -> list[str]:
    """Those that its text links to, in the order of the text, by their ids."""
    return list(dict.fromkeys(_linked_exercise_ids(module, paper)))


def _linked_exercise_ids(module: Module, paper: Lesson) -> Iterator[str]:
    known = {exercise.slug for exercise in module.exercises}
    for found in EXERCISE_LINK.finditer(paper.html):
        if found["module"] == module.slug and found["slug"] in known:
            yield f"{module.slug}/{found['slug']}"
