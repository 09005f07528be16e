"""Queries of what is measured: what waits, and what was graded lately."""

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


def ping(db: Session) -> None:
    """Raises SQLAlchemyError where the database does not."""
    db.execute(select(1))


def is_encrypted(db: Session) -> bool:
    """Whether this connection to PostgreSQL is over TLS."""
    return bool(db.execute(text("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()")).scalar_one())


def connection_usage(db: Session) -> tuple[int, int]:
    """To PostgreSQL: how many are open, whoever's, and how many it takes from who is no superuser."""
    kept = "current_setting('superuser_reserved_connections')::int"
    said = f"SELECT count(*), current_setting('max_connections')::int - {kept} FROM pg_stat_activity"
    opened, most = db.execute(text(f"{said} WHERE backend_type = 'client backend'")).one()
    return opened, most


def queue_depths(db: Session) -> Sequence[Row[str, bool, int, datetime]]:
    """By kind, and by whether it has begun: how many jobs there are, and since when the oldest is there."""
    begun = Job.lease_token.is_not(None)
    return db.execute(select(Job.kind, begun, func.count(), func.min(Job.created_at)).group_by(Job.kind, begun)).all()


def first_verdicts(
    db: Session, since: datetime, most: int | None = None
) -> Sequence[Row[UUID, str, str, datetime, datetime, datetime]]:
    """Of submissions graded for the first time since, or of the latest `most` of them: grading, exercise, outcome, when
    sent, begun and ended."""
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
    if most is not None:
        query = query.order_by(Grading.finished_at.desc()).limit(most)
    return db.execute(query).all()


def leased_jobs(db: Session, most: int) -> Sequence[Row[str | None, str, str, datetime | None, int]]:
    """What is being done: by whom, its kind and key, since when, and how often it was begun."""
    query = select(Job.lease_owner, Job.kind, Job.key, Job.started_at, Job.tries).where(Job.lease_token.is_not(None))
    return db.execute(query.order_by(Job.started_at).limit(most)).all()


def exercises_by_submission(db: Session, submissions: Collection[UUID]) -> Mapping[UUID, str]:
    query = select(Submission.id, Submission.exercise).where(Submission.id.in_(submissions))
    return dict(db.execute(query).all())


def count_graded_since(db: Session, since: datetime) -> int:
    """How many gradings have ended since."""
    query = select(func.count()).select_from(Grading).where(Grading.finished_at >= since)
    return db.execute(query).scalar_one()


def latest_failures(db: Session, outcome: str, since: datetime, most: int) -> Sequence[Row[datetime, str]]:
    """The latest gradings that ended so: when, and of which exercise."""
    query = select(Grading.finished_at, Submission.exercise).join(Submission, Submission.id == Grading.submission_id)
    query = query.where(Grading.finished_at >= since, Grading.outcome == outcome)
    return db.execute(query.order_by(Grading.finished_at.desc()).limit(most)).all()


def increment_count(db: Session, name: str, why: str) -> None:
    """That it happened once more."""
    statement = upsert_statement(db, EventCount).values(name=name, why=why, times=1)
    again = {"times": table_of(EventCount).c.times + 1}
    db.execute(statement.on_conflict_do_update(index_elements=["name", "why"], set_=again))


def counts_by_reason(db: Session, name: str) -> Mapping[str, int]:
    """How often it happened, by why."""
    return dict(db.execute(select(EventCount.why, EventCount.times).where(EventCount.name == name)).all())
