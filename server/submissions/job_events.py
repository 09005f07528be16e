"""Watchers of jobs, and how they are woken when a job changes.

All of it runs on the web process's event loop; a waiting watcher holds neither a thread nor a database session.
"""

import asyncio
import logging
import math
import re
import time
from collections import defaultdict
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from sqlalchemy.exc import DBAPIError
from starlette.concurrency import run_in_threadpool

from server.base import traces
from server.base.turns import out_of_turn
from server.database import is_unavailable
from server.queue.interfaces import JOB_STARTED_SUFFIX

log = logging.getLogger(__name__)

#: Keeps proxies from buffering events.
STREAM_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
LINE_END = re.compile("\r\n|\r|\n")
REFRESH_SECONDS = 0.3  # minimum seconds between refreshes of queue positions
SAFETY_POLL = 2.0  # seconds after which watchers poll, should a notification be lost
REFRESH_BATCH = 15  # watchers refreshed at a time; the others follow in later batches
POLLS_PER_SECOND = 50  # bound on polls of all watchers together
MIN_SETTLING_SECONDS = 0.05  # between two looks at what is about to be done by itself
MAX_RECENT_JOBS = 4096  # recently changed jobs: one may end before its sender starts to wait


class JobSnapshot(Protocol):
    """A watcher's reading of a job; the watch ends when `done`, changes are sent."""

    @property
    def done(self) -> bool: ...


SnapshotType = TypeVar("SnapshotType", bound=JobSnapshot)


Watchers = dict[str, set[asyncio.Event]]


class JobEvents:
    """Wakes the watchers of a job, by its key: those that show its progress, and those that await its end."""

    def __init__(self) -> None:
        self._watchers: Watchers = defaultdict(set)
        self._end_watchers: Watchers = defaultdict(set)
        self._recently_changed: dict[str, None] = {}
        self._global_watchers: set[asyncio.Event] = set()
        self._refresh_queue: list[asyncio.Event] = []
        self._refreshing = self._changed_again = False
        self._closed = False

    def close(self) -> None:
        """End every watch as the server stops; browsers reconnect by themselves."""
        self._closed = True
        for event in (*self._all_watchers(), *(event for events in self._end_watchers.values() for event in events)):
            event.set()

    def count_watchers(self) -> int:
        """Count the pages and programs that watch something."""
        return sum(
            len(events) for watchers in (self._watchers, self._end_watchers) for events in list(watchers.values())
        )

    def job_changed(self, notification: str) -> None:
        """Wake the job's watchers at once, and the others soon, as their positions have changed.

        Watchers of the end of a job ignore that it was claimed (JOB_STARTED_SUFFIX), and other jobs. Those that watch
        all jobs ignore that one was claimed; they are few, and rest between two looks by themselves.
        """
        key = notification.removesuffix(JOB_STARTED_SUFFIX)
        if key == notification:
            self._record_recent_change(key)
            for event in self._global_watchers:
                event.set()
        for event in self._watchers.get(key, ()):
            event.set()
        self._changed_again = True
        if not self._refreshing and self._watchers:
            self._refreshing = True
            self._schedule_refresh()

    def _record_recent_change(self, key: str) -> None:
        self._recently_changed.pop(key, None)
        self._recently_changed[key] = None
        if len(self._recently_changed) > MAX_RECENT_JOBS:
            del self._recently_changed[next(iter(self._recently_changed))]
        for event in self._end_watchers.get(key, ()):
            event.set()

    def _schedule_refresh(self) -> None:
        asyncio.get_running_loop().call_later(REFRESH_SECONDS, self._wake_batch)

    def _wake_batch(self) -> None:
        """Wake a batch of watchers: a refresh costs queries, and hundreds at once would delay page requests."""
        if not self._refresh_queue and self._changed_again:
            self._changed_again = False
            self._refresh_queue = self._all_watchers()
        for event in self._refresh_queue[:REFRESH_BATCH]:
            event.set()
        del self._refresh_queue[:REFRESH_BATCH]
        if self._refresh_queue or self._changed_again:
            self._schedule_refresh()
        else:
            self._refreshing = False

    def _all_watchers(self) -> list[asyncio.Event]:
        return [event for events in self._watchers.values() for event in events]

    @contextmanager
    def _watch(self, key: str, *, also_watches_all_jobs: bool) -> Iterator[asyncio.Event]:
        with _registered_watcher(self._watchers, key) as event:
            if also_watches_all_jobs:
                self._global_watchers.add(event)
            try:
                yield event
            finally:
                self._global_watchers.discard(event)

    async def follow(
        self,
        key: str,
        read: Callable[[], SnapshotType],
        *,
        also_watches_all_jobs: bool = False,
        find_rest: Callable[[], float] = lambda: 0.0,
    ) -> AsyncIterator[SnapshotType]:
        """Yield what `read` returns (in a thread), then each different value, until it is done or the server stops.

        `also_watches_all_jobs`: the end of any job may change it. `find_rest`: the seconds to rest after a read. An
        unavailable database is asked again.
        """
        with self._watch(key, also_watches_all_jobs=also_watches_all_jobs) as event:
            latest: SnapshotType | None = None
            while True:
                woken = time.time_ns()
                event.clear()  # before reading: a change during the read is not missed
                snapshot = await _read_snapshot_or_none(key, read)
                if snapshot is not None and snapshot != latest:
                    yield snapshot
                    latest = snapshot
                if snapshot is not None and snapshot.done:
                    traces.record_notification(key, woken)
                    return
                if self._closed:
                    return
                await asyncio.sleep(find_rest())
                await _wait_or_set_event(event, min(self._poll_interval_seconds(), _seconds_until_settled(snapshot)))

    async def wait_until_done(self, key: str, read: Callable[[], SnapshotType], seconds: float) -> SnapshotType:
        """Return the snapshot once it is done, or as it is after `seconds`.

        The job was enqueued a moment ago: until it changes, there is nothing to read.
        """
        deadline = time.monotonic() + seconds
        async with out_of_turn():
            return await self._wait_until_done(key, read, deadline)

    async def _wait_until_done(self, key: str, read: Callable[[], SnapshotType], deadline: float) -> SnapshotType:
        with _registered_watcher(self._end_watchers, key) as event:
            if key in self._recently_changed:
                event.set()
            while not self._closed:
                await _wait_or_set_event(event, min(deadline - time.monotonic(), self._poll_interval_seconds()))
                if time.monotonic() >= deadline:
                    break
                woken = time.time_ns()
                event.clear()
                snapshot = await _read_snapshot_or_none(key, read)
                if snapshot is not None and snapshot.done:
                    traces.record_notification(key, woken)
                    return snapshot
        return await run_in_threadpool(read)

    def _poll_interval_seconds(self) -> float:
        return max(SAFETY_POLL, self.count_watchers() / POLLS_PER_SECOND)


