"""The queue kept in a table: rows with a lease.

A worker claims the next waiting row and holds a lease that its heartbeat extends. Only the lease's holder ends the job,
in the transaction that records its result. A row whose holder is dead, or whose lease has run out, goes back to the
queue; after `MAX_TRIES` it is given up.
"""

import logging
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy.orm import Session

from server.base import logs, traces
from server.queue import repository
from server.queue.fair_queueing import Crowd, next_turn
from server.queue.interfaces import (
    JOB_STARTED_SUFFIX,
    NO_SENDER,
    REQUEST_ID_KEY,
    BacklogLimits,
    GiveUpHandler,
    JobNotification,
    JobStatus,
    Lease,
    QueueFullError,
    QueueNotifier,
    Sender,
    WorkerCapabilities,
)
from server.queue.lease_owner import LeaseOwner, is_dead
from server.queue.models import Job

log = logging.getLogger(__name__)

MAX_TRIES = 3


class TableQueue:
    """Fills the port `server.queue.interfaces.Queue` with the table `job`."""

    def __init__(self, notifier: QueueNotifier) -> None:
        self._signals = notifier

    def enqueue(
        self,
        db: Session,
        kind: str,
        key: str,
        payload: Mapping[str, Any] | None = None,
        sender: Sender = NO_SENDER,
        limits: BacklogLimits | None = None,
        required_version: str | None = None,
    ) -> None:
        repository.one_at_a_time(db)
        crowd = repository.crowd(db, sender)
        if limits is not None:
            _require_room(crowd, limits)
        turn = next_turn(crowd)
        if turn.pushes:
            turn = replace(turn, line=repository.push(db, sender, turn.own))
        request = logs.current_request_id()
        carried = {**(payload or {}), **({REQUEST_ID_KEY: request} if request else {}), **traces.job_trace_fields(key)}
        name = repository.put(db, kind, key, carried, sender, turn, required_version)
        self._signals.job_queued(db, JobNotification(kind, str(name)))

    def claim(
        self,
        db: Session,
        owner: LeaseOwner,
        kinds: Collection[str],
        lease_seconds: float,
        capabilities: WorkerCapabilities | None = None,
    ) -> Lease | None:
        token, now = uuid4(), repository.begin_leasing(db)
        until = now + timedelta(seconds=lease_seconds)
        lease = repository.claim(db, kinds, owner=str(owner), token=token, now=now, until=until, able=capabilities)
        if lease is not None:
            self._signals.job_changed(db, lease.key + JOB_STARTED_SUFFIX)
        return lease

    def mark_refused(self, db: Session, kinds: Collection[str], capabilities: WorkerCapabilities) -> bool:
        return repository.refuse(db, kinds, capabilities)

    def heartbeat(self, db: Session, lease: Lease, lease_seconds: float) -> bool:
        until = repository.clock(db) + timedelta(seconds=lease_seconds)
        return repository.extend(db, lease.job_id, lease.token, until)

    def finish(self, db: Session, lease: Lease) -> bool:
        ended = repository.end(db, lease.job_id, lease.token)
        if ended:
            self._signals.job_changed(db, lease.key)
        return ended

    def fail(self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUpHandler], *, last: bool = False) -> None:
        self._take_back(db, lease, give_ups, last=last)

    def requeue_untried(self, db: Session, lease: Lease) -> None:
        if repository.free(db, lease.job_id, lease.token, tried=False):
            self._signals.job_queued(db, _anew(lease))
            self._signals.job_changed(db, lease.key)

    def recover_lost(self, db: Session, here: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        now = repository.clock(db)
        lost = [job for job in repository.leased(db, give_ups.keys()) if _is_lost(job, here, now)]
        return self._take_all_back(db, lost, give_ups)

    def recover_from(self, db: Session, owner: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        return self._take_all_back(db, repository.leased_to(db, give_ups.keys(), str(owner)), give_ups)

    def position(self, db: Session, kind: str, key: str) -> int | None:
        found = self.status(db, kind, key)
        return None if found is None else found.position

    def status(self, db: Session, kind: str, key: str) -> JobStatus | None:
        place = repository.place(db, kind, key)
        if place is None:
            return None
        token, ahead, refused_at = place
        return JobStatus(0) if token is not None else JobStatus(ahead + 1, refused_at is not None)

    def find_stalled(self, db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
        return repository.untaken(db, kinds, before)

    def _take_all_back(self, db: Session, jobs: Iterable[Job], give_ups: Mapping[str, GiveUpHandler]) -> int:
        return sum(self._take_back(db, _lease(job), give_ups) for job in jobs)

    def _take_back(
        self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUpHandler], *, last: bool = False
    ) -> bool:
        """False when another has taken it back already."""
        if lease.tries < MAX_TRIES and not last:
            taken = repository.free(db, lease.job_id, lease.token, tried=True)
            if taken:
                log.warning("job %s %s: its try has failed, queued again", lease.kind, lease.key)
                self._signals.job_queued(db, _anew(lease))
        else:
            taken = repository.end(db, lease.job_id, lease.token)
            if taken:
                log.error("job %s %s: given up after %d tries", lease.kind, lease.key, lease.tries)
                give_ups[lease.kind](db, lease)
        if taken:
            self._signals.job_changed(db, lease.key)
        return taken


def _require_room(crowd: Crowd, most: BacklogLimits) -> None:
    if crowd.of_sender >= most.per_sender:
        raise QueueFullError("sender")
    if crowd.from_address >= most.per_address:
        raise QueueFullError("address")


def _anew(lease: Lease) -> JobNotification:
    """The call for a job that waits again, after this attempt."""
    return JobNotification(lease.kind, f"{lease.job_id}:{lease.token}")


def _is_lost(job: Job, here: LeaseOwner, now: datetime) -> bool:
    if job.lease_owner is None or job.lease_until is None:
        raise ValueError(f"job {job.id} is leased to nobody, or for ever")
    return is_dead(job.lease_owner, here) or job.lease_until <= now


def _lease(job: Job) -> Lease:
    """The lease that a row holds."""
    if job.lease_token is None or job.started_at is None:
        raise ValueError(f"job {job.id} is not leased")
    return Lease(
        job.id, job.lease_token, job.kind, job.key, job.payload, job.tries, job.started_at, job.required_version
    )
