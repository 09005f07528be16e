"""The files of one student whose functions later programs may import: the last to get full marks in each exercise."""

from collections.abc import Collection, Mapping
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, func, or_, select
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.assignments import feedback
from server.course.models import Course
from server.course.reuse import NOTHING_OWN, Own
from server.database import utc_now
from server.gradebook.models import Grading
from server.sandbox.values import LIBRARY_MENTION
from server.submissions.models import Submission
from server.submissions.repository import Sent


def load_importable_files(db: Session, course: Course, submission: Submission | Sent) -> Own:
    """The files that an attempt may import from, as they stood when it was sent; none where it does not ask."""
    sent = submission
    return _used(db, course, sent.account_id, sent.exercise, sent.source, sent.created_at)


def load_importable_files_now(db: Session, course: Course, account_id: UUID, exercise: str, source: bytes) -> Own:
    """The same of a file that is not sent."""
    return _used(db, course, account_id, exercise, source, utc_now())


def _used(db: Session, course: Course, account_id: UUID, exercise: str, source: bytes, when: datetime) -> Own:
    reused = [one.id for one in course.reused(exercise)]
    if not reused or LIBRARY_MENTION not in source:
        return NOTHING_OWN
    last = _last(db, account_id, reused, when)
    rows = db.execute(select(Submission.exercise, Submission.source).where(Submission.id.in_(last)))
    return {row.exercise: row.source for row in rows}


def importable_file_times(db: Session, account_id: UUID, exercises: Collection[str]) -> Mapping[str, datetime]:
    """When the files were sent that a program sent now would import from, by exercise."""
    if not exercises:
        return {}
    last = _last(db, account_id, exercises, utc_now())
    rows = db.execute(select(Submission.exercise, Submission.created_at).where(Submission.id.in_(last)))
    return {row.exercise: row.created_at for row in rows}


def _last(db: Session, account_id: UUID, exercises: Collection[str], when: datetime) -> Select[tuple[UUID]]:
    """In each exercise, the last attempt sent before `when` that got full marks, and that no test holds back."""
    order = (Submission.created_at.desc(), Submission.id.desc())
    ranked = (
        select(Submission.id, func.row_number().over(partition_by=Submission.exercise, order_by=order).label("rank"))
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Grading.outcome == Outcome.OK, Submission.created_at < when)
        .where(or_(*_shown(db, account_id, exercises)))
        .subquery()
    )
    return select(ranked.c.id).where(ranked.c.rank == 1)


def _shown(db: Session, account_id: UUID, exercises: Collection[str]) -> list[ColumnElement[bool]]:
    """The attempts at these exercises of which the verdict is not held back: it must not be learned in this way."""
    held = {exercise: found.held_since for exercise, found in feedback.load_all_holds(db, account_id).items()}
    free = [exercise for exercise in exercises if held.get(exercise) is None]
    until = [
        and_(Submission.exercise == exercise, Submission.created_at < held_from)
        for exercise in exercises
        if (held_from := held.get(exercise)) is not None
    ]
    return [Submission.exercise.in_(free), *until]
