"""Who is looking at which submission, and how they learn that it has changed.

Everything here runs on the web process's event loop, and holds neither a thread nor a database session while waiting.
"""

import asyncio
from collections import defaultdict
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar
from uuid import UUID

from starlette.concurrency import run_in_threadpool

QUEUE_MOVES_EVERY = 0.3  # seconds: places in the queue are refreshed no more often than this
SAFETY_POLL = 2.0  # seconds: longest time without looking, should a signal be lost


class Snapshot(Protocol):
    """What a watcher reads: it ends when `done`, and is told again when it differs."""

    @property
    def done(self) -> bool: ...


S = TypeVar("S", bound=Snapshot)


class Events:
    """Wakes the watchers of a submission."""

    def __init__(self) -> None:
        self._watchers: dict[UUID, set[asyncio.Event]] = defaultdict(set)
        self._moving = False
        self._closed = False

    def close(self) -> None:
        """Ends every watch, as the server stops: browsers come back by themselves."""
        self._closed = True
        self._moved()

    def changed(self, submission_id: UUID) -> None:
        """A submission has changed state: its watchers look at once, the others soon (their place has moved)."""
        self._wake(submission_id)
        if not self._moving and self._watchers:
            self._moving = True
            asyncio.get_running_loop().call_later(QUEUE_MOVES_EVERY, self._moved)

    def _moved(self) -> None:
        self._moving = False
        for submission_id in list(self._watchers):
            self._wake(submission_id)

    def _wake(self, submission_id: UUID) -> None:
        for event in self._watchers.get(submission_id, ()):
            event.set()

    @contextmanager
    def _watch(self, submission_id: UUID) -> Iterator[asyncio.Event]:
        event = asyncio.Event()
        self._watchers[submission_id].add(event)
        try:
            yield event
        finally:
            self._watchers[submission_id].discard(event)
            if not self._watchers[submission_id]:
                del self._watchers[submission_id]

    async def follow(self, submission_id: UUID, read: Callable[[], S]) -> AsyncIterator[S]:
        """Yields what `read` gives (called in a thread) at first, then each time that it differs, until it is done
        (or the server stops)."""
        with self._watch(submission_id) as event:
            latest: S | None = None
            while True:
                event.clear()  # before reading: a change during the read is not missed
                snapshot = await run_in_threadpool(read)
                if snapshot != latest:
                    yield snapshot
                    latest = snapshot
                if snapshot.done or self._closed:
                    return
                await _wait(event, SAFETY_POLL)

    async def until_done(self, submission_id: UUID, read: Callable[[], S], seconds: float) -> S:
        """The snapshot once it is done, or as it is after `seconds`."""
        try:
            async with asyncio.timeout(seconds):
                async for snapshot in self.follow(submission_id, read):
                    if snapshot.done:
                        return snapshot
        except TimeoutError:
            pass
        return await run_in_threadpool(read)


async def _wait(event: asyncio.Event, seconds: float) -> None:
    try:
        async with asyncio.timeout(seconds):
            await event.wait()
    except TimeoutError:
        return


async def as_sse(
    snapshots: AsyncIterator[S], encode: Callable[[S], str], *, name: str = "status"
) -> AsyncIterator[str]:
    """Snapshots as server-sent events; `encode` gives text of any number of lines."""
    async for snapshot in snapshots:
        lines = "".join(f"data: {line}\n" for line in encode(snapshot).splitlines())
        yield f"event: {name}\n{lines}\n"
