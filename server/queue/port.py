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

from server.queue.owner import Owner

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
    needs: str | None = None
    followed: bool = True


@dataclass(frozen=True)
class Call:
    """That one more job of a kind may be begun. `name` is this call's own: of the job, and of its attempt before."""

    kind: str
    name: str


@dataclass(frozen=True)
class Able:
    """What a worker can do: jobs that need nothing, or one of `having`; any other that waits since a refusal.

    `patience`, in seconds: that long after it was first refused, a job is anybody's.
    """

    having: Collection[str]
    patience: float


@dataclass(frozen=True)
class Whereabouts:
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
    line: str = ""
    rank: int = 0


@dataclass(frozen=True)
class Most:
    """How many jobs may wait: of one sender, and from one address in one rank."""

    each: int
    from_address: int


class HeapError(Exception):
    """So much waits already that no more is taken; `whose` heap it is."""

    def __init__(self, whose: Literal["sender", "address"]) -> None:
        super().__init__(f"the heap of this {whose} is as high as it may be")
        self.whose = whose


NOBODY = Sender()
#: What news add to a job's key where it has begun, and no more: who waits for its end alone need not look yet.
BEGUN = " begun"
#: Where a job's payload keeps the request that it comes from, for the logs.
REQUEST = "request"
GiveUp = Callable[[Session, Lease], None]


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

    def put(
        self,
        db: Session,
        kind: str,
        key: str,
        payload: Mapping[str, Any] | None = None,
        sender: Sender = NOBODY,
        most: Most | None = None,
        needs: str | None = None,
    ) -> None:
        """Has a job done later, in its sender's turn. One job at a time has this kind and key. Raises HeapError."""

    def claim(
        self, db: Session, owner: Owner, kinds: Collection[str], lease_seconds: float, able: Able | None = None
    ) -> Lease | None:
        """Begins the next job of these kinds; None where none waits that this worker is able to do."""

    def refuse(self, db: Session, kinds: Collection[str], able: Able) -> bool:
        """Notes that what waits of these kinds is for workers of other versions; False where there is none such."""

    def heartbeat(self, db: Session, lease: Lease, lease_seconds: float) -> bool:
        """Extends a lease; False when it has been lost."""

    def finish(self, db: Session, lease: Lease) -> bool:
        """Ends a job, once: False when the lease has been lost, and nothing may be recorded then."""

    def fail(self, db: Session, lease: Lease, give_ups: Mapping[str, GiveUp], *, last: bool = False) -> None:
        """Has a job tried again, or given up: once it has been tried too often, or with the `last` of its tries."""

    def give_back(self, db: Session, lease: Lease) -> None:
        """Puts a job that its worker was told to leave back in its place, as if it had not been tried."""

    def recover(self, db: Session, here: Owner, give_ups: Mapping[str, GiveUp]) -> int:
        """Takes back every lease that has run out or whose holder is dead; returns how many."""

    def release(self, db: Session, owner: Owner, give_ups: Mapping[str, GiveUp]) -> int:
        """Takes back the leases of a worker that has just died; returns how many."""

    def position(self, db: Session, kind: str, key: str) -> int | None:
        """1 for the next job to begin, 0 for one that has begun, None where there is no such job."""

    def whereabouts(self, db: Session, kind: str, key: str) -> Whereabouts | None:
        """None where there is no such job."""

    def untaken(self, db: Session, kinds: Collection[str], before: UUID | None) -> UUID | None:
        """A job of these kinds that waits while none is being done: `before` if it still does, else the next to begin.

        None where one is being done, or none waits.
        """


class Signals(Protocol):
    """What a transaction tells the other processes, once it is committed."""

    def queued(self, db: Session, call: Call, /) -> None:
        """A job waits: an idle worker may wake up."""

    def changed(self, db: Session, news: str) -> None:
        """The job of this key has ended or gone back, or, with `BEGUN` after it, begun: whoever shows it may look."""


class WorkSource(Protocol):
    """What a worker sleeps on."""

    @property
    def owes(self) -> bool:
        """Whether it keeps what it has to tell a worker that is busy, so that `wait` returns at once."""

    def wait(self, seconds: float) -> bool:
        """Returns when there may be work, or after `seconds`; False means that the worker must stop."""


class Ticket(Protocol):
    """Leave to do one job. It is kept while the job is done, and ends in one of two ways."""

    @property
    def kinds(self) -> Collection[str]:
        """Of which kinds."""

    @property
    def again(self) -> bool:
        """Whoever held it before has given no sign of life: what they were doing may wait for being taken back."""

    def keep(self) -> None:
        """It is in use still. From any thread."""

    def spend(self, *, used: bool) -> None:
        """It was used, or there was no job for it."""

    def give_back(self, *, later: bool) -> None:
        """Somebody else is to have it: at once, or in a while."""


class Tickets(Protocol):
    """What a worker of the distributed engine sleeps on: `wait`, which may be interrupted, then `take`."""

    def wait(self, seconds: float) -> None:
        """Returns when there is a ticket, or after `seconds`."""

    def take(self) -> Ticket | None:
        """The ticket that has come, if any."""


class NoSignals:
    """Nobody listens: everyone polls."""

    def queued(self, db: Session, call: Call, /) -> None:
        return

    def changed(self, db: Session, news: str) -> None:
        return
