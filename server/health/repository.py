"""Queries of health and metrics."""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import Row, exists, func, select, text
from sqlalchemy.orm import Session, aliased

from server.database import table_of, upsert_statement
from server.gradebook.models import Grading
from server.health.models import EventCount
from server.queue.models import Job
from server.submissions.models import Submission
from server.submissions.service import GRADE


def ping_database(db: Session) -> None:
    """Raise SQLAlchemyError where the database is unavailable."""
    db.execute(select(1))


def is_connection_encrypted(db: Session) -> bool:
    """Whether this connection to PostgreSQL is over TLS."""
    return bool(db.execute(text("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()")).scalar_one())


def count_open_and_allowed_connections(db: Session) -> tuple[int, int]:
    """Return PostgreSQL's open client connections, and how many non-superusers may open."""
    reserved = "current_setting('superuser_reserved_connections')::int"
    statement = f"SELECT count(*), current_setting('max_connections')::int - {reserved} FROM pg_stat_activity"
    opened, limit = db.execute(text(f"{statement} WHERE backend_type = 'client backend'")).one()
    return opened, limit


def load_queue_depths(db: Session) -> Sequence[Row[str, bool, int, datetime]]:
    """Count jobs by kind and by whether they run, with the creation time of the oldest."""
    running = Job.lease_token.is_not(None)
    return db.execute(
        select(Job.kind, running, func.count(), func.min(Job.created_at)).group_by(Job.kind, running)
    ).all()


def is_grading_abandoned(db: Session, before: datetime) -> bool:
    """Whether a submission has waited since `before` while nothing is being graded."""
    grading = select(Job.key).where(Job.kind == GRADE)
    runs = db.execute(select(grading.where(Job.lease_token.is_not(None)).exists())).scalar_one()
    waits = grading.where(Job.lease_token.is_(None), Job.created_at < before).exists()
    return not runs and bool(db.execute(select(waits)).scalar_one())


def load_first_gradings_since(
    db: Session, since: datetime, limit: int | None = None
) -> Sequence[Row[UUID, str, str, datetime, datetime, datetime]]:
    """Load the first gradings of submissions since a time, or the latest `limit` of them.

    Columns: grading id, exercise, outcome, sent at, started at, finished at.
    """
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
    query = query.where(Grading.finished_at >= since, ~before)
    if limit is not None:
        query = query.order_by(Grading.finished_at.desc()).limit(limit)
    return db.execute(query).all()


def load_running_jobs(db: Session, limit: int) -> Sequence[Row[str | None, str, str, datetime | None, int]]:
    """Load the running jobs: owner, kind, key, start, number of tries."""
    query = select(Job.lease_owner, Job.kind, Job.key, Job.started_at, Job.tries).where(Job.lease_token.is_not(None))
    return db.execute(query.order_by(Job.started_at).limit(limit)).all()


def load_exercises_by_submission(db: Session, submissions: Collection[UUID]) -> Mapping[UUID, str]:
    query = select(Submission.id, Submission.exercise).where(Submission.id.in_(submissions))
    return dict(db.execute(query).all())


def count_gradings_since(db: Session, since: datetime) -> int:
    """Count the gradings that ended since a time."""
    query = select(func.count()).select_from(Grading).where(Grading.finished_at >= since)
    return db.execute(query).scalar_one()


def load_latest_gradings_with_outcome(
    db: Session, outcome: str, since: datetime, limit: int
) -> Sequence[Row[datetime, str]]:
    """Load the latest gradings with this outcome: when, and of which exercise."""
    query = select(Grading.finished_at, Submission.exercise).join(Submission, Submission.id == Grading.submission_id)
    query = query.where(Grading.finished_at >= since, Grading.outcome == outcome)
    return db.execute(query.order_by(Grading.finished_at.desc()).limit(limit)).all()


def increment_count(db: Session, name: str, why: str) -> None:
    """Increment a counter."""
    statement = upsert_statement(db, EventCount).values(name=name, why=why, times=1)
    again = {"times": table_of(EventCount).c.times + 1}
    db.execute(statement.on_conflict_do_update(index_elements=["name", "why"], set_=again))


def load_counts_by_reason(db: Session, name: str) -> Mapping[str, int]:
    """Load a counter's values by reason."""
    return dict(db.execute(select(EventCount.why, EventCount.times).where(EventCount.name == name)).all())
