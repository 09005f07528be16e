"""Interfaces of the job queue: queue, notifier, worker tasks, sources of work.

Queue methods run inside the caller's transaction: a job is enqueued with the rows it concerns and ends with its result.
Notifications only save waiting: whoever misses one finds the same job by a slow poll.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal, Protocol, TypeVar
from uuid import UUID

from sqlalchemy.orm import Session

from server.queue.lease_owner import LeaseOwner

#: Lanes: somebody waits for interactive jobs, so that workers claim them first.
INTERACTIVE, BACKGROUND = "interactive", "background"
Work = TypeVar("Work")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Lease:
    """A job claimed by one worker. Only the holder of `token` (the fence token) may end the job.

    `required_version` names the exercise version its worker must have, if any. `more_waiting`: other jobs of the
    requested kinds waited when this one was claimed.
    """

    job_id: UUID
    token: UUID
    kind: str
    key: str
    payload: Mapping[str, Any]
    tries: int
    started_at: datetime
    required_version: str | None = None
    more_waiting: bool = True
    rank: int = 0
    flow: str = ""


@dataclass(frozen=True)
class PrecedingJobs:
    """A filter of waiting jobs: those that go before a running one.

    They are of ranks below `ranks_below`, or of `same_rank` and of another flow than `excluded_flow`.
    """

    ranks_below: int
    same_rank: int | None = None
    excluded_flow: str = ""


@dataclass(frozen=True)
class WaitingJob:
    """The job that would be claimed next."""

    job_id: UUID
    rank: int


@dataclass(frozen=True)
class JobNotification:
    """One more job of `kind` may be claimed. `message_id`, for deduplication, identifies the job and its attempt."""

    kind: str
    message_id: str


@dataclass(frozen=True)
class WorkerCapabilities:
    """The versions of exercises a worker can grade; it also claims jobs that require none.

    A job refused for `refusal_timeout` seconds may be claimed by any worker.
    """

    versions: Collection[str]
    refusal_timeout: float


@dataclass(frozen=True)
class JobStatus:
    """`position` is 1 for the next job to be claimed, 0 for a claimed one.

    `refused`: so far, every worker that could have claimed it had another version of its exercise.
    """

    position: int
    refused: bool = False


@dataclass(frozen=True)
class Sender:
    """The account or guest for which a job is done. Lower ranks go first; fair queueing alternates between flows.

    `name` identifies one account; `address` is the network address it sends from; senders of one `flow` alternate too.
    """

    name: str = ""
    address: str = ""
    flow: str = ""
    rank: int = 0


@dataclass(frozen=True)
class BacklogLimits:
    """Maximum number of waiting jobs of one sender, and of one address within one rank."""

    per_sender: int
    per_address: int


class QueueFullError(Exception):
    """The backlog limit of the sender or of the address is reached."""

    def __init__(self, scope: Literal["sender", "address"]) -> None:
        super().__init__(f"the backlog limit of this {scope} is reached")
        self.scope = scope


NO_SENDER = Sender()
#: Suffix of a job-started notification, after the job's key; watchers of the job's end ignore it.
JOB_STARTED_SUFFIX = " begun"
#: Key of the payload that holds the id of the originating request, for the logs.
REQUEST_ID_KEY = "request"
GiveUpHandler = Callable[[Session, Lease], None]


class Task(Protocol[Work, Result]):
    """How one kind of job is done."""

    def read(self, db: Session, lease: Lease) -> Work | None:
        """Load the input as the job is claimed; None where nothing is left to do."""

    def run(self, work: Work) -> Result:
        """Do the work, outside of any transaction."""

    def record(self, db: Session, work: Work, result: Result) -> None:
        """Write the result, in the transaction that ends the job: exactly once."""

    def give_up(self, db: Session, lease: Lease) -> None:
        """Record that the job failed too often, in the transaction that ends it."""


Tasks = Mapping[str, Task[Any, Any]]


class Queue(Protocol):
    """A queue of leased jobs. Every method uses the session of the caller's transaction."""

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
        """Add a job to its sender's flow, at most one at a time of this kind and key. Raises QueueFullError."""

    def claim(
        self,
        db: Session,
        owner: LeaseOwner,
        kinds: Collection[str],
        lease_seconds: float,
        capabilities: WorkerCapabilities | None = None,
        among: PrecedingJobs | None = None,
    ) -> Lease | None:
        """Lease the next waiting job of these kinds that the worker can do, if any; with `among`, one of those."""

    def peek_next_job(
        self, db: Session, kinds: Collection[str], among: PrecedingJobs, capabilities: WorkerCapabilities | None
    ) -> WaitingJob | None:
        """Return the job that `claim` would lease, if any, without leasing it."""

    def mark_refused(self, db: Session, kinds: Collection[str], capabilities: WorkerCapabilities) -> bool:
        """Mark waiting jobs that need workers of other versions; return whether there are any."""

    def heartbeat(self, db: Session, lease: Lease, lease_seconds: float) -> bool:
        """Extend a lease; False when it has been lost."""

    def finish(self, db: Session, lease: Lease) -> bool:
        """End a job, once; False when the lease has been lost: nothing may be recorded then."""

    def fail(self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUpHandler], *, last: bool = False) -> None:
        """Return a job for another try, or give it up after too many tries or when `last`."""

    def requeue_untried(self, db: Session, lease: Lease) -> None:
        """Put back in its place a job that its worker was told to leave; this try does not count."""

    def recover_lost(self, db: Session, here: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        """Take back all leases that expired or whose holder died; return how many."""

    def recover_from(self, db: Session, owner: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        """Take back the leases of a worker that has just died; return how many."""

    def position(self, db: Session, kind: str, key: str) -> int | None:
        """1 for the next job to be claimed, 0 for a claimed one, None for an unknown one."""

    def status(self, db: Session, kind: str, key: str) -> JobStatus | None:
        """None for an unknown job."""

    def find_stalled(self, db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
        """Return a job of these kinds that waits while none is running: `before` if it still waits, else the next one.

        None where one is running, or none waits.
        """


class QueueNotifier(Protocol):
    """Notifications to other processes, sent once the transaction is committed."""

    def job_queued(self, db: Session, call: JobNotification, /) -> None:
        """A job waits: wake an idle worker."""

    def job_changed(self, db: Session, notification: str) -> None:
        """A job ended or went back (its key), or was claimed (its key and JOB_STARTED_SUFFIX)."""


class WorkSource(Protocol):
    """A source of wake-ups for an idle worker."""

    @property
    def buffers_wakeups(self) -> bool:
        """Whether wake-ups sent to a busy worker are kept, so that its next `wait` returns at once."""

    def wait(self, seconds: float) -> bool:
        """Return when there may be work, or after `seconds`; False means that the worker must stop."""


class WorkMessage(Protocol):
    """A received message that entitles a worker to claim one job; held while the job runs, then acknowledged or not."""

    @property
    def kinds(self) -> Collection[str]:
        """The kinds of jobs that it entitles to."""

    @property
    def redelivered(self) -> bool:
        """Whether its earlier holder went silent: that holder's jobs may need recovery."""

    def in_progress(self) -> None:
        """Extend the acknowledgement deadline; from any thread."""

    def ack(self, *, job_done: bool) -> None:
        """Acknowledge it: a job was done, or there was none."""

    def nak(self, *, delayed: bool) -> None:
        """Have it redelivered to another worker: at once, or with a delay."""


class WorkSubscription(Protocol):
    """Where a worker receives messages: `wait`, which may be interrupted, then `take_message`."""

    def wait(self, seconds: float) -> None:
        """Return when a message has arrived, or after `seconds`."""

    def take_message(self) -> WorkMessage | None:
        """Return the message that has arrived, if any."""


class NullNotifier:
    """Notifies nobody: everyone polls."""

    def job_queued(self, db: Session, call: JobNotification, /) -> None:
        return

    def job_changed(self, db: Session, notification: str) -> None:
        return
