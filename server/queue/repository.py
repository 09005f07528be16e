"""Queries of the queue, which is the submissions' rows: claim, heartbeat, conditional result, recovery.

Each change of state is ONE conditional statement, so that it is atomic on both databases.
"""

from collections.abc import Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, and_, func, or_, select, update
from sqlalchemy.orm import Session

from server.submissions.models import State, Submission

FREED = {"lease_owner": None, "lease_token": None, "lease_until": None}


def claim(db: Session, *, owner: str, token: UUID, now: datetime, until: datetime) -> Submission | None:
    """Leases the oldest waiting submission. PostgreSQL skips rows being claimed; SQLite's writers take turns."""
    oldest = (
        select(Submission.id)
        .where(Submission.state == State.queued)
        .order_by(Submission.created_at, Submission.id)
        .limit(1)
        .with_for_update(skip_locked=True)
        .scalar_subquery()
    )
    lease = {"lease_owner": owner, "lease_token": token, "lease_until": until}
    statement = (
        update(Submission)
        .where(Submission.id == oldest)
        .values(state=State.running, started_at=now, attempts=Submission.attempts + 1, **lease)
        .returning(Submission)
    )
    return db.execute(statement).scalar_one_or_none()


def _held(submission_id: UUID, token: UUID) -> ColumnElement[bool]:
    return and_(Submission.id == submission_id, Submission.state == State.running, Submission.lease_token == token)


def extend(db: Session, submission_id: UUID, token: UUID, until: datetime) -> bool:
    statement = update(Submission).where(_held(submission_id, token)).values(lease_until=until).returning(Submission.id)
    return db.execute(statement).first() is not None


def finish(db: Session, submission_id: UUID, token: UUID, result: dict[str, Any]) -> bool:
    """Records the result if the lease is still held; True when it was."""
    values = {**result, **FREED, "state": State.done}
    statement = update(Submission).where(_held(submission_id, token)).values(values).returning(Submission.id)
    return db.execute(statement).first() is not None


def account_of(db: Session, submission_id: UUID) -> UUID:
    return db.execute(select(Submission.account_id).where(Submission.id == submission_id)).scalar_one()


def give_back(db: Session, submission_id: UUID, token: UUID) -> bool:
    """Puts an unfinished submission back in the queue, as if it had not been tried."""
    values = {**FREED, "state": State.queued, "attempts": Submission.attempts - 1}
    statement = update(Submission).where(_held(submission_id, token)).values(values).returning(Submission.id)
    return db.execute(statement).first() is not None


def requeue(db: Session, submission_id: UUID, token: UUID) -> bool:
    statement = update(Submission).where(_held(submission_id, token)).values({**FREED, "state": State.queued})
    return db.execute(statement.returning(Submission.id)).first() is not None


def running(db: Session) -> Sequence[Submission]:
    query = select(Submission).where(Submission.state == State.running).with_for_update(skip_locked=True)
    return db.execute(query).scalars().all()


def running_of(db: Session, owner: str) -> Sequence[Submission]:
    query = select(Submission).where(Submission.state == State.running, Submission.lease_owner == owner)
    return db.execute(query).scalars().all()


def waiting_before(db: Session, submission: Submission) -> int:
    """How many waiting submissions are older than this one."""
    older = or_(
        Submission.created_at < submission.created_at,
        and_(Submission.created_at == submission.created_at, Submission.id < submission.id),
    )
    query = select(func.count()).select_from(Submission).where(Submission.state == State.queued, older)
    return db.execute(query).scalar_one()
