"""The lesson that goes on in a class, as one of its students sees it: exercises of the day, then what comes next."""

from __future__ import annotations

from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.course import Course
from server.desk.assignments.schemas import OwnLesson, OwnLessonExercise, OwnWarmUp
from server.desk.warmup.views import warm_up_href
from server.gradebook import service as gradebook
from server.lesson import service
from server.lesson.models import Afterwards
from server.rights.service import ClassAccess
from server.warmup import service as warmup
from server.web.views import exercise_href


def find_own_warm_up(db: Session, access: ClassAccess, account_id: UUID) -> OwnWarmUp | None:
    """Return the questions of today, or None where there are none."""
    today = warmup.find_todays_warm_up(db, access.school_class.id)
    if today is None:
        return None
    answered = warmup.load_own_answers(db, account_id, access.school_class, today)
    total = len(today.questions)
    return OwnWarmUp(warm_up_href(access.school_class), total, total - len(answered))


def find_own_lesson(db: Session, course: Course, class_id: UUID, account_id: UUID, now: datetime) -> OwnLesson | None:
    """Return the lesson that goes on, or None. It says nothing of other students."""
    lesson = service.find_current_lesson(db, class_id, now)
    if lesson is None:
        return None
    standings = gradebook.load_visible_standings(db, account_id)

    def own_exercise(name: str) -> OwnLessonExercise | None:
        served, standing = course.exercises.get(name), standings.get(name)
        if served is None:
            return None
        solved = standing is not None and standing.first_success_at is not None
        return OwnLessonExercise(served.title, exercise_href(served), solved)

    exercises = tuple(row for row in map(own_exercise, lesson.exercises) if row is not None)
    finished = bool(exercises) and all(row.solved for row in exercises)
    is_challenge = finished and lesson.next_step == Afterwards.challenge and lesson.challenge
    return OwnLesson(
        exercises,
        finished,
        helps=finished and lesson.next_step == Afterwards.help,
        challenge=own_exercise(lesson.challenge) if is_challenge and lesson.challenge else None,
    )
