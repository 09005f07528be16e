"""The queue: rows with a lease.

A worker claims the oldest waiting row and holds a lease that its heartbeat extends. The result is written only by the
lease's holder. A row whose holder is dead, or whose lease has run out, goes back to the queue; after `MAX_ATTEMPTS` it
is given up with an internal error, which is ours and never counted against the student.
"""

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import timedelta
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy.orm import Session

from server.database import utc_now
from server.limits import service as limits
from server.queue import repository
from server.queue.owner import Owner, is_dead
from server.queue.port import signals_of
from server.submissions.models import INTERNAL_ERROR, State, Submission

log = logging.getLogger(__name__)

MAX_ATTEMPTS = 3

Result = dict[str, Any]
GiveUp = Callable[[Submission], Result]


@dataclass(frozen=True)
class Lease:
    """What a worker needs to grade, and the token that lets it write the result."""

    submission_id: UUID
    token: UUID
    exercise: str
    source: bytes
    seed: int


def enqueue(db: Session, submission: Submission) -> None:
    db.add(submission)
    db.flush()
    signals_of(db).queued(db)


def position(db: Session, submission: Submission) -> int | None:
    """1 for the next one to be graded; None when it no longer waits."""
    if submission.state != State.queued:
        return None
    return repository.waiting_before(db, submission) + 1


def claim(db: Session, owner: Owner, lease_seconds: float) -> Lease | None:
    token, now = uuid4(), utc_now()
    until = now + timedelta(seconds=lease_seconds)
    row = repository.claim(db, owner=str(owner), token=token, now=now, until=until)
    if row is None:
        return None
    signals_of(db).changed(db, row.id)
    return Lease(row.id, token, row.exercise, row.source, row.seed)


def heartbeat(db: Session, lease: Lease, lease_seconds: float) -> bool:
    """Extends the lease; False when it has been lost."""
    return repository.extend(db, lease.submission_id, lease.token, utc_now() + timedelta(seconds=lease_seconds))


def finish(db: Session, lease: Lease, result: Result) -> bool:
    """Records a result, once: False when another holder has taken over, and nothing is written then."""
    recorded = _finish(db, lease.submission_id, lease.token, result)
    if recorded:
        signals_of(db).changed(db, lease.submission_id)
    return recorded


def _finish(db: Session, submission_id: UUID, token: UUID, result: Result) -> bool:
    """Our own failure costs its author nothing: what it took from their allowance comes back with it."""
    recorded = repository.finish(db, submission_id, token, result)
    if recorded and result["outcome"] == INTERNAL_ERROR:
        limits.give_back(db, limits.of_submissions(repository.account_of(db, submission_id)))
    return recorded


def give_back(db: Session, lease: Lease) -> None:
    """For a worker told to stop in the middle of a grading."""
    if repository.give_back(db, lease.submission_id, lease.token):
        signals_of(db).queued(db)
        signals_of(db).changed(db, lease.submission_id)


def recover(db: Session, here: Owner, give_up: GiveUp) -> int:
    """Takes back every lease that has run out or whose holder is dead; returns how many."""
    now = utc_now()
    lost = [row for row in repository.running(db) if _is_lost(row, here) or (row.lease_until or now) <= now]
    return _take_back(db, lost, give_up)


def release(db: Session, owner: Owner, give_up: GiveUp) -> int:
    """Takes back the leases of a worker that has just died; returns how many."""
    return _take_back(db, repository.running_of(db, str(owner)), give_up)


def _is_lost(row: Submission, here: Owner) -> bool:
    return row.lease_owner is None or is_dead(row.lease_owner, here)


def _take_back(db: Session, rows: Iterable[Submission], give_up: GiveUp) -> int:
    count = 0
    for row in rows:
        count += _take_one_back(db, row, give_up)
    return count


def _take_one_back(db: Session, row: Submission, give_up: GiveUp) -> bool:
    token = row.lease_token or uuid4()
    if row.attempts >= MAX_ATTEMPTS:
        log.error(
            "submission %s of %s: given up, %d attempts ended their workers (seed %d, %d bytes, digest %s)",
            *(row.id, row.exercise, row.attempts, row.seed, len(row.source), row.digest),
        )
        taken = _finish(db, row.id, token, give_up(row))
    else:
        log.warning("submission %s of %s: its worker is gone, queued again", row.id, row.exercise)
        taken = repository.requeue(db, row.id, token)
        signals_of(db).queued(db)
    signals_of(db).changed(db, row.id)
    return taken
