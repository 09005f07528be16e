"""Queries of the queue: enqueue, claim, heartbeat, conditional end, recovery.

Each change of state is ONE conditional statement, hence atomic on both databases. Statements of the hot path are built
once. One clock times the leases: that of PostgreSQL, else the machine's.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
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

from server.database import UtcDateTime, select_core, table_of, utc_now, write_core
from server.queue.fair_queueing import TURN_STEP, FairTurn, FlowState
from server.queue.interfaces import Lease, PrecedingJobs, Sender, WaitingJob, WorkerCapabilities
from server.queue.models import Job

#: Key of PostgreSQL's advisory lock for enqueueing.
ENQUEUE_LOCK = 0x7475726E
#: Idle timeout of a transaction for which others wait.
IDLE_TIMEOUT = "5s"

_jobs = table_of(Job)
_held_by_token = and_(_jobs.c.id == bindparam("held"), _jobs.c.lease_token == bindparam("by"))
_waits, _leased = _jobs.c.lease_token.is_(None), _jobs.c.lease_token.is_not(None)
_order = (_jobs.c.priority, _jobs.c.turn, _jobs.c.created_at, _jobs.c.id)
_of_kinds = _jobs.c.kind.in_(bindparam("kinds", expanding=True))
_next_job_id = select(_jobs.c.id).where(_waits, _of_kinds).order_by(*_order).limit(1)
_version_available = or_(_jobs.c.needs.is_(None), _jobs.c.needs.in_(bindparam("having", expanding=True)))
_refused_before = _jobs.c.refused_at <= bindparam("before")
_no_lease = {"lease_owner": None, "lease_token": None, "lease_until": None, "started_at": None}

_of_rank = _jobs.c.priority == bindparam("rank")
_of_sender = and_(_waits, _jobs.c.sender == bindparam("sender"))
_served_turn = select(func.max(_jobs.c.turn)).where(_leased, _of_rank).scalar_subquery()
_first_waiting_turn = select(_jobs.c.turn).where(_waits, _of_rank).order_by(*_order).limit(1).scalar_subquery()
_waiting_from_address = (
    select(func.count()).where(_waits, _of_rank, _jobs.c.address == bindparam("address")).scalar_subquery()
)
FLOW_STATE = select(
    _served_turn,
    _first_waiting_turn,
    func.max(_jobs.c.turn).filter(_waits),
    func.max(_jobs.c.own_turn).filter(_leased),
    func.min(_jobs.c.own_turn).filter(_waits),
    func.max(_jobs.c.own_turn).filter(_waits),
    func.max(_jobs.c.own_turn).filter(_of_sender),
    func.count().filter(_of_sender),
    _waiting_from_address,
).where(_jobs.c.line == bindparam("line"))
PUSH_BACK_FLOW = (
    update(_jobs)
    .where(_waits, _jobs.c.line == bindparam("in_line"), _jobs.c.own_turn > bindparam("after"))
    .values(turn=_jobs.c.turn + TURN_STEP)
    .returning(_jobs.c.turn)
)
INSERT = insert(_jobs)
_new_lease = {
    "tries": _jobs.c.tries + 1,
    "lease_owner": bindparam("owner"),
    "lease_token": bindparam("token"),
    "lease_until": bindparam("until"),
    "started_at": bindparam("now"),
}
_other_waiting = _jobs.alias("other_waiting")
#: Excludes the claimed job by its id: the databases differ on whether it still waits at that moment. The literal
#: column keeps its table name, which SQLite loses in a RETURNING clause.
_more_waiting = exists().where(
    _other_waiting.c.lease_token.is_(None),
    _other_waiting.c.kind.in_(bindparam("kinds", expanding=True)),
    _other_waiting.c.id != literal_column("job.id"),
)
_claim = update(_jobs).values(**_new_lease)
_claim = _claim.returning(
    *(
        _jobs.c.id,
        _jobs.c.kind,
        _jobs.c.key,
        _jobs.c.payload,
        _jobs.c.tries,
        _jobs.c.needs,
        _jobs.c.priority,
        _jobs.c.line,
        _more_waiting.label("more_waiting"),
    )
)
#: Only jobs whose version this worker has, or that were refused longer ago than the timeout.
_capable = or_(_version_available, _refused_before)
#: Only jobs that go before a running one.
_precedes_running = or_(
    _jobs.c.priority < bindparam("ranks_below"),
    and_(_jobs.c.priority == bindparam("same_rank"), _jobs.c.line != bindparam("excluded_flow")),
)
#: The next job, by whether the claim has capabilities and is for jobs ahead of another.
_choices = {
    (capable, precedes): _next_job_id.where(*[_capable] * capable, *[_precedes_running] * precedes)
    for capable in (False, True)
    for precedes in (False, True)
}
#: PostgreSQL skips rows that another claim has locked; SQLite serialises its writers.
CLAIMS = {
    key: _claim.where(_jobs.c.id == choice.with_for_update(skip_locked=True).scalar_subquery())
    for key, choice in _choices.items()
}
FIND_PRECEDING = {capable: _choices[capable, True].add_columns(_jobs.c.priority) for capable in (False, True)}
_version_missing = and_(_waits, _of_kinds, ~_version_available)
ANY_VERSION_MISSING = select(exists().where(_version_missing))
REFUSE = update(_jobs).where(_version_missing, _jobs.c.refused_at.is_(None)).values(refused_at=bindparam("now"))
EXTEND_LEASE = update(_jobs).where(_held_by_token).values(lease_until=bindparam("until")).returning(_jobs.c.id)
_set_idle_timeout = func.set_config("idle_in_transaction_session_timeout", IDLE_TIMEOUT, True)
END = delete(_jobs).where(_held_by_token).returning(_jobs.c.id)
#: On PostgreSQL: the result that follows locks rows for which others may wait.
END_WITH_IDLE_TIMEOUT = END.returning(_set_idle_timeout)
RELEASE_LEASE = (
    update(_jobs)
    .where(_held_by_token)
    .values(tries=_jobs.c.tries - bindparam("untried"), **_no_lease)
    .returning(_jobs.c.id)
)
_other = aliased(Job)
_sort_keys = (tuple_(job.priority, job.turn, job.created_at, job.id) for job in (_other, Job))
_precedes = next(_sort_keys) < next(_sort_keys)
_preceding = select(func.count()).select_from(_other).where(_other.lease_token.is_(None), _precedes).scalar_subquery()
NOW = select(func.clock_timestamp(type_=UtcDateTime()))
NOW_WITHOUT_SYNC = select(func.clock_timestamp(type_=UtcDateTime()), func.set_config("synchronous_commit", "off", True))
COUNT_BY_KIND = select(_jobs.c.kind, func.count().label("jobs")).group_by(_jobs.c.kind)
OLDEST_WAITING = (
    select(_jobs.c.id).where(_waits, _jobs.c.kind == bindparam("kind")).order_by(_jobs.c.created_at, _jobs.c.id)
)
COUNT_REFUSED = (
    select(_jobs.c.needs, func.count()).where(_waits, _jobs.c.refused_at.is_not(None)).group_by(_jobs.c.needs)
)
#: Prefers `before`, else the next job to claim.
FIND_STALLED = (
    select(_jobs.c.id)
    .where(_waits, _jobs.c.kind.in_(bindparam("kinds", expanding=True)))
    .where(~exists().where(aliased(Job).lease_token.is_not(None)))
    .order_by(case((_jobs.c.id == bindparam("before"), 0), else_=1), *_order)
    .limit(1)
)
POSITION = select(Job.lease_token, _preceding, Job.refused_at).where(
    Job.kind == bindparam("kind"), Job.key == bindparam("key")
)


def lock_enqueueing(db: Session) -> None:
    """Until the commit, nobody else enqueues (on SQLite, nobody else writes): turns are assigned one at a time.

    PostgreSQL rolls back a holder that stays idle for IDLE_TIMEOUT.
    """
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(_set_idle_timeout, func.pg_advisory_xact_lock(ENQUEUE_LOCK)))


def current_time(db: Session) -> datetime:
    """Return the time of the clock that all users of the database share."""
    if db.get_bind().dialect.name == "postgresql":
        return db.execute(NOW).scalar_one()
    return utc_now()


def claim_time(db: Session) -> datetime:
    """Return the time for a claim, whose commit on PostgreSQL will not wait for the disk.

    That wait would be the longest part of a claim. After a crash at that moment the job waits again, and its next claim
    has another token.
    """
    if db.get_bind().dialect.name != "postgresql":
        return utc_now()
    now: datetime = db.execute(NOW_WITHOUT_SYNC).scalar_one()
    return now


def load_flow_state(db: Session, sender: Sender) -> FlowState:
    """Load the turns and the backlog against which a new job of this sender is scheduled."""
    parameters = {"rank": sender.rank, "line": sender.flow, "sender": sender.name, "address": sender.address}
    return FlowState(*select_core(db, FLOW_STATE, parameters).one())


def push_back_flow(db: Session, sender: Sender, own_turn: int) -> int:
    """Move waiting jobs of the flow with a later own turn one turn of the flow back; return the freed turn."""
    moved: Sequence[int] = db.execute(PUSH_BACK_FLOW, {"in_line": sender.flow, "after": own_turn}).scalars().all()
    return min(moved) - TURN_STEP


def insert_job(
    db: Session, kind: str, key: str, payload: Mapping[str, Any], sender: Sender, turn: FairTurn, needs: str | None
) -> UUID:
    """Insert a waiting job; return its id."""
    job_id = uuid4()
    job = {"id": job_id, "kind": kind, "key": key, "payload": dict(payload), "priority": sender.rank, "needs": needs}
    origin = {"sender": sender.name, "address": sender.address, "line": sender.flow}
    schedule = {"turn": turn.flow, "own_turn": turn.own, "created_at": utc_now(), "tries": 0}
    write_core(db, INSERT, {**job, **origin, **schedule})
    return job_id


@dataclass(frozen=True)
class NewLease:
    """A lease to be given to the next job."""

    owner: str
    token: UUID
    now: datetime
    until: datetime


def claim(
    db: Session,
    kinds: Collection[str],
    new: NewLease,
    able: WorkerCapabilities | None,
    among: PrecedingJobs | None = None,
) -> Lease | None:
    """Lease the next waiting job."""
    statement = CLAIMS[able is not None, among is not None]
    parameters = {"owner": new.owner, "token": new.token, "now": new.now, "until": new.until}
    row = select_core(db, statement, {**parameters, **_claim_parameters(kinds, new.now, able, among)}).one_or_none()
    if row is None:
        return None
    return Lease(
        row.id,
        new.token,
        row.kind,
        row.key,
        row.payload,
        row.tries,
        new.now,
        row.needs,
        more_waiting=row.more_waiting,
        rank=row.priority,
        flow=row.line,
    )


def peek_next_job(
    db: Session, kinds: Collection[str], among: PrecedingJobs, able: WorkerCapabilities | None
) -> WaitingJob | None:
    """Return the first of the jobs that go before a running one, without leasing it."""
    statement = FIND_PRECEDING[able is not None]
    row = select_core(db, statement, _claim_parameters(kinds, current_time(db), able, among)).one_or_none()
    return None if row is None else WaitingJob(row.id, row.priority)


def _claim_parameters(
    kinds: Collection[str], now: datetime, able: WorkerCapabilities | None, among: PrecedingJobs | None
) -> dict[str, Any]:
    """Return the parameters that choose a job."""
    parameters: dict[str, Any] = {"kinds": list(kinds)}
    if able is not None:
        parameters |= _capability_parameters(able, now)
    if among is not None:
        parameters |= asdict(among)
    return parameters


def mark_refused(db: Session, kinds: Collection[str], able: WorkerCapabilities) -> bool:
    """Record the first refusal of jobs that need another version; False where there are none."""
    now = current_time(db)
    parameters = {"kinds": list(kinds), "having": list(able.versions)}
    if not db.execute(ANY_VERSION_MISSING, parameters).scalar_one():
        return False
    db.execute(REFUSE, {**parameters, "now": now})
    return True


def _capability_parameters(able: WorkerCapabilities, now: datetime) -> dict[str, Any]:
    return {"having": list(able.versions), "before": now - timedelta(seconds=able.refusal_timeout)}


def extend_lease(db: Session, job_id: UUID, token: UUID, until: datetime) -> bool:
    """Extend the lease; False when it was lost."""
    return db.execute(EXTEND_LEASE, {"held": job_id, "by": token, "until": until}).first() is not None


def delete_leased(db: Session, job_id: UUID, token: UUID) -> bool:
    """Delete the job if its lease is still held; return whether it was."""
    statement = END_WITH_IDLE_TIMEOUT if db.get_bind().dialect.name == "postgresql" else END
    return select_core(db, statement, {"held": job_id, "by": token}).first() is not None


def release_lease(db: Session, job_id: UUID, token: UUID, *, tried: bool) -> bool:
    """Put an unfinished job back in its place; `tried`: this try counts."""
    return db.execute(RELEASE_LEASE, {"held": job_id, "by": token, "untried": 0 if tried else 1}).first() is not None


def lock_leased_jobs(db: Session, kinds: Collection[str]) -> Sequence[Job]:
    """Load and lock the leased jobs of these kinds, but for those locked by others."""
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds))).with_for_update(skip_locked=True)
    return db.execute(query).scalars().all()


def leased_jobs_of(db: Session, kinds: Collection[str], owner: str) -> Sequence[Job]:
    """Load the jobs of these kinds leased to one owner."""
    query = select(Job).where(Job.lease_token.is_not(None), Job.kind.in_(list(kinds)), Job.lease_owner == owner)
    return db.execute(query).scalars().all()


def load_position(db: Session, kind: str, key: str) -> Row[UUID | None, int, datetime | None] | None:
    """Load the job's lease token, the number of waiting jobs before it in claim order, and when it was refused."""
    return db.execute(POSITION, {"kind": kind, "key": key}).one_or_none()


def find_stalled(db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
    """Return a waiting job while none runs: `before` if it still waits, else the next one."""
    parameters = {"kinds": list(kinds), "before": before}
    return db.execute(FIND_STALLED, parameters).scalar_one_or_none()


def count_by_kind(db: Session) -> Mapping[str, int]:
    """Count waiting and running jobs by kind."""
    return {row.kind: row.jobs for row in db.execute(COUNT_BY_KIND)}


def oldest_waiting_ids(db: Session, kind: str, count: int) -> Sequence[UUID]:
    """Return the ids of the oldest waiting jobs of a kind."""
    return db.execute(OLDEST_WAITING.limit(count), {"kind": kind}).scalars().all()


def count_running(db: Session) -> int:
    """Count the leased jobs."""
    return db.execute(select(func.count()).select_from(_jobs).where(_leased)).scalar_one()


def count_waiting(db: Session) -> int:
    """Count the waiting jobs."""
    return db.execute(select(func.count()).select_from(_jobs).where(_waits)).scalar_one()


def count_refused_by_version(db: Session) -> Mapping[str, int]:
    """Count refused waiting jobs by the version they require."""
    return {needs: count for needs, count in db.execute(COUNT_REFUSED) if needs is not None}
