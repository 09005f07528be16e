"""A worker: claim, run, record, again; sleep when nothing waits.

What tells it that there is work is a source that wakes it (`run`), or tickets, each leave to do one job (`run_on`).
"""

import logging
import os
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, TypeVar

from sqlalchemy.exc import DBAPIError, OperationalError, SQLAlchemyError
from sqlalchemy.orm import Session

from server.base import logs, traces
from server.base.settings import Settings
from server.database import Database, is_lock_timeout, is_unavailable, utc_now
from server.queue.graceful_stop import GracefulStop, StopRequested
from server.queue.interfaces import (
    REQUEST_ID_KEY,
    GiveUpHandler,
    Lease,
    Queue,
    Tasks,
    WorkerCapabilities,
    WorkMessage,
    WorkSource,
    WorkSubscription,
)
from server.queue.lease_owner import LeaseOwner, process_owner

log = logging.getLogger(__name__)

STUCK_EXIT = 70
DATABASE_PAUSE = 1.0  # seconds
#: Seconds between two tries at a database that another writer holds: doubled each time, up to the longest.
LOCKED_PAUSE, LONGEST_PAUSE = 0.5, 10.0

T = TypeVar("T")


def _pauses() -> Iterator[float]:
    """How long to leave a locked database alone, the first time and each time after."""
    pause = LOCKED_PAUSE
    while True:
        yield pause
        pause = min(2.0 * pause, LONGEST_PAUSE)


class LeaseHeartbeat:
    """Extends the lease of what is being done, from a thread of its own.

    Work longer than `grading_seconds` is a fault of ours that nothing else would end: the job is given up, for it would
    take as long again, and the process ends itself.
    """

    def __init__(
        self, database: Database, queue: Queue, settings: Settings, give_ups: Mapping[str, GiveUpHandler]
    ) -> None:
        self._database, self._queue, self._settings, self._give_ups = database, queue, settings, give_ups
        self._current: tuple[Lease, float, Callable[[], None]] | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="heartbeat", daemon=True)

    def __enter__(self) -> "LeaseHeartbeat":
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._stopping.set()
        self._thread.join()

    def watch(self, lease: Lease, keep_alive: Callable[[], None]) -> None:
        """`keep` is called too, each time that the lease is extended."""
        self._current = (lease, time.monotonic() + self._settings.grading_seconds, keep_alive)

    def unwatch(self) -> None:
        self._current = None

    def _run(self) -> None:
        while not self._stopping.wait(self._settings.lease_seconds / 3):
            current = self._current
            if current is not None:
                self._beat(*current)

    def _beat(self, lease: Lease, deadline: float, keep: Callable[[], None] = lambda: None) -> None:
        if time.monotonic() > deadline:
            log.critical("job %s %s does not end, this worker gives up", lease.kind, lease.key)
            try:
                with self._database.write() as db:
                    self._queue.fail(db, lease, self._give_ups, last=True)
            except Exception:
                log.exception("job %s %s: will be tried again", lease.kind, lease.key)
            finally:
                os._exit(STUCK_EXIT)
        try:
            with self._database.write() as db:
                held = self._queue.heartbeat(db, lease, self._settings.lease_seconds)
            if held:
                keep()
        except SQLAlchemyError:
            log.exception("job %s %s: heartbeat failed, trying again later", lease.kind, lease.key)


