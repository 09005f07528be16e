"""Queries of the queue: enqueue, claim, heartbeat, conditional end, recovery.

Each change of state is ONE conditional statement, hence atomic on both databases. One clock times the leases: that of
PostgreSQL, else the machine's.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any
from uuid import UUID

from sqlalchemy import (
    ColumnElement,
    Row,
    Select,
    and_,
    case,
    delete,
    exists,
    func,
    literal_column,
    or_,
    select,
    tuple_,
    update,
)
from sqlalchemy.orm import Session, aliased

from server.database import UtcDateTime, utc_now
from server.queue.fair_queueing import TURN_STEP, FlowState, Turn
from server.queue.interfaces import Lease, Precedence, Sender, WaitingJob, WorkerCapabilities
from server.queue.models import Job

#: Key of PostgreSQL's advisory lock for enqueueing.
ENQUEUE_LOCK = 0x7475726E
#: Idle timeout of a transaction for which others wait.
IDLE_TIMEOUT = "5s"

_waits, _leased = Job.lease_token.is_(None), Job.lease_token.is_not(None)
_order = (Job.priority, Job.turn, Job.created_at, Job.id)
_set_idle_timeout = func.set_config("idle_in_transaction_session_timeout", IDLE_TIMEOUT, True)


def lock_enqueueing(db: Session) -> None:
    """Until the commit, nobody else enqueues (on SQLite, nobody else writes): turns are assigned one at a time.

    PostgreSQL rolls back a holder that stays idle for IDLE_TIMEOUT.
    """
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(_set_idle_timeout, func.pg_advisory_xact_lock(ENQUEUE_LOCK)))


def current_time(db: Session) -> datetime:
    """Return the time of the clock that all users of the database share."""
    if db.get_bind().dialect.name == "postgresql":
        return db.execute(select(func.clock_timestamp(type_=UtcDateTime()))).scalar_one()
    return utc_now()


def claim_time(db: Session) -> datetime:
    """Return the time for a claim, whose commit on PostgreSQL will not wait for the disk.

    That wait would be the longest part of a claim. After a crash at that moment the job waits again, and its next claim
    has another token.
    """
    if db.get_bind().dialect.name != "postgresql":
        return utc_now()
    without_sync = func.set_config("synchronous_commit", "off", True)
    now: datetime = db.execute(select(func.clock_timestamp(type_=UtcDateTime()), without_sync)).scalar_one()
    return now


def load_flow_state(db: Session, sender: Sender) -> FlowState:
    """Load the turns and the backlog against which a new job of this sender is scheduled."""
    of_rank, of_sender = Job.priority == sender.rank, and_(_waits, Job.sender == sender.name)
    served_turn = select(func.max(Job.turn)).where(_leased, of_rank)
    first_waiting_turn = select(Job.turn).where(_waits, of_rank).order_by(*_order).limit(1)
    waiting_from_address = select(func.count()).where(_waits, of_rank, Job.address == sender.address)
    query = select(
        served_turn.scalar_subquery(),
        first_waiting_turn.scalar_subquery(),
        func.max(Job.turn).filter(_waits),
        func.max(Job.own_turn).filter(_leased),
        func.min(Job.own_turn).filter(_waits),
        func.max(Job.own_turn).filter(_waits),
        func.max(Job.own_turn).filter(of_sender),
        func.count().filter(of_sender),
        waiting_from_address.scalar_subquery(),
    )
    return FlowState(*db.execute(query.where(Job.flow == sender.flow)).one())


def push_back_flow(db: Session, sender: Sender, own_turn: int) -> int:
    """Move waiting jobs of the flow with a later own turn one turn of the flow back; return the freed turn."""
    statement = update(Job).where(_waits, Job.flow == sender.flow, Job.own_turn > own_turn)
    moved = db.execute(statement.values(turn=Job.turn + TURN_STEP).returning(Job.turn)).scalars()
    return min(moved) - TURN_STEP


def insert_job(
    db: Session, kind: str, key: str, payload: Mapping[str, Any], sender: Sender, turn: Turn, needs: str | None
) -> UUID:
    """Insert a waiting job; return its id."""
    job = Job(kind=kind, key=key, payload=dict(payload), priority=sender.rank, required_version=needs)
    job.sender, job.address, job.flow = sender.name, sender.address, sender.flow
    job.turn, job.own_turn = turn.flow, turn.own
    db.add(job)
    db.flush()
    return job.id


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
    precedence: Precedence | None = None,
) -> Lease | None:
    """Lease the next waiting job."""
    # PostgreSQL skips rows that another claim has locked; SQLite serialises its writers.
    next_job = _select_next(kinds, new.now, able, precedence).with_for_update(skip_locked=True)
    statement = update(Job).where(Job.id == next_job.scalar_subquery())
    statement = statement.values(
        tries=Job.tries + 1,
        lease_owner=new.owner,
        lease_token=new.token,
        lease_until=new.until,
        started_at=new.now,
    )
    columns = (Job.id, Job.kind, Job.key, Job.payload, Job.tries, Job.required_version, Job.priority, Job.flow)
    statement = statement.returning(*columns, _more_waiting(kinds))
    row = db.execute(statement, execution_options={"synchronize_session": False}).one_or_none()
    if row is None:
        return None
    job_id, kind, key, payload, tries, version, rank, flow, more_waiting = row
    return Lease(
        job_id, new.token, kind, key, payload, tries, new.now, version, more_waiting=more_waiting, rank=rank, flow=flow
    )


def _more_waiting(kinds: Collection[str]) -> ColumnElement[bool]:
    """Return whether another job waits, beside the one just claimed.

    Excludes that job by its id: the databases differ on whether it still waits at that moment. The literal column keeps
    its table name, which SQLite loses in a RETURNING clause.
    """
    other = aliased(Job)
    return exists().where(other.lease_token.is_(None), other.kind.in_(kinds), other.id != literal_column("job.id"))


def find_preceding(
    db: Session, kinds: Collection[str], precedence: Precedence, able: WorkerCapabilities | None
) -> WaitingJob | None:
    """Return the waiting job that goes before a running one."""
    query = _select_next(kinds, current_time(db), able, precedence).add_columns(Job.priority)
    row = db.execute(query).one_or_none()
    return None if row is None else WaitingJob(*row)


def _select_next(
    kinds: Collection[str], now: datetime, able: WorkerCapabilities | None, precedence: Precedence | None
) -> Select[UUID]:
    """Select the id of the next job.

    With `able`: of jobs whose version the worker has, or that were refused longer ago than the timeout. With
    `precedence`: of jobs that go before a running one.
    """
    query = select(Job.id).where(_waits, Job.kind.in_(kinds)).order_by(*_order).limit(1)
    if able is not None:
        refused_before = Job.refused_at <= now - timedelta(seconds=able.refusal_timeout)
        query = query.where(or_(_version_available(able), refused_before))
    if precedence is not None:
        other_flow = and_(Job.priority == precedence.rank, Job.flow != precedence.flow)
        query = query.where(or_(Job.priority < precedence.below, other_flow))
    return query


def _version_available(able: WorkerCapabilities) -> ColumnElement[bool]:
    return or_(Job.required_version.is_(None), Job.required_version.in_(able.versions))


def mark_refused(db: Session, kinds: Collection[str], able: WorkerCapabilities) -> bool:
    """Record the first refusal of jobs that need another version; False where there are none."""
    now = current_time(db)
    missing = and_(_waits, Job.kind.in_(kinds), ~_version_available(able))
    if not db.execute(select(exists().where(missing))).scalar_one():
        return False
    db.execute(update(Job).where(missing, Job.refused_at.is_(None)).values(refused_at=now))
    return True


def extend_lease(db: Session, job_id: UUID, token: UUID, until: datetime) -> bool:
    """Extend the lease; False when it was lost."""
    statement = update(Job).where(_is_held(job_id, token)).values(lease_until=until)
    return db.execute(statement.returning(Job.id)).first() is not None


def delete_leased(db: Session, job_id: UUID, token: UUID) -> bool:
    """Delete the job if its lease is still held; return whether it was."""
    # On PostgreSQL, the result that follows locks rows for which others may wait.
    timeout = (_set_idle_timeout,) if db.get_bind().dialect.name == "postgresql" else ()
    return db.execute(delete(Job).where(_is_held(job_id, token)).returning(Job.id, *timeout)).first() is not None


def release_lease(db: Session, job_id: UUID, token: UUID, *, tried: bool) -> bool:
    """Put an unfinished job back in its place; `tried`: this try counts."""
    no_lease = {"lease_owner": None, "lease_token": None, "lease_until": None, "started_at": None}
    statement = update(Job).where(_is_held(job_id, token)).values(tries=Job.tries - (0 if tried else 1), **no_lease)
    return db.execute(statement.returning(Job.id)).first() is not None


def _is_held(job_id: UUID, token: UUID) -> ColumnElement[bool]:
    return and_(Job.id == job_id, Job.lease_token == token)


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
    other = aliased(Job)
    sort_key, other_sort_key = (tuple_(job.priority, job.turn, job.created_at, job.id) for job in (Job, other))
    ahead = select(func.count()).select_from(other).where(other.lease_token.is_(None), other_sort_key < sort_key)
    query = select(Job.lease_token, ahead.scalar_subquery(), Job.refused_at)
    return db.execute(query.where(Job.kind == kind, Job.key == key)).one_or_none()


def find_stalled(db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
    """Return a waiting job while none runs: `before` if it still waits, else the next one."""
    query = select(Job.id).where(_waits, Job.kind.in_(kinds), ~exists().where(aliased(Job).lease_token.is_not(None)))
    return db.execute(query.order_by(case((Job.id == before, 0), else_=1), *_order).limit(1)).scalar_one_or_none()


def count_by_kind(db: Session) -> Mapping[str, int]:
    """Count waiting and running jobs by kind."""
    return dict(db.execute(select(Job.kind, func.count()).group_by(Job.kind)).all())


def oldest_waiting_ids(db: Session, kind: str, count: int) -> Sequence[UUID]:
    """Return the ids of the oldest waiting jobs of a kind."""
    query = select(Job.id).where(_waits, Job.kind == kind).order_by(Job.created_at, Job.id)
    return db.execute(query.limit(count)).scalars().all()


def count_running(db: Session) -> int:
    """Count the leased jobs."""
    return db.execute(select(func.count()).select_from(Job).where(_leased)).scalar_one()


def count_waiting(db: Session) -> int:
    """Count the waiting jobs."""
    return db.execute(select(func.count()).select_from(Job).where(_waits)).scalar_one()


def count_refused_by_version(db: Session) -> Mapping[str, int]:
    """Count refused waiting jobs by the version they require."""
    query = select(Job.required_version, func.count()).where(_waits, Job.refused_at.is_not(None))
    rows = db.execute(query.group_by(Job.required_version))
    return {version: count for version, count in rows if version is not None}
