"""What streams of a lesson show: read once for all who watch the lesson of a class."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.board.live import ClassView
from server.board.repository import ClassVersionTag, load_class_version_tag
from server.board.service import load_class_progress
from server.classes.models import SchoolClass
from server.course import Course
from server.desk.lesson.schemas import LessonParts
from server.desk.lesson.views import lesson_parts
from server.lesson import repository, service


@dataclass(frozen=True)
class ShownLesson:
    """What changes on the page of a lesson; `parts` is None once no lesson goes on."""

    parts: LessonParts | None

    @property
    def version(self) -> Hashable:
        return self.parts


def load_lesson(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, pulse: ClassVersionTag
) -> ShownLesson:
    lesson = service.find_current_lesson(db, school_class.id, now)
    if lesson is None:
        return ShownLesson(None)
    progress = load_class_progress(db, course, school_class, now, besides=lesson.exercises, pulse=pulse)
    return ShownLesson(lesson_parts(db, progress, school_class, lesson))


def load_lesson_pulse(db: Session, class_id: UUID) -> ClassVersionTag:
    """Load a version tag of the class, of its latest lesson, and of whom its teacher has seen in it."""
    pulse, lesson = load_class_version_tag(db, class_id), repository.find_latest_lesson(db, class_id)
    if lesson is None:
        return pulse
    plan = lesson.id, tuple(lesson.exercises), lesson.next_step, lesson.challenge, lesson.ended_at
    visits = repository.load_visits(db, lesson.id)
    seen = sorted((str(account), visit.exercise, visit.visited_at) for account, visit in visits.items())
    return replace(pulse, others=(plan, *seen))


LESSON: ClassView[ClassVersionTag, ShownLesson] = ClassView(load_lesson_pulse, load_lesson)
