"""Warm-up of the caches that the first reader would otherwise wait for."""

from __future__ import annotations

import logging
import time

from server.course.models import Course
from server.polls import service as polls

log = logging.getLogger(__name__)

#: Seconds left to who asks for something meanwhile: after each part, and after the plans, which the first one awaits.
PAUSE, FIRST_PAUSE = 0.05, 1.0


def preload_course(course: Course) -> None:
    """The plan of every text, by which they name each other, and the questions of the lessons; then the graders, of
    which the board asks the names of mistakes. What fails here fails again, and is told, for whoever meets it."""
    _load_misconception_names(course)
    time.sleep(FIRST_PAUSE)
    for module in course.modules.values():
        for lesson in module.lessons:
            try:
                polls.polls_of_lesson(module, lesson)
                _ = lesson.headings
                time.sleep(PAUSE)
            except Exception:
                log.exception("the lesson %s could not be prepared", lesson.slug)
    for exercise in course.exercises.values():
        try:
            _ = exercise.grader
            time.sleep(PAUSE)
        except Exception:
            log.exception("the grader of %s could not be loaded", exercise.id)


def _load_misconception_names(course: Course) -> None:
    for module in course.modules.values():
        for lesson in module.lessons[:1]:  # one asks for all of its module's
            try:
                lesson.text.source.names()
            except Exception:
                log.exception("the plan of %s could not be made", module.slug)
