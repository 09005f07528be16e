"""Queries of what is measured: what waits, and what was graded lately."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import Row, exists, func, select, text
from sqlalchemy.orm import Session, aliased

from server.gradebook.models import Grading
from server.queue.models import Job
from server.submissions.models import Submission


def answers(db: Session) -> None:
    """Raises SQLAlchemyError where the database does not."""
    db.execute(select(1))


def is_encrypted(db: Session) -> bool:
    """Whether this connection to PostgreSQL is over TLS."""
    return bool(db.execute(text("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()")).scalar_one())


def queue(db: Session) -> Sequence[Row[str, bool, int, datetime]]:
    """By kind, and by whether it has begun: how many jobs there are, and since when the oldest is there."""
    begun = Job.lease_token.is_not(None)
    return db.execute(select(Job.kind, begun, func.count(), func.min(Job.created_at)).group_by(Job.kind, begun)).all()


def first_verdicts(db: Session, since: datetime) -> Sequence[Row[UUID, str, str, datetime, datetime, datetime]]:
    """Of submissions graded for the first time since: grading, exercise, outcome, when sent, begun and ended."""
    earlier = aliased(Grading)
    before = exists().where(earlier.submission_id == Grading.submission_id, earlier.finished_at < Grading.finished_at)
    query = select(
        Grading.id,
        Submission.exercise,
        Grading.outcome,
        Submission.created_at,
        Grading.started_at,
        Grading.finished_at,
    ).join(Submission, Submission.id == Grading.submission_id)
    return db.execute(query.where(Grading.finished_at >= since, ~before)).all()
