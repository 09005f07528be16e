"""Releases of tests, and the exercises that count in a class. Every function works inside the caller's transaction."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository
from server.assignments.models import Assignment
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.course import Course

ALREADY_RELEASED = "Les résultats de ce contrôle sont déjà publiés."


def release_feedback(db: Session, test: Assignment, by: UUID, now: datetime) -> None:
    """Release the results of a test, for good. Raises Conflict where they are released already."""
    classes.lock_class(db, test.class_id)
    db.refresh(test)
    if test.released_at is not None and test.released_at <= now:
        raise Conflict(ALREADY_RELEASED)
    before, test.released_at = test.released_at, now
    values = {"released_at": before}, {"released_at": now}
    audit.record_event(
        db, test.class_id, by, AuditAction.feedback_released, about=test.title, before=values[0], after=values[1]
    )


def counting_exercises(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Sequence[str]:
    """Return the exercises that count for a class, in the course's order: those of assignments that are open or past.

    Without assignments, all exercises of the module count; none where the module has left this server.
    """
    module = course.modules.get(school_class.module)
    if module is None:
        return []
    opened = repository.load_opened_exercises(db, school_class.id, now)
    names = [exercise.id for exercise in module.exercises]
    return names if opened is None else [name for name in names if name in opened]
