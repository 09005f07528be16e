"""A worker's second seat: jobs that would have to wait for a long one run there, while the programs of that one stop.

A job is let in once it has waited for a while, if its rank is higher than that of the worker's own job, or, after a
longer wait, if its flow is another. So no flow holds a worker for long, and nobody waits for those of a lower rank;
with one worker, too. There is one such seat: a job of a lower rank that holds it is given back untried to one of a
higher rank. So is a job whose programs have been stopped for long: another worker may have time for it. A job of the
background goes on for a moment after BACKGROUND_TURN others: it would never end behind a queue that is never empty.
"""

import itertools
import logging
import threading
import time
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from types import TracebackType

from server.queue.interfaces import Lease, PrecedingJobs, WaitingJob
from server.queue.job_runner import JobRunner

log = logging.getLogger(__name__)

CLOSING_SECONDS = 2.0
#: So many jobs of higher ranks go before one of the background, in a row.
BACKGROUND_TURN = 10


@dataclass(frozen=True)
class ReliefDelays:
    """Seconds: between two looks; that a job of a higher rank, then of another flow, has waited; of being stopped."""

    look: float = 0.2
    rank: float = 0.4
    flow: float = 1.0
    stopped: float = 30.0


DEFAULT_PATIENCE = ReliefDelays()


class ReliefRunner:
    """Used as a context manager, watches the worker's own runner from a thread, and runs jobs by another runner."""

    def __init__(
        self,
        main: JobRunner,
        relief: JobRunner,
        kinds: Collection[str],
        background: Collection[str] = (),
        patience: ReliefDelays = DEFAULT_PATIENCE,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._main, self._relief, self._kinds, self._background = main, relief, kinds, background
        self._patience, self._clock = patience, clock
        self._closing = threading.Event()
        self._watcher = threading.Thread(target=self._watch_own_job, name="relief-watch", daemon=True)
        self._thread: threading.Thread | None = None
        self._watched: Lease | None = None
        self._waiting: WaitingJob | None = None
        self._waiting_since = 0.0

    def __enter__(self) -> "ReliefRunner":
        self._watcher.start()
        return self

    def __exit__(
        self, _type: type[BaseException] | None, _error: BaseException | None, _traceback: TracebackType | None
    ) -> None:
        """Give the job of this seat back untried, and wait for that a little."""
        self._closing.set()
        self._watcher.join(CLOSING_SECONDS)
        if self._is_relief_running():
            self._abandon_relief_job()
            if self._thread is not None:
                self._thread.join(CLOSING_SECONDS)

    def _watch_own_job(self) -> None:
        while not self._closing.wait(self._patience.look):
            try:
                self._run_preceding_job_if_late()
            except Exception:  # a database that does not answer: the next look may find it
                log.exception("whether others should go before a job is not known")

    def _run_preceding_job_if_late(self) -> None:
        """Let in the job that has waited too long for the worker's own, if there is one."""
        running = self._main.running
        if running is None or running is not self._watched:
            self._watched, self._waiting = running, None
            return
        taken = self._is_relief_running()
        if self._main.programs.stopped_seconds(running.token) > self._patience.stopped:
            self._main.programs.abandon(running.token)
            return
        preceding = self._preceding_jobs(running) if not taken else self._preceding_relief_job()
        waiting = self._relief.peek_next_job(self._kinds, preceding) if preceding else None
        if waiting is None or self._waiting is None or waiting.job_id != self._waiting.job_id:
            self._waiting, self._waiting_since = waiting, self._clock()
            return
        patience = self._patience.rank if waiting.rank < running.rank else self._patience.flow
        if self._clock() - self._waiting_since < patience:
            return
        if taken:
            self._abandon_relief_job()
        else:
            self._thread = threading.Thread(target=self._run_jobs, args=(running,), name="relief", daemon=True)
            self._thread.start()

    def _preceding_jobs(self, running: Lease) -> PrecedingJobs:
        return PrecedingJobs(running.rank, running.rank, running.flow)

    def _preceding_relief_job(self) -> PrecedingJobs | None:
        relieving = self._relief.running
        return None if relieving is None else PrecedingJobs(relieving.rank)

    def _is_relief_running(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def _abandon_relief_job(self) -> None:
        if (relieving := self._relief.running) is not None:
            self._relief.programs.abandon(relieving.token)

    def _run_jobs(self, running: Lease) -> None:
        """Run the next job that goes before, then those of a higher rank; the programs of the worker's own job stop."""

        def stop_own() -> None:
            self._main.programs.stop(running.token)

        preceding = self._preceding_jobs(running)
        turns: Iterable[int] = range(BACKGROUND_TURN) if running.kind in self._background else itertools.count()
        try:
            with self._relief.heartbeat:
                for _ in turns:
                    if self._closing.is_set() or not self._relief.claim_and_run(self._kinds, stop_own, preceding):
                        return
                    if self._main.running is not running:
                        return
                    preceding = PrecedingJobs(running.rank)
        except Exception:
            log.exception("a job that goes before %s %s could not be run", running.kind, running.key)
        finally:
            self._main.programs.go_on(running.token)
