"""The port between whoever has work to be done later, whoever does it and whoever waits for it.

A queue's methods work inside the caller's transaction, so that a job is put with what it is about, and ends with its
result. Signals only save waiting: if one is lost, a slow poll finds the same thing later.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal, Protocol, TypeVar
from uuid import UUID

from sqlalchemy.orm import Session

from server.queue.lease_owner import LeaseOwner

#: What somebody waits for, and what nobody does: a worker does the former first.
INTERACTIVE, BACKGROUND = "interactive", "background"
Work = TypeVar("Work")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Lease:
    """A job that one worker has begun, and the token that lets it end the job: the fence.

    `needs` is what its worker must have, if anything (an exercise in one version). `followed`: as it was begun, others
    of the kinds asked for waited.
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


@dataclass(frozen=True)
class JobNotification:
    """That one more job of a kind may be begun. `name` is this call's own: of the job, and of its attempt before."""

    kind: str
    message_id: str


@dataclass(frozen=True)
class WorkerCapabilities:
    """What a worker can do: jobs that need nothing, or one of `having`; any other that waits since a refusal.

    `patience`, in seconds: that long after it was first refused, a job is anybody's.
    """

    versions: Collection[str]
    refusal_timeout: float


@dataclass(frozen=True)
class JobStatus:
    """Where a job is: `position` is 1 for the next to begin, 0 for one that has begun. `refused`: as yet, all workers
    that could have begun it were of another version."""

    position: int
    refused: bool = False


@dataclass(frozen=True)
class Sender:
    """Whose a job is. Lower ranks go first; within a rank turns go round the lines, and in a line round its senders.

    `name` is one account, whatever it calls itself; `address` is where it sends from.
    """

    name: str = ""
    address: str = ""
    flow: str = ""
    rank: int = 0


@dataclass(frozen=True)
class BacklogLimits:
    """How many jobs may wait: of one sender, and from one address in one rank."""

    per_sender: int
    per_address: int


class QueueFullError(Exception):
    """So much waits already that no more is taken; `whose` heap it is."""

    def __init__(self, scope: Literal["sender", "address"]) -> None:
        super().__init__(f"the heap of this {scope} is as high as it may be")
        self.scope = scope


NO_SENDER = Sender()
#: What news add to a job's key where it has begun, and no more: who waits for its end alone need not look yet.
JOB_STARTED_SUFFIX = " begun"
#: Where a job's payload keeps the request that it comes from, for the logs.
REQUEST_ID_KEY = "request"
GiveUpHandler = Callable[[Session, Lease], None]


class Task(Protocol[Work, Result]):
    """How one kind of job is done."""

    def read(self, db: Session, lease: Lease) -> Work | None:
        """What the work needs, read as the job is claimed; None where nothing is left to do."""

    def run(self, work: Work) -> Result:
        """The work itself, outside of any transaction."""

    def record(self, db: Session, work: Work, result: Result) -> None:
        """Writes the result in the transaction that ends the job: once, whatever dies."""

    def give_up(self, db: Session, lease: Lease) -> None:
        """Writes, in the same way, that the job has failed too often."""


Tasks = Mapping[str, Task[Any, Any]]


class Queue(Protocol):
    """Jobs with a lease. Every method takes the session of the caller's transaction."""

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
        """Has a job done later, in its sender's turn. One job at a time has this kind and key. Raises HeapError."""

    def claim(
        self,
        db: Session,
        owner: LeaseOwner,
        kinds: Collection[str],
        lease_seconds: float,
        capabilities: WorkerCapabilities | None = None,
    ) -> Lease | None:
        """Begins the next job of these kinds; None where none waits that this worker is able to do."""

    def mark_refused(self, db: Session, kinds: Collection[str], capabilities: WorkerCapabilities) -> bool:
        """Notes that what waits of these kinds is for workers of other versions; False where there is none such."""

    def heartbeat(self, db: Session, lease: Lease, lease_seconds: float) -> bool:
        """Extends a lease; False when it has been lost."""

    def finish(self, db: Session, lease: Lease) -> bool:
        """Ends a job, once: False when the lease has been lost, and nothing may be recorded then."""

    def fail(self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUpHandler], *, last: bool = False) -> None:
        """Has a job tried again, or given up: once it has been tried too often, or with the `last` of its tries."""

    def requeue_untried(self, db: Session, lease: Lease) -> None:
        """Puts a job that its worker was told to leave back in its place, as if it had not been tried."""

    def recover_lost(self, db: Session, here: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        """Takes back every lease that has run out or whose holder is dead; returns how many."""

    def recover_from(self, db: Session, owner: LeaseOwner, give_ups: Mapping[str, GiveUpHandler]) -> int:
        """Takes back the leases of a worker that has just died; returns how many."""

    def position(self, db: Session, kind: str, key: str) -> int | None:
        """1 for the next job to begin, 0 for one that has begun, None where there is no such job."""

    def status(self, db: Session, kind: str, key: str) -> JobStatus | None:
        """None where there is no such job."""

    def find_stalled(self, db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
        """A job of these kinds that waits while none is being done: `before` if it still does, else the next to begin.

        None where one is being done, or none waits.
        """


class QueueNotifier(Protocol):
    """What a transaction tells the other processes, once it is committed."""

    def job_queued(self, db: Session, call: JobNotification, /) -> None:
        """A job waits: an idle worker may wake up."""

    def job_changed(self, db: Session, news: str) -> None:
        """The job of this key has ended or gone back, or, with `BEGUN` after it, begun: whoever shows it may look."""


class WorkSource(Protocol):
    """What a worker sleeps on."""

    @property
    def buffers_wakeups(self) -> bool:
        """Whether it keeps what it has to tell a worker that is busy, so that `wait` returns at once."""

    def wait(self, seconds: float) -> bool:
        """Returns when there may be work, or after `seconds`; False means that the worker must stop."""


class WorkMessage(Protocol):
    """Leave to do one job. It is kept while the job is done, and ends in one of two ways."""

    @property
    def kinds(self) -> Collection[str]:
        """Of which kinds."""

    @property
    def redelivered(self) -> bool:
        """Whoever held it before has given no sign of life: what they were doing may wait for being taken back."""

    def in_progress(self) -> None:
        """It is in use still. From any thread."""

    def ack(self, *, job_done: bool) -> None:
        """It was used, or there was no job for it."""

    def nak(self, *, delayed: bool) -> None:
        """Somebody else is to have it: at once, or in a while."""


class WorkSubscription(Protocol):
    """What a worker of the distributed engine sleeps on: `wait`, which may be interrupted, then `take`."""

    def wait(self, seconds: float) -> None:
        """Returns when there is a ticket, or after `seconds`."""

    def take_message(self) -> WorkMessage | None:
        """The ticket that has come, if any."""


class NullNotifier:
    """Nobody listens: everyone polls."""

    def job_queued(self, db: Session, call: JobNotification, /) -> None:
        return

    def job_changed(self, db: Session, news: str) -> None:
        return
