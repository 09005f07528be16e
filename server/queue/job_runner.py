"""Runs one job after the other: claims it, extends its lease meanwhile, and records its result."""

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
from server.database import Database, is_lock_timeout, is_storage_full, is_unavailable, utc_now
from server.queue.graceful_stop import GracefulStop, StopRequested
from server.queue.interfaces import (
    REQUEST_ID_KEY,
    GiveUpHandler,
    Lease,
    PrecedingJobs,
    Queue,
    Tasks,
    WaitingJob,
    WorkerCapabilities,
)
from server.queue.lease_owner import LeaseOwner
from server.sandbox.seat import Abandoned, SeatPrograms

log = logging.getLogger(__name__)

STUCK_EXIT = 70
DATABASE_PAUSE = 1.0  # seconds
#: Backoff in seconds at a locked database: the first pause, doubled up to the longest.
LOCKED_PAUSE, LONGEST_PAUSE = 0.5, 10.0

Returned = TypeVar("Returned")


def _backoff() -> Iterator[float]:
    """Yield the pauses between tries at a locked database."""
    pause = LOCKED_PAUSE
    while True:
        yield pause
        pause = min(2.0 * pause, LONGEST_PAUSE)


class LeaseHeartbeat:
    """Extends the lease of the running job, from a thread of its own.

    Work longer than `grading_seconds` is our fault and would never end: the job is given up, since another try would
    take as long, and the process exits. The time for which its programs are stopped does not count.
    """

    def __init__(
        self,
        database: Database,
        queue: Queue,
        settings: Settings,
        give_ups: Mapping[str, GiveUpHandler],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._database, self._queue, self._settings, self._give_ups = database, queue, settings, give_ups
        self._clock = clock
        self._current: tuple[Lease, float, Callable[[], None]] | None = None
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> "LeaseHeartbeat":
        self._stop.clear()
        self._thread = threading.Thread(target=self._extend_periodically, name="heartbeat", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def watch(self, lease: Lease, keep_alive: Callable[[], None]) -> None:
        """Extend this lease until `unwatch`; call `keep_alive` after each extension."""
        self._current = (lease, self._clock() + self._settings.grading_seconds, keep_alive)

    def unwatch(self) -> None:
        self._current = None

    def _extend_periodically(self) -> None:
        while not self._stop.wait(self._settings.lease_seconds / 3):
            current = self._current
            if current is not None:
                self._extend_lease(*current)

    def _extend_lease(self, lease: Lease, deadline: float, keep_alive: Callable[[], None] = lambda: None) -> None:
        if self._clock() > deadline:
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
                lease_held = self._queue.heartbeat(db, lease, self._settings.lease_seconds)
            if lease_held:
                keep_alive()
        except SQLAlchemyError:
            log.exception("job %s %s: heartbeat failed, trying again later", lease.kind, lease.key)


class JobRunner:
    """Runs one job at a time, of the kinds in `tasks`; with `capabilities`, only jobs it has the version for.

    `programs` are those of the running job. Enter `heartbeat` while jobs run.
    """

    def __init__(
        self,
        database: Database,
        queue: Queue,
        settings: Settings,
        tasks: Tasks,
        owner: LeaseOwner,
        capabilities: WorkerCapabilities | None,
        graceful_stop: GracefulStop,
    ) -> None:
        self._database, self._queue, self._settings, self._tasks = database, queue, settings, tasks
        self._capabilities, self._stop, self._owner = capabilities, graceful_stop, owner
        self._give_ups = {kind: task.give_up for kind, task in tasks.items()}
        self.programs = SeatPrograms()
        self.running: Lease | None = None
        self.heartbeat = LeaseHeartbeat(database, queue, settings, self._give_ups, self.programs.clock_without_stops)

    def claim_and_run(
        self, kinds: Collection[str], keep_alive: Callable[[], None], among: PrecedingJobs | None = None
    ) -> Lease | None:
        """Return the job that was run. `keep_alive` is called as it starts, then with each heartbeat."""
        claim_started = time.time_ns()
        claimed = self.write(lambda db: self._claim(db, kinds, among))
        if claimed is None:
            return None
        keep_alive()
        lease, work = claimed
        if work is not None:
            log_context = logs.request_context(str(lease.payload.get(REQUEST_ID_KEY, "")))
            with log_context, traces.job_span(lease.payload, lease.kind, lease.tries, claim_started):
                self._run_and_record(lease, work, keep_alive)
        return lease

    def peek_next_job(self, kinds: Collection[str], among: PrecedingJobs) -> WaitingJob | None:
        """Return the waiting job that `claim_and_run` would run, without claiming it."""
        with self._database.read() as db:
            return self._queue.peek_next_job(db, kinds, among, self._capabilities)

    def _claim(self, db: Session, kinds: Collection[str], among: PrecedingJobs | None) -> tuple[Lease, Any] | None:
        lease = self._queue.claim(db, self._owner, kinds, self._settings.lease_seconds, self._capabilities, among)
        if lease is None:
            return None
        work = self._read(db, lease)
        if work is None:
            self._queue.finish(db, lease)
        return lease, work

    def _read(self, db: Session, lease: Lease) -> Any:
        """Load the job's input. A failure counts as a try: rolled back, the claim would be repeated for ever.

        An unavailable database is no such failure: it would fail every job.
        """
        try:
            return self._tasks[lease.kind].read(db, lease)
        except Exception as error:
            if isinstance(error, DBAPIError) and (is_unavailable(error) or isinstance(error, OperationalError)):
                raise
            log.exception("job %s %s cannot be read, try %d", lease.kind, lease.key, lease.tries)
            self._queue.fail(db, lease, self._give_ups)
            return None

    def _run_and_record(self, lease: Lease, work: Any, keep_alive: Callable[[], None]) -> None:
        self.heartbeat.watch(lease, keep_alive)
        try:
            with traces.span("run"):
                result = self._run(lease, work)
            with traces.span("record"):
                self.write(lambda db: self._record(db, lease, work, result), wait_for_database=True)
            seconds = (utc_now() - lease.started_at).total_seconds()
            logs.log_event("job done", kind=lease.kind, key=lease.key, tries=lease.tries, seconds=round(seconds, 4))
        except StopRequested:
            with self._database.write() as db:
                self._queue.requeue_untried(db, lease)
            raise
        except Abandoned:
            log.info("job %s %s: given back untried, others go first", lease.kind, lease.key)
            self.write(lambda db: self._queue.requeue_untried(db, lease), wait_for_database=True)
        except Exception:
            log.exception("job %s %s has failed, try %d", lease.kind, lease.key, lease.tries)
            self.write(lambda db: self._queue.fail(db, lease, self._give_ups), wait_for_database=True)
        finally:
            self.heartbeat.unwatch()

    def _run(self, lease: Lease, work: Any) -> Any:
        try:
            with self.programs.running(lease.token), self._stop.allow_interruption():
                self.running = lease
                return self._tasks[lease.kind].run(work)
        finally:
            self.running = None

    def _record(self, db: Session, lease: Lease, work: Any, result: Any) -> None:
        if self._queue.finish(db, lease):
            self._tasks[lease.kind].record(db, work, result)
        else:
            log.warning("job %s %s: the lease was lost, this result is dropped", lease.kind, lease.key)

    def write(self, action: Callable[[Session], Returned], *, wait_for_database: bool = False) -> Returned:
        """Run `action` in a transaction; retry where another writer of SQLite has outlasted the driver's timeout.

        With `wait_for_database`, also retry until the database answers and has room: the end of a job may wait for it,
        and the fence token tells whether it was committed before the answer was lost.
        """
        for pause in _backoff():
            try:
                with self._database.write() as db:
                    return action(db)
            except DBAPIError as error:
                locked = isinstance(error, OperationalError) and is_lock_timeout(error)
                full = is_storage_full(error)
                if not locked and not (wait_for_database and (full or is_unavailable(error))):
                    raise
                state = "is locked" if locked else "has no room" if full else "does not answer"
                pause_seconds = pause if locked else DATABASE_PAUSE
                log.warning("the database %s, trying again in %g s", state, pause_seconds)
            with self._stop.allow_interruption():
                time.sleep(pause_seconds)
        raise AssertionError("pauses have no end")