class Worker:
    """One job at a time, of the kinds that `tasks` knows; with `able`, only of those that it has what it takes for."""

    def __init__(
        self,
        database: Database,
        queue: Queue,
        settings: Settings,
        tasks: Tasks,
        owner: LeaseOwner | None = None,
        *,
        capabilities: WorkerCapabilities | None = None,
        graceful_stop: GracefulStop | None = None,
    ) -> None:
        self._database, self._queue, self._settings, self._tasks = database, queue, settings, tasks
        self._able, self._stopping = capabilities, graceful_stop or GracefulStop()
        self._give_ups = {kind: task.give_up for kind, task in tasks.items()}
        self._owner = owner or process_owner(os.getpid())
        self._heartbeat = LeaseHeartbeat(database, queue, settings, self._give_ups)

    def run_one(self) -> bool:
        """Does one job; False when none waits."""
        return self._step(self._tasks.keys(), lambda: None) is not None

    def _step(self, kinds: Collection[str], keep: Callable[[], None]) -> Lease | None:
        """The job that was done. `keep` is called as it begins, and again as long as it is being done."""
        since = time.time_ns()
        begun = self._write(lambda db: self._begin(db, kinds))
        if begun is None:
            return None
        keep()
        lease, work = begun
        if work is not None:
            told = logs.request_context(str(lease.payload.get(REQUEST_ID_KEY, "")))
            with told, traces.job_span(lease.payload, lease.kind, lease.tries, since):
                self._do(lease, work, keep)
        return lease

    def _begin(self, db: Session, kinds: Collection[str]) -> tuple[Lease, Any] | None:
        lease = self._queue.claim(db, self._owner, kinds, self._settings.lease_seconds, self._able)
        if lease is None:
            return None
        work = self._read(db, lease)
        if work is None:
            self._queue.finish(db, lease)
        return lease, work

    def _read(self, db: Session, lease: Lease) -> Any:
        """A job that cannot be read is a failed try: else its claim would be undone, and made again for ever.

        But for a database that does not answer: what it says of the transaction holds for every job.
        """
        try:
            return self._tasks[lease.kind].read(db, lease)
        except Exception as error:
            if isinstance(error, DBAPIError) and (is_unavailable(error) or isinstance(error, OperationalError)):
                raise
            log.exception("job %s %s cannot be read, try %d", lease.kind, lease.key, lease.tries)
            self._queue.fail(db, lease, self._give_ups)
            return None

    def _do(self, lease: Lease, work: Any, keep: Callable[[], None]) -> None:
        self._heartbeat.watch(lease, keep)
        try:
            with traces.span("run"), self._stopping.interruptible():
                result = self._tasks[lease.kind].run(work)
            with traces.span("record"):
                self._write(lambda db: self._record(db, lease, work, result), patiently=True)
            seconds = (utc_now() - lease.started_at).total_seconds()
            logs.log_event("job done", kind=lease.kind, key=lease.key, tries=lease.tries, seconds=round(seconds, 4))
        except StopRequested:
            with self._database.write() as db:
                self._queue.requeue_untried(db, lease)
            raise
        except Exception:
            log.exception("job %s %s has failed, try %d", lease.kind, lease.key, lease.tries)
            self._write(lambda db: self._queue.fail(db, lease, self._give_ups), patiently=True)
        finally:
            self._heartbeat.unwatch()

    def _record(self, db: Session, lease: Lease, work: Any, result: Any) -> None:
        if self._queue.finish(db, lease):
            self._tasks[lease.kind].record(db, work, result)
        else:
            log.warning("job %s %s: the lease was lost, this result is dropped", lease.kind, lease.key)

    def _write(self, step: Callable[[Session], T], *, patiently: bool = False) -> T:
        """`step` in a transaction; done again where another writer of SQLite has outlasted the driver's wait.

        With `patiently`, also until PostgreSQL answers: what ends a job may wait for it, and the fence tells whether it
        was done before the answer was lost.
        """
        for pause in _pauses():
            try:
                with self._database.write() as db:
                    return step(db)
            except DBAPIError as error:
                locked = isinstance(error, OperationalError) and is_lock_timeout(error)
                if not locked and not (patiently and is_unavailable(error)):
                    raise
                what, rest = ("is locked", pause) if locked else ("does not answer", DATABASE_PAUSE)
                log.warning("the database %s, trying again in %g s", what, rest)
            with self._stopping.interruptible():
                time.sleep(rest)
        raise AssertionError("pauses have no end")

    def run(self, work: WorkSource) -> None:
        """Until `work` says that it is over, or Stop is raised."""
        with self._heartbeat, self._stopping.deferred():
            going = True
            while going:
                self._work_off(work)
                with self._stopping.interruptible():
                    going = work.wait(self._settings.poll_seconds)

    def _work_off(self, work: WorkSource) -> None:
        """Until nothing waits. What came after a claim that nothing followed has been told to `work`, which owes it:
        the database need not be asked, as it would be after each job of somebody who sends alone."""
        while (lease := self._step(self._tasks.keys(), lambda: None)) is not None:
            self._stopping.raise_if_requested()
            if work.buffers_wakeups and not lease.more_waiting:
                return

    def run_on_messages(self, tickets: WorkSubscription) -> None:
        """Until Stop is raised. A database that does not answer is asked again later."""
        with self._heartbeat, self._stopping.deferred():
            while True:
                with self._stopping.interruptible():
                    tickets.wait(self._settings.poll_seconds)
                ticket = tickets.take_message()
                if ticket is not None:
                    self._use_or_wait(ticket)

    def _use_or_wait(self, ticket: WorkMessage) -> None:
        try:
            self._use(ticket)
        except DBAPIError as error:
            if not is_unavailable(error) and not isinstance(error, OperationalError):
                raise
            log.error("the database does not answer, trying again in %g s: %s", DATABASE_PAUSE, error.orig)
            with self._stopping.interruptible():
                time.sleep(DATABASE_PAUSE)

    def _use(self, ticket: WorkMessage) -> None:
        """A ticket is over with its job, whatever comes of it: a job that waits again has a new one."""
        over = False
        try:
            if ticket.redelivered:
                self._write(lambda db: self._queue.recover_lost(db, self._owner, self._give_ups))
            used = self._step(ticket.kinds, ticket.in_progress) is not None
            over = used or not self._refuses(ticket.kinds)
            if over:
                ticket.ack(job_done=used)
        finally:
            if not over:
                ticket.nak(delayed=not self._stopping.requested.is_set())

    def _refuses(self, kinds: Collection[str]) -> bool:
        """Whether what waits is for other workers."""
        able = self._able
        return able is not None and self._write(lambda db: self._queue.mark_refused(db, kinds, able))
