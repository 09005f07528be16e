"""Periodic tasks, a gate, and a limiter that is fair between addresses."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict, deque
from collections.abc import Callable
from concurrent.futures import Future

from starlette.concurrency import run_in_threadpool

log = logging.getLogger(__name__)


async def run_periodically(seconds: float, doing: Callable[[], None], failed: str) -> None:
    """Until it is cancelled, whatever `doing` raises: that is logged, as `failed`."""
    while True:
        await asyncio.sleep(seconds)
        try:
            await run_in_threadpool(doing)
        except Exception:
            log.exception(failed)


class GateClosed(Exception):
    """The service stops: nobody passes any more."""


class Gate:
    """Opened, or shut for good, from any thread; loops wait at it."""

    def __init__(self, *, opened: bool = False) -> None:
        self._future: Future[None] = Future()
        if opened:
            self.open()

    @property
    def is_open(self) -> bool:
        return self._future.done() and self._future.exception() is None

    def open(self) -> None:
        if not self._future.done():
            self._future.set_result(None)

    def close(self) -> None:
        """Who waits gets ShutError; who has passed is not concerned."""
        if not self._future.done():
            self._future.set_exception(GateClosed())

    async def wait_open(self) -> None:
        """Raises ShutError."""
        if not self.is_open:
            await asyncio.shield(asyncio.wrap_future(self._future))


class LimiterFullError(Exception):
    """There is no room, or there is none any more."""


class FairLimiter:
    def __init__(self, at_once: int, waiting: int) -> None:
        self._free, self._most = at_once, waiting
        self._queues: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()

    @property
    def waiting(self) -> int:
        return sum(map(len, self._queues.values()))

    async def acquire(self, address: str) -> None:
        """Waits for a turn, which `give_back` ends. Raises FullError."""
        if self._free:
            self._free -= 1
            return
        if self.waiting >= self._most:
            self._make_room(address)
        turn = asyncio.get_running_loop().create_future()
        self._queues.setdefault(address, deque()).append(turn)
        try:
            await asyncio.shield(turn)  # so that `turn` is ended by us alone
        except asyncio.CancelledError:
            if not turn.done():
                self._leave(address, turn)
            elif turn.exception() is None:  # it came as one left
                self.release()
            raise

    def release(self) -> None:
        if not self._queues:
            self._free += 1
            return
        address, queue = self._queues.popitem(last=False)
        queue.popleft().set_result(None)
        if queue:
            self._queues[address] = queue

    def _make_room(self, address: str) -> None:
        mine = len(self._queues.get(address, ()))
        heaviest = max(self._queues.values(), key=len, default=deque[asyncio.Future[None]]())
        if len(heaviest) <= mine + 1:
            raise LimiterFullError
        heaviest.pop().set_exception(LimiterFullError())

    def _leave(self, address: str, turn: asyncio.Future[None]) -> None:
        queue = self._queues[address]
        queue.remove(turn)
        if not queue:
            del self._queues[address]