def _seconds_until_settled(snapshot: JobSnapshot | None) -> float:
    """Return the seconds until a snapshot that says so is done by itself."""
    settles_in = getattr(snapshot, "settles_in", None)
    return math.inf if settles_in is None else max(settles_in, MIN_SETTLING_SECONDS)


@contextmanager
def _registered_watcher(watchers: Watchers, key: str) -> Iterator[asyncio.Event]:
    """Register an event among the watchers of a key for the duration of the block."""
    event = asyncio.Event()
    watchers[key].add(event)
    try:
        yield event
    finally:
        watchers[key].discard(event)
        if not watchers[key]:
            del watchers[key]


async def _read_snapshot_or_none(key: str, read: Callable[[], SnapshotType]) -> SnapshotType | None:
    """Return None where the database is unavailable: the watchers' response has already started."""
    try:
        return await run_in_threadpool(read)
    except DBAPIError as error:
        if not is_unavailable(error):
            raise
        log.warning("the database does not answer whoever follows %s", key)
        return None


async def _wait_or_set_event(event: asyncio.Event, seconds: float) -> None:
    """Wait until the event is set, by others or after `seconds`. (Cancellation by a timeout costs more.)"""
    timeout = asyncio.get_running_loop().call_later(seconds, event.set)
    try:
        await event.wait()
    finally:
        timeout.cancel()


async def stream_sse(
    snapshots: AsyncIterator[SnapshotType], encode: Callable[[SnapshotType], str], *, name: str = "status"
) -> AsyncIterator[str]:
    """Encode snapshots as server-sent events; `encode` returns text of any number of lines."""
    async for snapshot in snapshots:
        yield format_sse(name, encode(snapshot))


def format_sse(name: str, text: str) -> str:
    """Return one server-sent event; `text` may have any number of lines."""
    # Clients end lines at CR or LF only, unlike `splitlines`.
    lines = "".join(f"data: {line}\n" for line in LINE_END.split(text))
    return f"event: {name}\n{lines}\n"
