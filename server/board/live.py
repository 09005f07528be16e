"""Boards that are open in browsers: one reading of each class, broadcast to all of its streams.

State lives on the web process's event loop; waiting holds neither a thread nor a database session.
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

MAX_STREAMS_PER_ACCOUNT = 8
MIN_READ_INTERVAL = 1.0  # seconds between two readings of a class
READ_TIME_DIVISOR = 10  # reading a class takes a tenth of the time at most, however large it is
MAX_READING_AGE = 30.0  # seconds, as students become stuck by time alone
MAX_STREAM_SECONDS = 600.0  # then the browser reconnects, and is authenticated again
HEARTBEAT_INTERVAL = 15.0  # seconds
TOO_MANY = "Ce tableau est déjà ouvert dans beaucoup d’onglets : fermez-en, ou actualisez la page à la main."


@dataclass(frozen=True, eq=False)
class BoardReading:
    """A class as it was read; `done` once it is deleted. Readings are equal where their boards show the same."""

    pulse: Sequence[object]
    board: Board | None
    read_at: float
    duration: float

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
    """A class with open streams: the reading they show, the last one, and the events that wake them."""

    reading: BoardReading | None = None
    last: BoardReading | None = None
    ended: bool = False
    watchers: set[asyncio.Event] = field(default_factory=set)
    task: asyncio.Task[None] | None = None

    def notify(self) -> None:
        for watcher in self.watchers:
            watcher.set()


class LiveBoards:
    """Reads each watched class after a grading, and broadcasts the board to its streams."""

    def __init__(self, database: Database, course: Course, events: JobEvents) -> None:
        self._database, self._course, self._events = database, course, events
        self._watched: dict[UUID, WatchedClass] = {}
        self._streams: Counter[UUID] = Counter()
        self.max_stream_seconds = MAX_STREAM_SECONDS

    def require_free_stream(self, account: UUID) -> None:
        """Raise RateLimited for an account that has too many streams."""
        if self._streams[account] >= MAX_STREAMS_PER_ACCOUNT:
            raise RateLimited(TOO_MANY, retry_after=60)

    async def follow(self, class_id: UUID, account: UUID, allowed: Callable[[], bool]) -> AsyncIterator[Board | None]:
        """Yield the board at first, then each time that it has changed; None now and then, as a heartbeat.

        The stream ends once `allowed` (called in a thread each time) is False, the class is deleted, or time is up.
        """
        with self._stream(account), self._watch(class_id) as (watched, changed):
            deadline, sent_version = time.monotonic() + self.max_stream_seconds, ""
            while not watched.ended and await run_in_threadpool(allowed):
                reading = watched.reading
                if reading is not None and reading.board is not None and reading.version != sent_version:
                    sent_version = reading.version
                    yield reading.board
                elif reading is not None:
                    yield None
                left = deadline - time.monotonic()
                if left <= 0 and reading is not None:
                    return
                await _wait(changed, min(HEARTBEAT_INTERVAL, max(left, MIN_READ_INTERVAL)))

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
        watched = self._watched.get(class_id)
        if watched is None:
            watched = self._watched[class_id] = WatchedClass()
            watched.task = asyncio.create_task(self._keep_reading(class_id, watched))
        changed = asyncio.Event()
        watched.watchers.add(changed)
        try:
            yield watched, changed
        finally:
            watched.watchers.discard(changed)
            if not watched.watchers:
                self._close(class_id, watched)

    def _close(self, class_id: UUID, watched: WatchedClass) -> None:
        if self._watched.get(class_id) is watched:
            del self._watched[class_id]
        if watched.task is not None:
            watched.task.cancel()

    async def _keep_reading(self, class_id: UUID, watched: WatchedClass) -> None:
        """Read the class until nobody watches it. An error ends the streams: browsers reconnect."""
        try:
            read = partial(self._read, class_id, watched)
            async for reading in self._events.follow(f"class:{class_id}", read, watches_all_jobs=True):
                watched.reading = reading
                watched.notify()
                await asyncio.sleep(max(MIN_READ_INTERVAL, READ_TIME_DIVISOR * reading.duration))
        except Exception:
            log.exception("class %s could not be read for those who watch it", class_id)
        finally:
            watched.ended = True
            if self._watched.get(class_id) is watched:
                del self._watched[class_id]
            watched.notify()

    def _read(self, class_id: UUID, watched: WatchedClass) -> BoardReading:
        """Read the class in a thread, or return the last reading where nothing was graded meanwhile."""
        last, began = watched.last, time.monotonic()
        with self._database.read() as db:
            pulse = repository.load_pulse(db, class_id)
            if last is not None and last.pulse == pulse and began - last.read_at < MAX_READING_AGE:
                return last
            school_class = classes.find_class(db, class_id)
            board = None if school_class is None else load_board(db, self._course, school_class, utc_now())
        ended = time.monotonic()
        watched.last = BoardReading(pulse, board, ended, ended - began)
        return watched.last


async def _wait(event: asyncio.Event, seconds: float) -> None:
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return
    event.clear()
