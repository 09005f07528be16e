"""The job queue in a table: rows with a lease.

A worker claims the next waiting row; its heartbeat extends the lease. Only the lease's holder ends the job, in the
transaction that records its result. A row whose holder is dead, or whose lease has expired, waits again; after
`MAX_TRIES` it is given up.
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
from server.queue.fair_queueing import FlowState, next_turn
from server.queue.interfaces import (
    JOB_STARTED_SUFFIX,
    NO_SENDER,
    REQUEST_ID_KEY,
    BacklogLimits,
    GiveUpHandler,
    JobNotification,
    JobStatus,
    Lease,
    PrecedingJobs,
    QueueFullError,
    QueueNotifier,
    Sender,
    WaitingJob,
    WorkerCapabilities,
)
from server.queue.lease_owner import LeaseOwner, is_owner_dead
from server.queue.models import Job

log = logging.getLogger(__name__)

MAX_TRIES = 3


class TableQueue:
    """Implements `server.queue.interfaces.Queue` with the table `job`."""

    def __init__(self, notifier: QueueNotifier) -> None:
        self._notifier = notifier

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
        repository.lock_enqueueing(db)
        state = repository.load_flow_state(db, sender)
        if limits is not None:
            _require_within_limits(state, limits)
        turn = next_turn(state)
        if turn.pushes_back:
            turn = replace(turn, flow=repository.push_back_flow(db, sender, turn.own))
        request = logs.current_request_id()
        annotated = {
            **(payload or {}),
            **({REQUEST_ID_KEY: request} if request else {}),
            **traces.job_trace_fields(key),
        }
        job_id = repository.insert_job(db, kind, key, annotated, sender, turn, required_version)
        self._notifier.job_queued(db, JobNotification(kind, str(job_id)))

    def claim(
        self,
        db: Session,
        owner: LeaseOwner,
        kinds: Collection[str],
        lease_seconds: float,
        capabilities: WorkerCapabilities | None = None,
        among: PrecedingJobs | None = None,
    ) -> Lease | None:
        token, now = uuid4(), repository.claim_time(db)
        until = now + timedelta(seconds=lease_seconds)
        new_lease = repository.NewLease(str(owner), token, now, until)
        lease = repository.claim(db, kinds, new_lease, capabilities, among)
        if lease is not None:
            self._notifier.job_changed(db, lease.key + JOB_STARTED_SUFFIX)
        return lease

    def peek_next_job(
        self, db: Session, kinds: Collection[str], among: PrecedingJobs, capabilities: WorkerCapabilities | None
    ) -> WaitingJob | None:
        return repository.peek_next_job(db, kinds, among, capabilities)

    def mark_refused(self, db: Session, kinds: Collection[str], capabilities: WorkerCapabilities) -> bool:
        return repository.mark_refused(db, kinds, capabilities)

    def heartbeat(self, db: Session, lease: Lease, lease_seconds: float) -> bool:
        until = repository.current_time(db) + timedelta(seconds=lease_seconds)
        return repository.extend_lease(db, lease.job_id, lease.token, until)

    def finish(self, db: Session, lease: Lease) -> bool:
        ended = repository.delete_leased(db, lease.job_id, lease.token)
        if ended:
            self._notifier.job_changed(db, lease.key)
        return ended

    def fail(self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUpHandler], *, last: bool = False) -> None:
        self._recover(db, lease, give_ups, last=last)

    def requeue_untried(self, db: Session, lease: Lease) -> None:
        if repository.release_lease(db, lease.job_id, lease.token, tried=False):
            self._notifier.job_queued(db, _requeued_notification(lease))
            self._notifier.job_changed(db, lease.key)

    def recover_lost(self, db: Session, here: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        now = repository.current_time(db)
        lost = [job for job in repository.lock_leased_jobs(db, give_ups.keys()) if _is_lost(job, here, now)]
        return self._recover_all(db, lost, give_ups)

    def recover_from(self, db: Session, owner: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        return self._recover_all(db, repository.leased_jobs_of(db, give_ups.keys(), str(owner)), give_ups)

    def position(self, db: Session, kind: str, key: str) -> int | None:
        status = self.status(db, kind, key)
        return None if status is None else status.position

    def status(self, db: Session, kind: str, key: str) -> JobStatus | None:
        row = repository.load_position(db, kind, key)
        if row is None:
            return None
        token, ahead, refused_at = row
        return JobStatus(0) if token is not None else JobStatus(ahead + 1, refused_at is not None)

    def find_stalled(self, db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
        return repository.find_stalled(db, kinds, before)

    def _recover_all(self, db: Session, jobs: Iterable[Job], give_ups: Mapping[str, GiveUpHandler]) -> int:
        return sum(self._recover(db, _lease_from_row(job), give_ups) for job in jobs)

    def _recover(self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUpHandler], *, last: bool = False) -> bool:
        """Requeue the job, or give it up; False when another has recovered it already."""
        if lease.tries < MAX_TRIES and not last:
            recovered = repository.release_lease(db, lease.job_id, lease.token, tried=True)
            if recovered:
                log.warning("job %s %s: its try has failed, queued again", lease.kind, lease.key)
                self._notifier.job_queued(db, _requeued_notification(lease))
        else:
            recovered = repository.delete_leased(db, lease.job_id, lease.token)
            if recovered:
                log.error("job %s %s: given up after %d tries", lease.kind, lease.key, lease.tries)
                give_ups[lease.kind](db, lease)
        if recovered:
            self._notifier.job_changed(db, lease.key)
        return recovered


def _require_within_limits(state: FlowState, limits: BacklogLimits) -> None:
    if state.waiting_of_sender >= limits.per_sender:
        raise QueueFullError("sender")
    if state.waiting_from_address >= limits.per_address:
        raise QueueFullError("address")


def _requeued_notification(lease: Lease) -> JobNotification:
    """Return the notification for a job that waits again after this attempt."""
    return JobNotification(lease.kind, f"{lease.job_id}:{lease.token}")


def _is_lost(job: Job, here: LeaseOwner, now: datetime) -> bool:
    if job.lease_owner is None or job.lease_until is None:
        raise ValueError(f"job {job.id} is leased to nobody, or for ever")
    return is_owner_dead(job.lease_owner, here) or job.lease_until <= now


def _lease_from_row(job: Job) -> Lease:
    """Return the lease that a row holds."""
    if job.lease_token is None or job.started_at is None:
        raise ValueError(f"job {job.id} is not leased")
    return Lease(
        job.id,
        job.lease_token,
        job.kind,
        job.key,
        job.payload,
        job.tries,
        job.started_at,
        job.required_version,
        rank=job.priority,
        flow=job.flow,
    )
