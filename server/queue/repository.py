"""Queries of the queue: claim, heartbeat, conditional end, recovery.

Each change of state is ONE conditional statement, so that it is atomic on both databases. Those on the way to a verdict
are made once.
"""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import Row, and_, bindparam, case, delete, exists, func, insert, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from server.database import table_of, utc_now
from server.queue.models import Job
from server.queue.port import Lease, Sender
from server.queue.turns import APART, Crowd, Turn

#: The key of PostgreSQL's lock for putting.
PUTTING = 0x7475726E

_jobs = table_of(Job)
_held = and_(_jobs.c.id == bindparam("held"), _jobs.c.lease_token == bindparam("by"))
_waits, _leased = _jobs.c.lease_token.is_(None), _jobs.c.lease_token.is_not(None)
_order = (_jobs.c.priority, _jobs.c.turn, _jobs.c.created_at, _jobs.c.id)
_next = (
    select(_jobs.c.id)
    .where(_waits, _jobs.c.kind.in_(bindparam("kinds", expanding=True)))
    .order_by(*_order)
    .limit(1)
    .with_for_update(skip_locked=True)
    .scalar_subquery()
)
_freed = {"lease_owner": None, "lease_token": None, "lease_until": None, "started_at": None}

_of_rank = _jobs.c.priority == bindparam("rank")
_of_sender = and_(_waits, _jobs.c.sender == bindparam("sender"))
_begun = select(func.max(_jobs.c.turn)).where(_leased, _of_rank).scalar_subquery()
_first = select(_jobs.c.turn).where(_waits, _of_rank).order_by(*_order).limit(1).scalar_subquery()
_from_address = select(func.count()).where(_waits, _of_rank, _jobs.c.address == bindparam("address")).scalar_subquery()
CROWD = select(
    _begun,
    _first,
    func.max(_jobs.c.turn).filter(_waits),
    func.max(_jobs.c.own_turn).filter(_leased),
    func.min(_jobs.c.own_turn).filter(_waits),
    func.max(_jobs.c.own_turn).filter(_waits),
    func.max(_jobs.c.own_turn).filter(_of_sender),
    func.count().filter(_of_sender),
    _from_address,
).where(_jobs.c.line == bindparam("line"))
PUSH = (
    update(_jobs)
    .where(_waits, _jobs.c.line == bindparam("in_line"), _jobs.c.own_turn > bindparam("after"))
    .values(turn=_jobs.c.turn + APART)
    .returning(_jobs.c.turn)
)
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
_places = (tuple_(each.priority, each.turn, each.created_at, each.id) for each in (_other, Job))
_before = next(_places) < next(_places)
_ahead = select(func.count()).select_from(_other).where(_other.lease_token.is_(None), _before).scalar_subquery()
#: That `before` comes first, or the next to begin.
UNTAKEN = (
    select(_jobs.c.id)
    .where(_waits, _jobs.c.kind.in_(bindparam("kinds", expanding=True)))
    .where(~exists().where(aliased(Job).lease_token.is_not(None)))
    .order_by(case((_jobs.c.id == bindparam("before"), 0), else_=1), *_order)
    .limit(1)
)
PLACE = select(Job.lease_token, _ahead).where(Job.kind == bindparam("kind"), Job.key == bindparam("key"))


def one_at_a_time(db: Session) -> None:
    """Until the commit, nobody else puts a job (on SQLite nobody else writes at all): turns are given one by one."""
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(func.pg_advisory_xact_lock(PUTTING)))


def crowd(db: Session, sender: Sender) -> Crowd:
    whose = {"rank": sender.rank, "line": sender.line, "sender": sender.name, "address": sender.address}
    return Crowd(*db.execute(CROWD, whose).one())


def push(db: Session, sender: Sender, own_turn: int) -> int:
    """Has what waits in this line after that own turn come one turn of the line later; returns the turn left free."""
    moved: Sequence[int] = db.execute(PUSH, {"in_line": sender.line, "after": own_turn}).scalars().all()
    return min(moved) - APART


def put(db: Session, kind: str, key: str, payload: Mapping[str, Any], sender: Sender, turn: Turn) -> None:
    what = {"id": uuid4(), "kind": kind, "key": key, "payload": dict(payload), "priority": sender.rank}
    whose = {"sender": sender.name, "address": sender.address, "line": sender.line}
    when = {"turn": turn.line, "own_turn": turn.own, "created_at": utc_now(), "tries": 0}
    db.execute(PUT, {**what, **whose, **when})


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


def untaken(db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
    asked = {"kinds": list(kinds), "before": before}
    return db.execute(UNTAKEN, asked).scalar_one_or_none()
