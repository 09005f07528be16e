"""The web process's end of the wake-up: idle workers are woken through their channel, watchers through a callback.

`wake` and `tell` may be called from any thread; workers are heard on the event loop.

Protocol, one line a message. Web to worker: `work`. Worker to web: `idle` (it found nothing and sleeps), `awake` (it
looks, though nobody woke it), `queued` (it gave something back), `changed <key>[ begun]`, `renewed <why>` (a template
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
    """What leads to a worker. From any thread, and without waiting."""

    def write(self, data: bytes) -> None: ...


class WakeupDispatcher:
    """Knows which workers sleep. A wake-up that finds nobody asleep is kept for the next one who goes to sleep.

    As many are kept as there are workers: each who goes to sleep while jobs wait is woken, and none for nothing more
    than once for each of them. The thread that has put a job wakes a worker itself: the loop, which may be busy with
    something else, is not in between.
    """

    def __init__(self, on_changed: Callable[[str], None]) -> None:
        self._on_changed = on_changed
        self._waking = threading.Lock()
        self._idle: dict[WorkerConnection, None] = {}
        self._known: set[WorkerConnection] = set()
        self._owed = 0
        self._loop: asyncio.AbstractEventLoop | None = None

    def bind(self, loop: asyncio.AbstractEventLoop | None) -> None:
        """Starts (or stops, with None) delivering on this loop."""
        self._loop = loop

    def job_queued(self, db: Session, _call: JobNotification) -> None:
        run_after_commit(db, self.wake_worker)

    def job_changed(self, db: Session, news: str) -> None:
        run_after_commit(db, lambda: self.publish_change(news))

    def wake_worker(self) -> None:
        with self._waking:
            self._wake()

    def publish_change(self, news: str) -> None:
        self._call(self._on_changed, news)

    def _call(self, action: Callable[..., None], *args: object) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(action, *args)

    def _wake(self) -> None:
        if self._idle:
            line, _ = self._idle.popitem()
            line.write(f"{WORK}\n".encode())
        else:
            self._owed = min(self._owed + 1, max(1, len(self._known)))

    def handle_message(self, line: WorkerConnection, message: str) -> None:
        """A worker has said something (on the loop)."""
        word, _, argument = message.partition(" ")
        if word == IDLE:
            with self._waking:
                self._known.add(line)
                self._idle[line] = None
                self._pay()
        elif word == AWAKE:
            with self._waking:
                self._rouse(line)
        elif word == QUEUED:
            self.wake_worker()
        elif word == CHANGED:
            self._on_changed(argument)
        elif word == RENEWED:
            TEMPLATE_RENEWALS.add(argument)
        else:
            log.error("a worker said something unknown: %r", message)

    def _rouse(self, line: WorkerConnection) -> None:
        """It may find a job, and is no longer one that can be woken. A wake-up that has crossed its word is read by it
        after that job only: it is for another too."""
        if line in self._idle:
            del self._idle[line]
        else:
            self._wake()

    def _pay(self) -> None:
        if self._owed:
            self._owed -= 1
            self._wake()

    def remove_worker(self, line: WorkerConnection) -> None:
        with self._waking:
            self._known.discard(line)
            self._idle.pop(line, None)
