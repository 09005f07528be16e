"""Queries of the queue: claim, heartbeat, conditional end, recovery.

Each change of state is ONE conditional statement, so that it is atomic on both databases. Those on the way to a verdict
are made once. Leases are timed by one clock: that of PostgreSQL, else the machine's.
"""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime, timedelta
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import (
    Row,
    and_,
    bindparam,
    case,
    delete,
    exists,
    func,
    insert,
    literal_column,
    or_,
    select,
    tuple_,
    update,
)
from sqlalchemy.orm import Session, aliased

from server.database import UtcDateTime, ask, change, table_of, utc_now
from server.queue.fair_queueing import APART, Crowd, Turn
from server.queue.interfaces import Lease, Sender, WorkerCapabilities
from server.queue.models import Job

#: The key of PostgreSQL's lock for putting.
PUTTING = 0x7475726E
#: How long a process may say nothing within a transaction for which others wait.
SILENCE = "5s"

_jobs = table_of(Job)
_held = and_(_jobs.c.id == bindparam("held"), _jobs.c.lease_token == bindparam("by"))
_waits, _leased = _jobs.c.lease_token.is_(None), _jobs.c.lease_token.is_not(None)
_order = (_jobs.c.priority, _jobs.c.turn, _jobs.c.created_at, _jobs.c.id)
_of_kinds = _jobs.c.kind.in_(bindparam("kinds", expanding=True))
_first_of_kinds = (
    select(_jobs.c.id).where(_waits, _of_kinds).order_by(*_order).limit(1).with_for_update(skip_locked=True)
)
_had = or_(_jobs.c.needs.is_(None), _jobs.c.needs.in_(bindparam("having", expanding=True)))
_of_all = _jobs.c.refused_at <= bindparam("before")
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
_lease = {
    "tries": _jobs.c.tries + 1,
    "lease_owner": bindparam("owner"),
    "lease_token": bindparam("token"),
    "lease_until": bindparam("until"),
    "started_at": bindparam("now"),
}
_next = _jobs.alias("following")
#: The job itself is left out by name: whether it waits still, at that moment, the databases do not say alike. Its
#: table is told, since SQLite is given bare names among what an update returns.
_followed = exists().where(
    _next.c.lease_token.is_(None),
    _next.c.kind.in_(bindparam("kinds", expanding=True)),
    _next.c.id != literal_column("job.id"),
)
_leasing = update(_jobs).values(**_lease)
_leasing = _leasing.returning(
    *(_jobs.c.id, _jobs.c.kind, _jobs.c.key, _jobs.c.payload, _jobs.c.tries, _jobs.c.needs, _followed.label("followed"))
)
#: PostgreSQL skips rows being claimed; SQLite's writers take turns.
CLAIM = _leasing.where(_jobs.c.id == _first_of_kinds.scalar_subquery())
#: Of what this worker has, or nobody has had for too long.
CLAIM_ABLE = _leasing.where(_jobs.c.id == _first_of_kinds.where(or_(_had, _of_all)).scalar_subquery())
_not_had = and_(_waits, _of_kinds, ~_had)
NOT_HAD = select(exists().where(_not_had))
REFUSE = update(_jobs).where(_not_had, _jobs.c.refused_at.is_(None)).values(refused_at=bindparam("now"))
EXTEND = update(_jobs).where(_held).values(lease_until=bindparam("until")).returning(_jobs.c.id)
_BRIEFLY = func.set_config("idle_in_transaction_session_timeout", SILENCE, True)
END = delete(_jobs).where(_held).returning(_jobs.c.id)
#: On PostgreSQL: what is recorded next locks what others may wait for.
END_BRIEFLY = END.returning(_BRIEFLY)
FREE = update(_jobs).where(_held).values(tries=_jobs.c.tries - bindparam("untried"), **_freed).returning(_jobs.c.id)
_other = aliased(Job)
_places = (tuple_(each.priority, each.turn, each.created_at, each.id) for each in (_other, Job))
_before = next(_places) < next(_places)
_ahead = select(func.count()).select_from(_other).where(_other.lease_token.is_(None), _before).scalar_subquery()
NOW = select(func.clock_timestamp(type_=UtcDateTime()))
NOW_UNSYNCED = select(func.clock_timestamp(type_=UtcDateTime()), func.set_config("synchronous_commit", "off", True))
CALLED = select(_jobs.c.kind, func.count().label("jobs")).group_by(_jobs.c.kind)
OLDEST = select(_jobs.c.id).where(_waits, _jobs.c.kind == bindparam("kind")).order_by(_jobs.c.created_at, _jobs.c.id)
REFUSED = select(_jobs.c.needs, func.count()).where(_waits, _jobs.c.refused_at.is_not(None)).group_by(_jobs.c.needs)
#: That `before` comes first, or the next to begin.
UNTAKEN = (
    select(_jobs.c.id)
    .where(_waits, _jobs.c.kind.in_(bindparam("kinds", expanding=True)))
    .where(~exists().where(aliased(Job).lease_token.is_not(None)))
    .order_by(case((_jobs.c.id == bindparam("before"), 0), else_=1), *_order)
    .limit(1)
)
PLACE = select(Job.lease_token, _ahead, Job.refused_at).where(
    Job.kind == bindparam("kind"), Job.key == bindparam("key")
)


def one_at_a_time(db: Session) -> None:
    """Until the commit, nobody else puts a job (on SQLite nobody else writes at all): turns are given one by one.

    Who is frozen meanwhile, or cut off, is undone.
    """
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(_BRIEFLY, func.pg_advisory_xact_lock(PUTTING)))


