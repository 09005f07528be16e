"""The exercises that count in a class."""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy.orm import Session

from server.assignments import repository
from server.classes.models import SchoolClass
from server.course import Course


def counting_exercises(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Sequence[str]:
    """Return the exercises that count for a class, in the course's order: those of assignments that are open or past.

    The exercises of its teachers come after those of the module.

    Without assignments, all exercises of the module count; none where the module has left this server.
    """
    module = course.modules.get(school_class.module)
    if module is None:
        return []
    opened = repository.load_opened_exercises(db, school_class.id, now)
    names = [exercise.id for exercise in module.exercises]
    if opened is None:
        return names
    own = sorted(name for name in opened if name not in names and name in course.exercises)
    return [*(name for name in names if name in opened), *own]
