"""The files of one student whose functions later programs may import: the last to get full marks in each exercise."""

from collections.abc import Iterable, Mapping
from datetime import datetime
from uuid import UUID

from sqlalchemy import select
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.assignments import feedback
from server.course.models import Course
from server.course.reuse import MENTION, NOTHING_OWN, Own
from server.gradebook.models import Grading
from server.submissions.models import Submission


def used_by(db: Session, course: Course, submission: Submission) -> Own:
    """The files that an attempt may import from, as they stood when it was sent; none where it does not ask."""
    reused = course.reused(submission.exercise)
    if not reused or MENTION not in submission.source:
        return NOTHING_OWN
    found = before(db, submission.account_id, (one.id for one in reused), submission.created_at)
    return {exercise: one.source for exercise, one in found.items()}


def before(db: Session, account_id: UUID, exercises: Iterable[str], when: datetime) -> Mapping[str, Submission]:
    """By exercise, the last attempt sent before `when` that got full marks, and that no test holds back."""
    found = {exercise: _last(db, account_id, exercise, when) for exercise in exercises}
    return {exercise: one for exercise, one in found.items() if one is not None}


def _last(db: Session, account_id: UUID, exercise: str, when: datetime) -> Submission | None:
    held_from = feedback.of(db, account_id, exercise).held_from
    query = (
        select(Submission)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Submission.exercise == exercise)
        .where(Submission.created_at < when, Grading.outcome == Outcome.OK)
        .order_by(Submission.created_at.desc(), Submission.id.desc())
    )
    if held_from is not None:
        query = query.where(Submission.created_at < held_from)
    return db.execute(query.limit(1)).scalar_one_or_none()