def clock(db: Session) -> datetime:
    """The time that all who share the database agree on."""
    if db.get_bind().dialect.name == "postgresql":
        return db.execute(NOW).scalar_one()
    return utc_now()


def begin_leasing(db: Session) -> datetime:
    """The time, for a claim. PostgreSQL does not wait for the disk at its commit, which would take longer than all else
    before the work begins: a crash at that moment leaves the job waiting, and whoever claims it has another token."""
    if db.get_bind().dialect.name != "postgresql":
        return utc_now()
    now: datetime = db.execute(NOW_UNSYNCED).scalar_one()
    return now


def crowd(db: Session, sender: Sender) -> Crowd:
    whose = {"rank": sender.rank, "line": sender.flow, "sender": sender.name, "address": sender.address}
    return Crowd(*ask(db, CROWD, whose).one())


def push(db: Session, sender: Sender, own_turn: int) -> int:
    """Has what waits in this line after that own turn come one turn of the line later; returns the turn left free."""
    moved: Sequence[int] = db.execute(PUSH, {"in_line": sender.flow, "after": own_turn}).scalars().all()
    return min(moved) - APART


def put(
    db: Session, kind: str, key: str, payload: Mapping[str, Any], sender: Sender, turn: Turn, needs: str | None
) -> UUID:
    """The new job's name."""
    name = uuid4()
    what = {"id": name, "kind": kind, "key": key, "payload": dict(payload), "priority": sender.rank, "needs": needs}
    whose = {"sender": sender.name, "address": sender.address, "line": sender.flow}
    when = {"turn": turn.line, "own_turn": turn.own, "created_at": utc_now(), "tries": 0}
    change(db, PUT, {**what, **whose, **when})
    return name


def claim(
    db: Session,
    kinds: Collection[str],
    *,
    owner: str,
    token: UUID,
    now: datetime,
    until: datetime,
    able: WorkerCapabilities | None,
) -> Lease | None:
    """Leases the next waiting job."""
    lease = {"kinds": list(kinds), "owner": owner, "token": token, "now": now, "until": until}
    if able is None:
        row = ask(db, CLAIM, lease).one_or_none()
    else:
        row = ask(db, CLAIM_ABLE, {**lease, **_ability(able, now)}).one_or_none()
    if row is None:
        return None
    return Lease(row.id, token, row.kind, row.key, row.payload, row.tries, now, row.needs, more_waiting=row.followed)


def refuse(db: Session, kinds: Collection[str], able: WorkerCapabilities) -> bool:
    """Notes the first refusal of what waits for another worker; False where nothing does."""
    now = clock(db)
    asked = {"kinds": list(kinds), "having": list(able.versions)}
    if not db.execute(NOT_HAD, asked).scalar_one():
        return False
    db.execute(REFUSE, {**asked, "now": now})
    return True


def _ability(able: WorkerCapabilities, now: datetime) -> dict[str, Any]:
    return {"having": list(able.versions), "before": now - timedelta(seconds=able.refusal_timeout)}


def extend(db: Session, job_id: UUID, token: UUID, until: datetime) -> bool:
    return db.execute(EXTEND, {"held": job_id, "by": token, "until": until}).first() is not None


def end(db: Session, job_id: UUID, token: UUID) -> bool:
    """Removes the job if the lease is still held; True when it was."""
    statement = END_BRIEFLY if db.get_bind().dialect.name == "postgresql" else END
    return ask(db, statement, {"held": job_id, "by": token}).first() is not None


def free(db: Session, job_id: UUID, token: UUID, *, tried: bool) -> bool:
    """Puts an unfinished job back where it waited; `tried`: this try counts."""
    return db.execute(FREE, {"held": job_id, "by": token, "untried": 0 if tried else 1}).first() is not None


def leased(db: Session, kinds: Collection[str]) -> Sequence[Job]:
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds))).with_for_update(skip_locked=True)
    return db.execute(query).scalars().all()


def leased_to(db: Session, kinds: Collection[str], owner: str) -> Sequence[Job]:
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds)), Job.lease_owner == owner)
    return db.execute(query).scalars().all()


def place(db: Session, kind: str, key: str) -> Row[UUID | None, int, datetime | None] | None:
    """The token of the job's lease, how many waiting jobs come before it in the order of claiming, its refusal."""
    return db.execute(PLACE, {"kind": kind, "key": key}).one_or_none()


def untaken(db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
    asked = {"kinds": list(kinds), "before": before}
    return db.execute(UNTAKEN, asked).scalar_one_or_none()


def called(db: Session) -> Mapping[str, int]:
    """By kind, how many jobs wait or are being done."""
    return {row.kind: row.jobs for row in db.execute(CALLED)}


def oldest(db: Session, kind: str, count: int) -> Sequence[UUID]:
    """Of those that wait, these came first."""
    return db.execute(OLDEST.limit(count), {"kind": kind}).scalars().all()


def begun(db: Session) -> int:
    return db.execute(select(func.count()).select_from(_jobs).where(_leased)).scalar_one()


def waiting(db: Session) -> int:
    return db.execute(select(func.count()).select_from(_jobs).where(_waits)).scalar_one()


def refused(db: Session) -> Mapping[str, int]:
    """By what they need, how many jobs wait that a worker has refused."""
    return {needs: count for needs, count in db.execute(REFUSED) if needs is not None}
