"""Pictures for those who look: drawn once for all who wait, one after the other, remembered here and on disk."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Protocol

from starlette.concurrency import run_in_threadpool

from server.base.caches import Lately
from server.base.errors import Crowded, Failed
from server.base.helper import UnansweredError
from server.base.turns import FullError, Turns
from server.figures.orders import Order
from server.figures.store import Store

#: Different pictures that wait to be drawn: a class that looks at its verdicts at once must find room.
MOST_WAITING = 256
REMEMBERED_BYTES = 32 << 20
#: Bytes of what is to be drawn.
LONGEST_QUESTION = 1 << 20
CROWDED = "Beaucoup de figures se dessinent en ce moment : réessayez dans quelques secondes."
FAILED = "Cette figure n’a pas pu être dessinée : l’incident est de notre côté. Réessayez."


class Drawer(Protocol):
    """What draws: a `Helper`, outside of tests."""

    async def ask(self, question: bytes) -> bytes:
        """Raises UnansweredError."""

    async def close(self) -> None: ...


class Pictures:
    """For one event loop."""

    def __init__(self, drawer: Drawer, store: Store, *, most_waiting: int = MOST_WAITING) -> None:
        self._drawer, self._store = drawer, store
        self._turns = Turns(1, most_waiting)
        self._lately: Lately[str, bytes] = Lately(REMEMBERED_BYTES, len)
        self._coming: dict[str, asyncio.Task[bytes]] = {}

    async def picture(self, order: Order, address: str) -> bytes:
        """Raises Crowded, or Failed to all who wait for it. Whoever leaves does not stop it for the others."""
        known = self._lately.get(order.key)
        if known is not None:
            return known
        coming = self._coming.get(order.key)
        if coming is None:
            coming = self._coming[order.key] = asyncio.create_task(self._brought(order, address))
            coming.add_done_callback(partial(self._over, order.key))
        return await asyncio.shield(coming)

    def _over(self, key: str, coming: asyncio.Task[bytes]) -> None:
        del self._coming[key]
        if not coming.cancelled():
            coming.exception()  # where nobody waits any more, too

    async def _brought(self, order: Order, address: str) -> bytes:
        kept = await run_in_threadpool(self._store.get, order.key)
        picture = await self._drawn(order, address) if kept is None else kept
        return self._lately.put(order.key, picture)

    async def _drawn(self, order: Order, address: str) -> bytes:
        if len(order.question) > LONGEST_QUESTION:
            raise Failed(FAILED)
        try:
            await self._turns.take(address)
        except FullError:
            raise Crowded(CROWDED, retry_after=5) from None
        try:
            picture = await self._drawer.ask(order.question)
        except UnansweredError as error:
            raise Failed(FAILED) from error
        finally:
            self._turns.give_back()
        await run_in_threadpool(self._store.put, order.key, picture)
        return picture

    async def close(self) -> None:
        await self._drawer.close()
        await asyncio.gather(*self._coming.values(), return_exceptions=True)
