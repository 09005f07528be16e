"""What the first who reads would wait for, prepared once the service has given its address."""

from __future__ import annotations

import logging
import time

from server.course.models import Course
from server.polls import service as polls

log = logging.getLogger(__name__)

PAUSE = 0.05  # seconds after each, for who asks for something meanwhile


def read_ahead(course: Course) -> None:
    """The plan of every text, by which they name each other, and the questions of the lessons; then the graders, of
    which the board asks the names of mistakes. What fails here fails again, and is told, for whoever meets it."""
    for module in course.modules.values():
        for lesson in module.lessons:
            try:
                lesson.text.source.names()
                polls.of_lesson(module, lesson)
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
