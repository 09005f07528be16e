"""Pictures, rendered once for concurrent requests (single-flight), one at a time for each visitor, and cached in memory
and on disk."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Coroutine
from functools import partial
from typing import Protocol

from starlette.concurrency import run_in_threadpool

from server.base.caches import LRUCache
from server.base.concurrency import FairLimiter, LimiterFullError
from server.base.errors import InternalFailure, Overloaded
from server.base.helpers import HelperError
from server.base.turns import out_of_turn
from server.figures.drawing_requests import WARM_UP_PAYLOAD, DrawingRequest
from server.figures.program import RESERVE
from server.figures.store import PictureFileStore

log = logging.getLogger(__name__)

#: Different pictures that wait to be drawn: a class that looks at its verdicts at once must find room.
MAX_WAITING = 256
MEMORY_CACHE_BYTES = 32 << 20
#: Bytes of what is to be drawn.
MAX_PAYLOAD_BYTES = 1 << 20


class DrawingHelper(Protocol):
    """What draws: a `Helper`, outside of tests."""

    async def ask(self, question: bytes) -> bytes:
        """Raises UnansweredError."""

    async def close(self) -> None: ...


class PendingPicture:
    """A pending picture and the number of its viewers. Once `started`, it is rendered even if all viewers leave."""

    def __init__(self) -> None:
        self.viewers = 0
        self.started = False

    def start_rendering(self, rendering: Coroutine[None, None, bytes]) -> None:
        self.task = asyncio.create_task(rendering)


class PictureRenderer:
    """For one event loop."""

    def __init__(self, drawer: DrawingHelper, store: PictureFileStore, *, most_waiting: int = MAX_WAITING) -> None:
        self._drawer, self._store = drawer, store
        self._limiter = FairLimiter(1, most_waiting, RESERVE)
        self._cache: LRUCache[str, bytes] = LRUCache(MEMORY_CACHE_BYTES, len)
        self._in_flight: dict[str, PendingPicture] = {}
        self._warming: asyncio.Task[None] | None = None

    async def load_or_render(self, request: DrawingRequest, flow: str, rank: int) -> bytes:
        """Return a picture for a sender's flow and rank. Raises Crowded, or Failed to all who wait for it.

        Whoever leaves does not stop it for the others; what all have left before it was begun is not drawn.
        """
        known = self._cache.get(request.key)
        if known is not None:
            return known
        coming = self._in_flight.get(request.key) or self._start_pending_picture(request, flow, rank)
        coming.viewers += 1
        try:
            async with out_of_turn():
                return await asyncio.shield(coming.task)
        finally:
            coming.viewers -= 1
            if not coming.viewers and not coming.started:
                self._forget_pending_picture(request.key, coming)
                coming.task.cancel()

    def _start_pending_picture(self, request: DrawingRequest, flow: str, rank: int) -> PendingPicture:
        coming = self._in_flight[request.key] = PendingPicture()
        coming.start_rendering(self._load_from_store_or_render(request, flow, rank, coming))
        coming.task.add_done_callback(partial(self._finish_pending_picture, request.key, coming))
        return coming

    def _finish_pending_picture(self, key: str, pending: PendingPicture, task: asyncio.Task[bytes]) -> None:
        self._forget_pending_picture(key, pending)
        if not task.cancelled():
            task.exception()  # where nobody waits any more, too

    def _forget_pending_picture(self, key: str, pending: PendingPicture) -> None:
        """Drop the entry, unless a newer one has replaced it."""
        if self._in_flight.get(key) is pending:
            del self._in_flight[key]

    async def _load_from_store_or_render(
        self, request: DrawingRequest, flow: str, rank: int, pending: PendingPicture
    ) -> bytes:
        kept = await run_in_threadpool(self._store.get, request.key)
        picture = await self._render_in_turn(request, flow, rank, pending) if kept is None else kept
        return self._cache.put(request.key, picture)

    async def _render_in_turn(self, request: DrawingRequest, flow: str, rank: int, pending: PendingPicture) -> bytes:
        if len(request.payload) > MAX_PAYLOAD_BYTES:
            raise InternalFailure(request.messages.failed)
        try:
            await self._limiter.acquire(flow, rank)
        except LimiterFullError:
            raise Overloaded(request.messages.crowded, retry_after=5) from None
        pending.started = True
        try:
            picture = await self._drawer.ask(request.payload)
        except HelperError as error:
            raise InternalFailure(request.messages.failed) from error
        finally:
            self._limiter.release(flow, rank)
        await run_in_threadpool(self._store.put, request.key, picture)
        return picture

    def start_process_in_background(self) -> None:
        """Start the drawing process in the background, so that the first request does not wait for it."""
        self._warming = asyncio.create_task(self._start_process())

    async def _start_process(self) -> None:
        try:
            await self._drawer.ask(WARM_UP_PAYLOAD)
        except HelperError:
            log.warning("the process that draws could not be made ready beforehand")

    async def close(self) -> None:
        if self._warming is not None:
            self._warming.cancel()
        await self._drawer.close()
        left = [coming.task for coming in self._in_flight.values()]
        await asyncio.gather(*left, *filter(None, [self._warming]), return_exceptions=True)
