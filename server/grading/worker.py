"""A grading worker: claim, grade, record, again; sleep when nothing waits."""

import logging
import os
import threading
import time
from collections.abc import Callable
from typing import Any

from sqlalchemy.exc import SQLAlchemyError

from server.base.settings import Settings
from server.database import Database
from server.queue import service as queue
from server.queue.owner import Owner, owner_of
from server.queue.port import WorkSource
from server.queue.service import Lease

log = logging.getLogger(__name__)

STUCK_EXIT = 70
Grade = Callable[[Lease], dict[str, Any]]


class Stop(BaseException):
    """Raised in a worker that is asked to end (SIGTERM); what it was grading goes back to the queue."""


class Heartbeat:
    """Extends the lease of what is being graded, from a thread of its own.

    A grading longer than `grading_seconds` is a fault of ours that nothing else would end: the process ends itself, and
    the submission is taken back like any dead worker's.
    """

    def __init__(self, database: Database, settings: Settings) -> None:
        self._database, self._settings = database, settings
        self._current: tuple[Lease, float] | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="heartbeat", daemon=True)

    def __enter__(self) -> "Heartbeat":
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._stopping.set()
        self._thread.join()

    def hold(self, lease: Lease | None) -> None:
        self._current = None if lease is None else (lease, time.monotonic() + self._settings.grading_seconds)

    def _run(self) -> None:
        while not self._stopping.wait(self._settings.lease_seconds / 3):
            current = self._current
            if current is not None:
                self._beat(*current)

    def _beat(self, lease: Lease, deadline: float) -> None:
        if time.monotonic() > deadline:
            log.critical("submission %s: grading does not end, this worker gives up", lease.submission_id)
            os._exit(STUCK_EXIT)
        try:
            with self._database.write() as db:
                queue.heartbeat(db, lease, self._settings.lease_seconds)
        except SQLAlchemyError:
            log.exception("submission %s: heartbeat failed, trying again later", lease.submission_id)


class Worker:
    """One submission at a time. `grade` turns a lease into the columns to record (see `server.grading.results`)."""

    def __init__(self, database: Database, settings: Settings, grade: Grade, owner: Owner | None = None) -> None:
        self._database, self._settings, self._grade = database, settings, grade
        self._owner = owner or owner_of(os.getpid())
        self._heartbeat = Heartbeat(database, settings)

    def step(self) -> bool:
        """Grades one submission; False when none waits."""
        with self._database.write() as db:
            lease = queue.claim(db, self._owner, self._settings.lease_seconds)
        if lease is None:
            return False
        self._heartbeat.hold(lease)
        try:
            self._record(lease, self._grade(lease))
        except Stop:
            with self._database.write() as db:
                queue.give_back(db, lease)
            raise
        finally:
            self._heartbeat.hold(None)
        return True

    def _record(self, lease: Lease, result: dict[str, Any]) -> None:
        with self._database.write() as db:
            recorded = queue.finish(db, lease, result)
        if not recorded:
            log.warning("submission %s: the lease was lost, this result is dropped", lease.submission_id)

    def run(self, work: WorkSource) -> None:
        """Until `work` says that it is over, or Stop is raised."""
        with self._heartbeat:
            going = True
            while going:
                while self.step():
                    pass
                going = work.wait(self._settings.poll_seconds)
