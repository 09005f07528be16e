"""Queries on the codes of a class."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import Row, func, select
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, Status
from server.gradebook.models import Grading
from server.submissions.models import Submission


def load_best_attempt_codes(
    db: Session, class_id: UUID, exercise: str, since: datetime, until: datetime | None, most: int
) -> Sequence[Row[UUID, UUID, bytes]]:
    """Student, attempt and file: each student's best attempt at the exercise in that time, the last of equals."""
    order = (Grading.score.desc(), Submission.created_at.desc(), Submission.id)
    place = func.row_number().over(partition_by=Submission.account_id, order_by=order).label("place")
    ranked = (
        select(Submission.id, place)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Membership, Membership.account_id == Submission.account_id)
        .where(
            Membership.class_id == class_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            Submission.exercise == exercise,
            Submission.created_at >= since,
            Grading.score.is_not(None),
        )
    )
    if until is not None:
        ranked = ranked.where(Submission.created_at <= until)
    best = ranked.subquery()
    query = (
        select(Submission.account_id, Submission.id, Submission.source)
        .join(best, best.c.id == Submission.id)
        .where(best.c.place == 1)
        .order_by(Submission.account_id)
        .limit(most)
    )
    return db.execute(query).all()
