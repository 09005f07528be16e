"""The boards that are watched at present: one reader for each class, whoever watches it.

State lives on the web process's event loop; nothing here holds a thread or a database session while it waits.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from uuid import UUID

from starlette.concurrency import run_in_threadpool

from server.base.errors import RateLimited
from server.board import repository
from server.board.schemas import Board
from server.board.service import load_board
from server.classes import repository as classes
from server.course import Course
from server.database import Database, utc_now
from server.submissions.job_events import JobEvents

log = logging.getLogger(__name__)

MAX_STREAMS_PER_ACCOUNT = 8  # streams of one account
MIN_READ_INTERVAL = 1.0  # seconds between two readings of a class
READ_TIME_DIVISOR = 10  # a class is read for a tenth of the time at most, however large it is
MAX_READING_AGE = 30.0  # seconds: who is stuck changes by itself
MAX_STREAM_SECONDS = 600.0  # seconds: then a browser comes back by itself, and shows again who it is
HEARTBEAT_INTERVAL = 15.0  # seconds
TOO_MANY = "Ce tableau est déjà ouvert dans beaucoup d’onglets : fermez-en, ou actualisez la page à la main."


@dataclass(frozen=True, eq=False)
class BoardReading:
    """A class as it was read; `done` when it is no more. The same as another that shows the same."""

    pulse: Sequence[object]
    board: Board | None
    read_at: float
    took: float

    @property
    def done(self) -> bool:
        return self.board is None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BoardReading) and self.version == other.version

    def __hash__(self) -> int:
        return hash(self.version)

    @property
    def version(self) -> str:
        return self.board.version if self.board else ""


@dataclass(eq=False)
class WatchedClass:
    """A class that is watched: what its watchers are shown, what was read last, and who is to be woken."""

    reading: BoardReading | None = None
    last: BoardReading | None = None
    ended: bool = False
    watchers: set[asyncio.Event] = field(default_factory=set)
    task: asyncio.Task[None] | None = None

    def wake(self) -> None:
        for watcher in self.watchers:
            watcher.set()


class LiveBoards:
    """Reads each class that is watched, when something was graded, and tells all who watch it."""

    def __init__(self, database: Database, course: Course, events: JobEvents) -> None:
        self._database, self._course, self._events = database, course, events
        self._channels: dict[UUID, WatchedClass] = {}
        self._streams: Counter[UUID] = Counter()
        self.stays_open = MAX_STREAM_SECONDS

    def require_free_stream(self, account: UUID) -> None:
        """Raises TooMany for an account that watches enough already."""
        if self._streams[account] >= MAX_STREAMS_PER_ACCOUNT:
            raise RateLimited(TOO_MANY, retry_after=60)

    async def follow(self, class_id: UUID, account: UUID, allowed: Callable[[], bool]) -> AsyncIterator[Board | None]:
        """The board at first, then each time that it has changed; None now and then, as a sign of life.

        Ends once `allowed` (asked in a thread each time) is False, the class is gone, or the time is over.
        """
        with self._stream(account), self._watch(class_id) as (channel, woken):
            ends, sent = time.monotonic() + self.stays_open, ""
            while not channel.ended and await run_in_threadpool(allowed):
                reading = channel.reading
                if reading is not None and reading.board is not None and reading.version != sent:
                    sent = reading.version
                    yield reading.board
                elif reading is not None:
                    yield None
                left = ends - time.monotonic()
                if left <= 0 and reading is not None:
                    return
                await _wait(woken, min(HEARTBEAT_INTERVAL, max(left, MIN_READ_INTERVAL)))

    @contextmanager
    def _stream(self, account: UUID) -> Iterator[None]:
        self._streams[account] += 1
        try:
            yield
        finally:
            self._streams[account] -= 1
            if not self._streams[account]:
                del self._streams[account]

    @contextmanager
    def _watch(self, class_id: UUID) -> Iterator[tuple[WatchedClass, asyncio.Event]]:
        channel = self._channels.get(class_id)
        if channel is None:
            channel = self._channels[class_id] = WatchedClass()
            channel.task = asyncio.create_task(self._keep_reading(class_id, channel))
        woken = asyncio.Event()
        channel.watchers.add(woken)
        try:
            yield channel, woken
        finally:
            channel.watchers.discard(woken)
            if not channel.watchers:
                self._close(class_id, channel)

    def _close(self, class_id: UUID, channel: WatchedClass) -> None:
        if self._channels.get(class_id) is channel:
            del self._channels[class_id]
        if channel.task is not None:
            channel.task.cancel()

    async def _keep_reading(self, class_id: UUID, channel: WatchedClass) -> None:
        """Until nobody watches any more, or the server stops. Whatever goes wrong ends the streams: browsers return."""
        try:
            read = partial(self._read, class_id, channel)
            async for reading in self._events.follow(f"class:{class_id}", read, watches_all_jobs=True):
                channel.reading = reading
                channel.wake()
                await asyncio.sleep(max(MIN_READ_INTERVAL, READ_TIME_DIVISOR * reading.took))
        except Exception:
            log.exception("class %s could not be read for those who watch it", class_id)
        finally:
            channel.ended = True
            if self._channels.get(class_id) is channel:
                del self._channels[class_id]
            channel.wake()

    def _read(self, class_id: UUID, channel: WatchedClass) -> BoardReading:
        """The same reading again where nothing of the class was graded meanwhile; in a thread."""
        last, began = channel.last, time.monotonic()
        with self._database.read() as db:
            pulse = repository.load_pulse(db, class_id)
            if last is not None and last.pulse == pulse and began - last.read_at < MAX_READING_AGE:
                return last
            school_class = classes.find_class(db, class_id)
            shown = None if school_class is None else load_board(db, self._course, school_class, utc_now())
        ended = time.monotonic()
        channel.last = BoardReading(pulse, shown, ended, ended - began)
        return channel.last


async def _wait(event: asyncio.Event, seconds: float) -> None:
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return
    event.clear()
