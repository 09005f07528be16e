"""The web process's end of the wake-up channel: wakes idle workers, and forwards job changes to a callback.

`wake_worker` and `publish_change` may be called from any thread; worker messages arrive on the event loop.

Protocol, one line a message. Web to worker: `work`. Worker to web: `idle` (it found nothing and sleeps), `awake` (it
looks without having been woken), `queued` (it returned a job), `changed <key>[ begun]`, `renewed <reason>` (a template
of its sandbox was replaced).
"""

import asyncio
import logging
import threading
from collections.abc import Callable
from typing import Protocol

from sqlalchemy.orm import Session

from server.base.counters import TEMPLATE_RENEWALS
from server.database import run_after_commit
from server.queue.interfaces import JobNotification

log = logging.getLogger(__name__)

WORK, IDLE, AWAKE, QUEUED, CHANGED, RENEWED = "work", "idle", "awake", "queued", "changed", "renewed"


class WorkerConnection(Protocol):
    """Sends bytes to a worker; from any thread, without blocking."""

    def write(self, data: bytes) -> None: ...


class WakeupDispatcher:
    """Tracks idle workers. A wake-up that finds none idle is kept for the next worker that goes to sleep.

    At most one is kept for each worker: each worker that goes to sleep while jobs wait is woken, and the surplus is
    bounded. The thread that has enqueued a job wakes a worker itself, without passing through the event loop.
    """

    def __init__(self, on_changed: Callable[[str], None]) -> None:
        self._on_changed = on_changed
        self._lock = threading.Lock()
        self._idle: dict[WorkerConnection, None] = {}
        self._workers: set[WorkerConnection] = set()
        self._kept_wakeups = 0
        self._loop: asyncio.AbstractEventLoop | None = None

    def bind(self, loop: asyncio.AbstractEventLoop | None) -> None:
        """Deliver changes on this event loop, or stop with None."""
        self._loop = loop

    def job_queued(self, db: Session, _notification: JobNotification) -> None:
        run_after_commit(db, self.wake_worker)

    def job_changed(self, db: Session, notification: str) -> None:
        run_after_commit(db, lambda: self.publish_change(notification))

    def wake_worker(self) -> None:
        with self._lock:
            self._wake_idle_worker()

    def publish_change(self, notification: str) -> None:
        self._call_on_loop(self._on_changed, notification)

    def _call_on_loop(self, action: Callable[..., None], *args: object) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(action, *args)

    def _wake_idle_worker(self) -> None:
        if self._idle:
            worker, _ = self._idle.popitem()
            worker.write(f"{WORK}\n".encode())
        else:
            self._kept_wakeups = min(self._kept_wakeups + 1, max(1, len(self._workers)))

    def handle_message(self, worker: WorkerConnection, message: str) -> None:
        """Handle a message from a worker, on the event loop."""
        word, _, argument = message.partition(" ")
        if word == IDLE:
            with self._lock:
                self._workers.add(worker)
                self._idle[worker] = None
                self._deliver_kept_wakeup()
        elif word == AWAKE:
            with self._lock:
                self._mark_busy(worker)
        elif word == QUEUED:
            self.wake_worker()
        elif word == CHANGED:
            self._on_changed(argument)
        elif word == RENEWED:
            TEMPLATE_RENEWALS.add(argument)
        else:
            log.error("a worker said something unknown: %r", message)

    def _mark_busy(self, worker: WorkerConnection) -> None:
        """The worker may find a job and can no longer be woken.

        A wake-up that crossed its `awake` is read only after that job: another worker gets one too.
        """
        if worker in self._idle:
            del self._idle[worker]
        else:
            self._wake_idle_worker()

    def _deliver_kept_wakeup(self) -> None:
        if self._kept_wakeups:
            self._kept_wakeups -= 1
            self._wake_idle_worker()

    def remove_worker(self, worker: WorkerConnection) -> None:
        with self._lock:
            self._workers.discard(worker)
            self._idle.pop(worker, None)
