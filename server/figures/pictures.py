"""Pictures for those who look: drawn once for all who wait, one after the other, remembered here and on disk."""

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
from server.figures.orders import WARM, Order
from server.figures.store import Store

log = logging.getLogger(__name__)

#: Different pictures that wait to be drawn: a class that looks at its verdicts at once must find room.
MOST_WAITING = 256
REMEMBERED_BYTES = 32 << 20
#: Bytes of what is to be drawn.
LONGEST_QUESTION = 1 << 20


class Drawer(Protocol):
    """What draws: a `Helper`, outside of tests."""

    async def ask(self, question: bytes) -> bytes:
        """Raises UnansweredError."""

    async def close(self) -> None: ...


class _Coming:
    """A picture on its way, and how many wait for it; from `begun` on, it is drawn whoever leaves."""

    def __init__(self) -> None:
        self.viewers = 0
        self.begun = False

    def begin(self, bringing: Coroutine[None, None, bytes]) -> None:
        self.task = asyncio.create_task(bringing)


class Pictures:
    """For one event loop."""

    def __init__(self, drawer: Drawer, store: Store, *, most_waiting: int = MOST_WAITING) -> None:
        self._drawer, self._store = drawer, store
        self._turns = FairLimiter(1, most_waiting)
        self._lately: LRUCache[str, bytes] = LRUCache(REMEMBERED_BYTES, len)
        self._coming: dict[str, _Coming] = {}
        self._warming: asyncio.Task[None] | None = None

    async def picture(self, order: Order, address: str) -> bytes:
        """Raises Crowded, or Failed to all who wait for it.

        Whoever leaves does not stop it for the others; what all have left before it was begun is not drawn.
        """
        known = self._lately.get(order.key)
        if known is not None:
            return known
        coming = self._coming.get(order.key) or self._sent_for(order, address)
        coming.viewers += 1
        try:
            return await asyncio.shield(coming.task)
        finally:
            coming.viewers -= 1
            if not coming.viewers and not coming.begun:
                self._forget(order.key, coming)
                coming.task.cancel()

    def _sent_for(self, order: Order, address: str) -> _Coming:
        coming = self._coming[order.key] = _Coming()
        coming.begin(self._brought(order, address, coming))
        coming.task.add_done_callback(partial(self._over, order.key, coming))
        return coming

    def _over(self, key: str, coming: _Coming, task: asyncio.Task[bytes]) -> None:
        self._forget(key, coming)
        if not task.cancelled():
            task.exception()  # where nobody waits any more, too

    def _forget(self, key: str, coming: _Coming) -> None:
        """The next to look sends for it anew, if somebody has not done so already."""
        if self._coming.get(key) is coming:
            del self._coming[key]

    async def _brought(self, order: Order, address: str, coming: _Coming) -> bytes:
        kept = await run_in_threadpool(self._store.get, order.key)
        picture = await self._drawn(order, address, coming) if kept is None else kept
        return self._lately.put(order.key, picture)

    async def _drawn(self, order: Order, address: str, coming: _Coming) -> bytes:
        if len(order.question) > LONGEST_QUESTION:
            raise InternalFailure(order.words.failed)
        try:
            await self._turns.acquire(address)
        except LimiterFullError:
            raise Overloaded(order.words.crowded, retry_after=5) from None
        coming.begun = True
        try:
            picture = await self._drawer.ask(order.question)
        except HelperError as error:
            raise InternalFailure(order.words.failed) from error
        finally:
            self._turns.release()
        await run_in_threadpool(self._store.put, order.key, picture)
        return picture

    def warm(self) -> None:
        """Has the process that draws made ready meanwhile, so that the first to look does not wait for its start."""
        self._warming = asyncio.create_task(self._warm())

    async def _warm(self) -> None:
        try:
            await self._drawer.ask(WARM)
        except HelperError:
            log.warning("the process that draws could not be made ready beforehand")

    async def close(self) -> None:
        if self._warming is not None:
            self._warming.cancel()
        await self._drawer.close()
        left = [coming.task for coming in self._coming.values()]
        await asyncio.gather(*left, *filter(None, [self._warming]), return_exceptions=True)
