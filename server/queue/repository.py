"""Queries of the queue: claim, heartbeat, conditional end, recovery.

Each change of state is ONE conditional statement, so that it is atomic on both databases. Those on the way to a verdict
are made once.
"""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import Row, and_, bindparam, delete, func, insert, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from server.database import table_of, utc_now
from server.queue.models import Job
from server.queue.port import Lease

_jobs = table_of(Job)
_held = and_(_jobs.c.id == bindparam("held"), _jobs.c.lease_token == bindparam("by"))
_next = (
    select(_jobs.c.id)
    .where(_jobs.c.lease_token.is_(None), _jobs.c.kind.in_(bindparam("kinds", expanding=True)))
    .order_by(_jobs.c.priority, _jobs.c.created_at, _jobs.c.id)
    .limit(1)
    .with_for_update(skip_locked=True)
    .scalar_subquery()
)
_freed = {"lease_owner": None, "lease_token": None, "lease_until": None, "started_at": None}

PUT = insert(_jobs)
#: PostgreSQL skips rows being claimed; SQLite's writers take turns.
CLAIM = (
    update(_jobs)
    .where(_jobs.c.id == _next)
    .values(
        tries=_jobs.c.tries + 1,
        lease_owner=bindparam("owner"),
        lease_token=bindparam("token"),
        lease_until=bindparam("until"),
        started_at=bindparam("now"),
    )
    .returning(_jobs.c.id, _jobs.c.kind, _jobs.c.key, _jobs.c.payload, _jobs.c.tries)
)
EXTEND = update(_jobs).where(_held).values(lease_until=bindparam("until")).returning(_jobs.c.id)
END = delete(_jobs).where(_held).returning(_jobs.c.id)
FREE = update(_jobs).where(_held).values(tries=_jobs.c.tries - bindparam("untried"), **_freed).returning(_jobs.c.id)
_other = aliased(Job)
_before = tuple_(_other.priority, _other.created_at, _other.id) < tuple_(Job.priority, Job.created_at, Job.id)
_ahead = select(func.count()).select_from(_other).where(_other.lease_token.is_(None), _before).scalar_subquery()
PLACE = select(Job.lease_token, _ahead).where(Job.kind == bindparam("kind"), Job.key == bindparam("key"))


def put(db: Session, kind: str, key: str, payload: Mapping[str, Any], priority: int) -> None:
    row = {"id": uuid4(), "kind": kind, "key": key, "payload": dict(payload), "priority": priority}
    db.execute(PUT, {**row, "created_at": utc_now(), "tries": 0})


def claim(
    db: Session, kinds: Collection[str], *, owner: str, token: UUID, now: datetime, until: datetime
) -> Lease | None:
    """Leases the next waiting job."""
    lease = {"kinds": list(kinds), "owner": owner, "token": token, "now": now, "until": until}
    row = db.execute(CLAIM, lease).one_or_none()
    return None if row is None else Lease(row.id, token, row.kind, row.key, row.payload, row.tries, now)


def extend(db: Session, job_id: UUID, token: UUID, until: datetime) -> bool:
    return db.execute(EXTEND, {"held": job_id, "by": token, "until": until}).first() is not None


def end(db: Session, job_id: UUID, token: UUID) -> bool:
    """Removes the job if the lease is still held; True when it was."""
    return db.execute(END, {"held": job_id, "by": token}).first() is not None


def free(db: Session, job_id: UUID, token: UUID, *, tried: bool) -> bool:
    """Puts an unfinished job back where it waited; `tried`: this try counts."""
    return db.execute(FREE, {"held": job_id, "by": token, "untried": 0 if tried else 1}).first() is not None


def leased(db: Session, kinds: Collection[str]) -> Sequence[Job]:
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds))).with_for_update(skip_locked=True)
    return db.execute(query).scalars().all()


def leased_to(db: Session, kinds: Collection[str], owner: str) -> Sequence[Job]:
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds)), Job.lease_owner == owner)
    return db.execute(query).scalars().all()


def place(db: Session, kind: str, key: str) -> Row[UUID | None, int] | None:
    """The token of the job's lease, and how many waiting jobs come before it in the order of claiming."""
    return db.execute(PLACE, {"kind": kind, "key": key}).one_or_none()
