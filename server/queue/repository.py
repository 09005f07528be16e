"""Queries of the queue: claim, heartbeat, conditional end, recovery.

Each change of state is ONE conditional statement, so that it is atomic on both databases.
"""

from collections.abc import Collection, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Row, and_, delete, func, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from server.queue.models import Job

FREED = {"lease_owner": None, "lease_token": None, "lease_until": None, "started_at": None}


def claim(
    db: Session, kinds: Collection[str], *, owner: str, token: UUID, now: datetime, until: datetime
) -> Job | None:
    """Leases the next waiting job. PostgreSQL skips rows being claimed; SQLite's writers take turns."""
    following = (
        select(Job.id)
        .where(Job.lease_token.is_(None), Job.kind.in_(list(kinds)))
        .order_by(Job.priority, Job.created_at, Job.id)
        .limit(1)
        .with_for_update(skip_locked=True)
        .scalar_subquery()
    )
    lease = {"lease_owner": owner, "lease_token": token, "lease_until": until, "started_at": now}
    statement = update(Job).where(Job.id == following).values(tries=Job.tries + 1, **lease).returning(Job)
    return db.execute(statement).scalar_one_or_none()


def _held(job_id: UUID, token: UUID) -> ColumnElement[bool]:
    return and_(Job.id == job_id, Job.lease_token == token)


def extend(db: Session, job_id: UUID, token: UUID, until: datetime) -> bool:
    statement = update(Job).where(_held(job_id, token)).values(lease_until=until).returning(Job.id)
    return db.execute(statement).first() is not None


def end(db: Session, job_id: UUID, token: UUID) -> bool:
    """Removes the job if the lease is still held; True when it was."""
    statement = delete(Job).where(_held(job_id, token)).returning(Job.id)
    return db.execute(statement.execution_options(synchronize_session=False)).first() is not None


def free(db: Session, job_id: UUID, token: UUID, *, tried: bool) -> bool:
    """Puts an unfinished job back where it waited; `tried`: this try counts."""
    values = FREED if tried else {**FREED, "tries": Job.tries - 1}
    statement = update(Job).where(_held(job_id, token)).values(values).returning(Job.id)
    return db.execute(statement.execution_options(synchronize_session=False)).first() is not None


def leased(db: Session, kinds: Collection[str]) -> Sequence[Job]:
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds))).with_for_update(skip_locked=True)
    return db.execute(query).scalars().all()


def leased_to(db: Session, kinds: Collection[str], owner: str) -> Sequence[Job]:
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds)), Job.lease_owner == owner)
    return db.execute(query).scalars().all()


def place(db: Session, kind: str, key: str) -> Row[UUID | None, int] | None:
    """The token of the job's lease, and how many waiting jobs come before it in the order of claiming."""
    other = aliased(Job)
    before = tuple_(other.priority, other.created_at, other.id) < tuple_(Job.priority, Job.created_at, Job.id)
    ahead = select(func.count()).select_from(other).where(other.lease_token.is_(None), before).scalar_subquery()
    return db.execute(select(Job.lease_token, ahead).where(Job.kind == kind, Job.key == key)).one_or_none()
