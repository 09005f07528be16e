"""A worker: claim a job, run it, record the result, repeat; sleep when nothing waits.

It learns of work from a source that wakes it (`run`), or from messages that entitle it to one job (`run_on_messages`).
"""

import logging
import os
import time
from collections.abc import Callable, Collection

from sqlalchemy.exc import DBAPIError, OperationalError

from server.base.settings import Settings
from server.database import Database, is_unavailable
from server.queue.graceful_stop import GracefulStop
from server.queue.interfaces import (
    Lease,
    Queue,
    Tasks,
    WorkerCapabilities,
    WorkMessage,
    WorkSource,
    WorkSubscription,
)
from server.queue.job_runner import DATABASE_PAUSE, JobRunner
from server.queue.lease_owner import LeaseOwner, process_owner
from server.queue.relief import BACKGROUND_TURN, DEFAULT_PATIENCE, ReliefDelays, ReliefRunner

log = logging.getLogger(__name__)


class Worker:
    """Runs one job at a time, of the kinds in `tasks`; with `capabilities`, only jobs it has the version for.

    While that takes long, its relief seat runs those who go before: with a job stopped, one more runs. Jobs of the
    kinds `background` have the lowest ranks, and yet a share: one goes first after BACKGROUND_TURN others behind which
    more waited.
    """

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
        background: Collection[str] = (),
        patience: ReliefDelays = DEFAULT_PATIENCE,
    ) -> None:
        self._database, self._queue, self._settings, self._tasks = database, queue, settings, tasks
        self._capabilities, self._stop = capabilities, graceful_stop or GracefulStop()
        self._give_ups = {kind: task.give_up for kind, task in tasks.items()}
        self._owner = owner or process_owner(os.getpid())
        self._background, self._jobs_in_a_row = frozenset(background), 0

        def make_runner(stop: GracefulStop) -> JobRunner:
            return JobRunner(database, queue, settings, tasks, self._owner, capabilities, stop)

        self._runner = make_runner(self._stop)
        self._relief = ReliefRunner(self._runner, make_runner(GracefulStop()), tasks.keys(), self._background, patience)

    def run_one(self) -> bool:
        """Run one job; False when none waits."""
        return self._claim_and_run() is not None

    def _claim_and_run(self) -> Lease | None:
        return self._run_next(self._tasks.keys(), lambda: None)

    def _run_next(self, kinds: Collection[str], keep_alive: Callable[[], None]) -> Lease | None:
        """Run the next job of these kinds, after one of the background whose turn has come; return the former."""
        if self._background and self._jobs_in_a_row >= BACKGROUND_TURN:
            self._jobs_in_a_row = 0
            self._runner.claim_and_run(self._background, keep_alive)
        lease = self._runner.claim_and_run(kinds, keep_alive)
        others_wait = lease is not None and lease.more_waiting and lease.kind not in self._background
        self._jobs_in_a_row = self._jobs_in_a_row + 1 if others_wait else 0
        return lease

    def run(self, work: WorkSource) -> None:
        """Work until `work` ends or a stop is requested."""
        with self._runner.heartbeat, self._relief, self._stop.defer_stop():
            keep_going = True
            while keep_going:
                self._run_until_empty(work)
                with self._stop.allow_interruption():
                    keep_going = work.wait(self._settings.poll_seconds)

    def _run_until_empty(self, work: WorkSource) -> None:
        """Run jobs until none waits. After a claim with nothing behind it, a buffering source tells of later jobs.

        So the database is not asked again after each job of somebody who sends alone.
        """
        while (lease := self._claim_and_run()) is not None:
            self._stop.raise_if_requested()
            if work.buffers_wakeups and not lease.more_waiting:
                return

    def run_on_messages(self, subscription: WorkSubscription) -> None:
        """Work until a stop is requested. An unavailable database is asked again later."""
        with self._runner.heartbeat, self._relief, self._stop.defer_stop():
            while True:
                with self._stop.allow_interruption():
                    subscription.wait(self._settings.poll_seconds)
                message = subscription.take_message()
                if message is not None:
                    self._handle_message_or_pause(message)

    def _handle_message_or_pause(self, message: WorkMessage) -> None:
        try:
            self._handle_message(message)
        except DBAPIError as error:
            if not is_unavailable(error) and not isinstance(error, OperationalError):
                raise
            log.error("the database does not answer, trying again in %g s: %s", DATABASE_PAUSE, error.orig)
            with self._stop.allow_interruption():
                time.sleep(DATABASE_PAUSE)

    def _handle_message(self, message: WorkMessage) -> None:
        """Run a job for this message, which ends with it whatever its outcome: a requeued job has a new message."""
        acknowledged = False
        try:
            if message.redelivered:
                self._runner.write(lambda db: self._queue.recover_lost(db, self._owner, self._give_ups))
            job_done = self._run_next(message.kinds, message.in_progress) is not None
            acknowledged = job_done or not self._refuse_other_versions(message.kinds)
            if acknowledged:
                message.ack(job_done=job_done)
        finally:
            if not acknowledged:
                message.nak(delayed=not self._stop.requested.is_set())

    def _refuse_other_versions(self, kinds: Collection[str]) -> bool:
        """Refuse jobs for workers of other versions; return whether there are any."""
        capabilities = self._capabilities
        if capabilities is None:
            return False
        return self._runner.write(lambda db: self._queue.mark_refused(db, kinds, capabilities))
