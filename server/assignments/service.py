"""Assignments of a class. Every function works inside the caller's transaction."""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy.orm import Session

from server.assignments import repository
from server.classes.models import SchoolClass
from server.course import Course


def counting_exercises(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Sequence[str]:
    """What counts on the class's board, in the course's order: the exercises of assignments that are open or past.

    All of the module's where the class has no assignment; none where its module has left this server.
    """
    module = course.modules.get(school_class.module)
    if module is None:
        return []
    opened = repository.opened_exercises(db, school_class.id, now)
    names = [exercise.id for exercise in module.exercises]
    return names if opened is None else [name for name in names if name in opened]
