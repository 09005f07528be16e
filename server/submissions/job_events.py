"""Who waits for which job, and how they learn that it has changed.

Everything here runs on the web process's event loop, and holds neither a thread nor a database session while waiting.
"""

import asyncio
import logging
import re
import time
from collections import defaultdict
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from sqlalchemy.exc import DBAPIError
from starlette.concurrency import run_in_threadpool

from server.base import traces
from server.database import is_unavailable
from server.queue.interfaces import JOB_STARTED_SUFFIX

log = logging.getLogger(__name__)

#: No proxy is to keep an event back to make a larger piece of it.
STREAM_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
LINE_END = re.compile("\r\n|\r|\n")
QUEUE_MOVES_EVERY = 0.3  # seconds: places in the queue are refreshed no more often than this
SAFETY_POLL = 2.0  # seconds: longest time without looking, should a signal be lost
AT_A_TIME = 15  # watchers whose place is refreshed then; of more, the next ones follow
LOOKS_A_SECOND = 50  # of all watchers together, where no signal comes: many look more rarely each
REMEMBERED = 4096  # jobs that have changed last: one may end before whoever has sent it begins to wait


class Snapshot(Protocol):
    """What a watcher reads: it ends when `done`, and is told again when it differs."""

    @property
    def done(self) -> bool: ...


S = TypeVar("S", bound=Snapshot)


Watchers = dict[str, set[asyncio.Event]]


class JobEvents:
    """Wakes the watchers of a job, by its key: those who show where it is, and those who wait for its end alone."""

    def __init__(self) -> None:
        self._watchers: Watchers = defaultdict(set)
        self._awaiting: Watchers = defaultdict(set)
        self._latest: dict[str, None] = {}
        self._onlookers: set[asyncio.Event] = set()
        self._behind: list[asyncio.Event] = []
        self._moving = self._moved_again = False
        self._closed = False

    def close(self) -> None:
        """Ends every watch, as the server stops: browsers come back by themselves."""
        self._closed = True
        for event in (*self._every(), *(event for events in self._awaiting.values() for event in events)):
            event.set()

    def count_watchers(self) -> int:
        """How many pages and programs follow something at this moment."""
        return sum(len(events) for kept in (self._watchers, self._awaiting) for events in list(kept.values()))

    def job_changed(self, notification: str) -> None:
        """A job has changed state (`queue.port.Signals`): its watchers look at once, the others soon, as their place
        has moved. Who waits for its end alone does not look because it has begun, nor because of others."""
        key = notification.removesuffix(JOB_STARTED_SUFFIX)
        if key == notification:
            self._note(key)
        for event in self._watchers.get(key, ()):
            event.set()
        self._moved_again = True
        if not self._moving and self._watchers:
            self._moving = True
            self._move_later()

    def _note(self, key: str) -> None:
        self._latest.pop(key, None)
        self._latest[key] = None
        if len(self._latest) > REMEMBERED:
            del self._latest[next(iter(self._latest))]
        for event in self._awaiting.get(key, ()):
            event.set()

    def _move_later(self) -> None:
        asyncio.get_running_loop().call_later(QUEUE_MOVES_EVERY, self._move)

    def _move(self) -> None:
        """Each look is a few questions to the database: hundreds who wait do not ask them all at the same moment, so
        that whoever reads a page meanwhile gets it."""
        if not self._behind and self._moved_again:
            self._moved_again = False
            self._behind = self._every()
        for event in (*self._onlookers, *self._behind[:AT_A_TIME]):
            event.set()
        del self._behind[:AT_A_TIME]
        if self._behind or self._moved_again:
            self._move_later()
        else:
            self._moving = False

    def _every(self) -> list[asyncio.Event]:
        return [event for events in self._watchers.values() for event in events]

    @contextmanager
    def _watch(self, key: str, *, onlooking: bool) -> Iterator[asyncio.Event]:
        with _among(self._watchers, key) as event:
            if onlooking:
                self._onlookers.add(event)
            try:
                yield event
            finally:
                self._onlookers.discard(event)

    async def follow(self, key: str, read: Callable[[], S], *, watches_all_jobs: bool = False) -> AsyncIterator[S]:
        """Yields what `read` gives (called in a thread) at first, then each time that it differs, until it is done
        (or the server stops). `onlooking`: it is of many jobs, and any of them may change it. A database that does not
        answer is asked again."""
        with self._watch(key, onlooking=watches_all_jobs) as event:
            latest: S | None = None
            while True:
                woken = time.time_ns()
                event.clear()  # before reading: a change during the read is not missed
                snapshot = await _looked(key, read)
                if snapshot is not None and snapshot != latest:
                    yield snapshot
                    latest = snapshot
                if snapshot is not None and snapshot.done:
                    traces.record_notification(key, woken)
                    return
                if self._closed:
                    return
                await _wait(event, self._patience())

    async def wait_until_done(self, key: str, read: Callable[[], S], seconds: float) -> S:
        """The snapshot once it is done, or as it is after `seconds`.

        The job has been put a moment ago: as long as it has not changed since, there is nothing to look at.
        """
        ends = time.monotonic() + seconds
        with _among(self._awaiting, key) as event:
            if key in self._latest:
                event.set()
            while not self._closed:
                await _wait(event, min(ends - time.monotonic(), self._patience()))
                if time.monotonic() >= ends:
                    break
                woken = time.time_ns()
                event.clear()
                snapshot = await _looked(key, read)
                if snapshot is not None and snapshot.done:
                    traces.record_notification(key, woken)
                    return snapshot
        return await run_in_threadpool(read)

    def _patience(self) -> float:
        return max(SAFETY_POLL, self.count_watchers() / LOOKS_A_SECOND)


@contextmanager
def _among(watchers: Watchers, key: str) -> Iterator[asyncio.Event]:
    """An event among those of a key, and no longer than it is watched."""
    event = asyncio.Event()
    watchers[key].add(event)
    try:
        yield event
    finally:
        watchers[key].discard(event)
        if not watchers[key]:
            del watchers[key]


async def _looked(key: str, read: Callable[[], S]) -> S | None:
    """None where the database does not answer: those who follow have been answered already."""
    try:
        return await run_in_threadpool(read)
    except DBAPIError as error:
        if not is_unavailable(error):
            raise
        log.warning("the database does not answer whoever follows %s", key)
        return None


async def _wait(event: asyncio.Event, seconds: float) -> None:
    """Until it is set; it is after so long. (A timeout would cancel, which costs more than waking.)"""
    over = asyncio.get_running_loop().call_later(seconds, event.set)
    try:
        await event.wait()
    finally:
        over.cancel()


async def stream_sse(
    snapshots: AsyncIterator[S], encode: Callable[[S], str], *, name: str = "status"
) -> AsyncIterator[str]:
    """Snapshots as server-sent events; `encode` gives text of any number of lines."""
    async for snapshot in snapshots:
        yield format_sse(name, encode(snapshot))


def format_sse(name: str, text: str) -> str:
    """One server-sent event; `text` may have any number of lines."""
    # A client takes a line up to CR or LF, and no other character that `splitlines` knows of.
    lines = "".join(f"data: {line}\n" for line in LINE_END.split(text))
    return f"event: {name}\n{lines}\n"
