"""Boards and lessons that are open in browsers: one reading of each class, broadcast to all of its streams.

State lives on the web process's event loop; waiting holds neither a thread nor a database session.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from functools import partial
from typing import Any, Generic, Protocol, TypeVar
from uuid import UUID

from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.errors import RateLimited
from server.board import repository
from server.board.repository import ClassVersionTag
from server.board.schemas import Board
from server.board.service import load_board
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.course import Course
from server.database import Database, utc_now
from server.submissions.job_events import JobEvents

log = logging.getLogger(__name__)

MAX_STREAMS_PER_ACCOUNT = 8
MIN_READ_INTERVAL = 0.3  # seconds between two readings of a class
READ_TIME_DIVISOR = 10  # reading a class takes a tenth of a processor at most, however large it is
MAX_READING_AGE = 15.0  # seconds, as students become stuck by time alone
MAX_STREAM_SECONDS = 600.0  # then the browser reconnects, and is authenticated again
HEARTBEAT_INTERVAL = 15.0  # seconds
TOO_MANY = "Ce tableau est déjà ouvert dans beaucoup d’onglets : fermez-en, ou actualisez la page à la main."


class Versioned(Protocol):
    """What streams show; equal versions show the same."""

    @property
    def version(self) -> Hashable: ...


PulseType = TypeVar("PulseType")
ShownType = TypeVar("ShownType", bound=Versioned)


@dataclass(frozen=True)
class ClassView(Generic[PulseType, ShownType]):
    """What a kind of stream shows of a class: `load` reads it where its pulse has changed, in the transaction in which
    `load_pulse` has loaded that."""

    load_pulse: Callable[[Session, UUID], PulseType]
    load: Callable[[Session, Course, SchoolClass, datetime, PulseType], ShownType]


BOARD: ClassView[ClassVersionTag, Board] = ClassView(repository.load_class_version_tag, load_board)


@dataclass(frozen=True, eq=False)
class ViewSnapshot(Generic[ShownType]):
    """What was read of a class; `done` once it is deleted. `duration`: seconds of processor that it took.

    Readings are equal where they show the same.
    """

    pulse: object
    shown: ShownType | None
    read_at: float
    duration: float

    @property
    def done(self) -> bool:
        return self.shown is None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ViewSnapshot) and self.version == other.version

    def __hash__(self) -> int:
        return hash(self.version)

    @property
    def version(self) -> Hashable:
        return self.shown.version if self.shown else None


@dataclass(eq=False)
class WatchedClass(Generic[ShownType]):
    """A class with open streams: the reading they show, the last one, and the events that wake them.

    `duration`: seconds of processor that a reading takes, of the last two the quicker one; 0 at first.
    """

    reading: ViewSnapshot[ShownType] | None = None
    last: ViewSnapshot[ShownType] | None = None
    duration: float = 0.0
    ended: bool = False
    watchers: set[asyncio.Event] = field(default_factory=set)
    task: asyncio.Task[None] | None = None

    def seconds_between_readings(self) -> float:
        """Return the seconds between two readings."""
        return max(MIN_READ_INTERVAL, READ_TIME_DIVISOR * self.duration)

    def notify_watchers(self) -> None:
        for watcher in self.watchers:
            watcher.set()


class LiveClassViews:
    """Reads each watched class after a grading, and broadcasts its board, or another view of it, to its streams."""

    def __init__(self, database: Database, course: Course, events: JobEvents) -> None:
        self._database, self._course, self._events = database, course, events
        self._watched: dict[tuple[UUID, ClassView[Any, Any]], WatchedClass[Any]] = {}
        self._streams: Counter[UUID] = Counter()
        self.max_stream_seconds = MAX_STREAM_SECONDS

    def require_free_stream(self, account: UUID) -> None:
        """Raise RateLimited for an account that has too many streams."""
        if self._streams[account] >= MAX_STREAMS_PER_ACCOUNT:
            raise RateLimited(TOO_MANY, retry_after=60)

    async def stream_view(
        self, view: ClassView[Any, ShownType], class_id: UUID, account: UUID, allowed: Callable[[], bool]
    ) -> AsyncIterator[ShownType | None]:
        """Yield what is shown at first, then each time that it has changed; None now and then, as a heartbeat.

        The stream ends once `allowed` (called in a thread each time) is False, the class is deleted, or time is up.
        """
        with self._count_stream(account), self._register_watcher(view, class_id) as (watched, changed):
            deadline, sent = time.monotonic() + self.max_stream_seconds, None
            while not watched.ended and await run_in_threadpool(allowed):
                reading = watched.reading
                if reading is not None and reading.shown is not None and reading != sent:
                    sent = reading
                    yield reading.shown
                elif reading is not None:
                    yield None
                left = deadline - time.monotonic()
                if left <= 0 and reading is not None:
                    return
                await _wait_for_event(changed, min(HEARTBEAT_INTERVAL, max(left, MIN_READ_INTERVAL)))

    @contextmanager
    def _count_stream(self, account: UUID) -> Iterator[None]:
        self._streams[account] += 1
        try:
            yield
        finally:
            self._streams[account] -= 1
            if not self._streams[account]:
                del self._streams[account]

    @contextmanager
    def _register_watcher(
        self, view: ClassView[Any, ShownType], class_id: UUID
    ) -> Iterator[tuple[WatchedClass[ShownType], asyncio.Event]]:
        watched = self._watched.get((class_id, view))
        if watched is None:
            watched = self._watched[class_id, view] = WatchedClass()
            watched.task = asyncio.create_task(self._read_while_watched(view, class_id, watched))
        changed = asyncio.Event()
        watched.watchers.add(changed)
        try:
            yield watched, changed
        finally:
            watched.watchers.discard(changed)
            if not watched.watchers:
                self._stop_watching(view, class_id, watched)
                if watched.task is not None:
                    watched.task.cancel()

    def _stop_watching(self, view: ClassView[Any, ShownType], class_id: UUID, watched: WatchedClass[ShownType]) -> None:
        if self._watched.get((class_id, view)) is watched:
            del self._watched[class_id, view]

    async def _read_while_watched(
        self, view: ClassView[Any, ShownType], class_id: UUID, watched: WatchedClass[ShownType]
    ) -> None:
        """Read the class until nobody watches it. An error ends the streams: browsers reconnect."""
        try:
            read = partial(self._read_if_changed, view, class_id, watched)
            key = f"class:{class_id}"
            async for reading in self._events.follow(
                key, read, also_watches_all_jobs=True, find_rest=watched.seconds_between_readings
            ):
                watched.reading = reading
                watched.notify_watchers()
        except Exception:
            log.exception("class %s could not be read for those who watch it", class_id)
        finally:
            watched.ended = True
            self._stop_watching(view, class_id, watched)
            watched.notify_watchers()

    def _read_if_changed(
        self, view: ClassView[Any, ShownType], class_id: UUID, watched: WatchedClass[ShownType]
    ) -> ViewSnapshot[ShownType]:
        """Read the class in a thread, or return the last reading where nothing has changed meanwhile."""
        last, began = watched.last, time.thread_time()
        with self._database.read() as db:
            pulse = view.load_pulse(db, class_id)
            if last is not None and last.pulse == pulse and time.monotonic() - last.read_at < MAX_READING_AGE:
                return last
            school_class = classes.find_class(db, class_id)
            shown = None if school_class is None else view.load(db, self._course, school_class, utc_now(), pulse)
        duration = time.thread_time() - began
        watched.last = ViewSnapshot(pulse, shown, time.monotonic(), duration)
        watched.duration = 0.0 if last is None else min(last.duration, duration)
        return watched.last


async def _wait_for_event(event: asyncio.Event, seconds: float) -> None:
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return
    event.clear()
