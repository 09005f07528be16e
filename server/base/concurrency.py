"""Periodic tasks, a gate, and a limiter that is fair between addresses."""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict, deque
from collections.abc import Callable
from concurrent.futures import Future

from starlette.concurrency import run_in_threadpool

log = logging.getLogger(__name__)


async def run_periodically(seconds: float, action: Callable[[], None], failure_message: str) -> None:
    """Run `action` in a thread every so many seconds, until cancelled. Log what it raises under `failure_message`."""
    while True:
        await asyncio.sleep(seconds)
        try:
            await run_in_threadpool(action)
        except Exception:
            log.exception(failure_message)


class GateClosed(Exception):
    """The gate is closed for good: the service stops."""


class Gate:
    """A latch that is opened, or closed for good, from any thread; event loops wait for it."""

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
        """Close for good, unless open already: waiters get GateClosed."""
        if not self._future.done():
            self._future.set_exception(GateClosed())

    async def wait_open(self) -> None:
        """Wait until the gate is open. Raise GateClosed."""
        if not self.is_open:
            await asyncio.shield(asyncio.wrap_future(self._future))


class LimiterFullError(Exception):
    """The waiting queue is full, or this waiter had to leave it for another address."""


class FairLimiter:
    """A limiter of concurrency whose bounded waiting queue is shared fairly between client addresses.

    Turns go round the addresses. When the queue is full, the newest waiter of the address with the most waiters gives
    way to one from an address with fewer. For one event loop.
    """

    def __init__(self, max_concurrent: int, max_waiting: int) -> None:
        self._free, self._max_waiting = max_concurrent, max_waiting
        self._queues: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()

    @property
    def waiting(self) -> int:
        return sum(map(len, self._queues.values()))

    async def acquire(self, address: str) -> None:
        """Wait for a turn, which `release` ends. Raise LimiterFullError."""
        if self._free:
            self._free -= 1
            return
        if self.waiting >= self._max_waiting:
            self._make_room(address)
        turn = asyncio.get_running_loop().create_future()
        self._queues.setdefault(address, deque()).append(turn)
        try:
            await asyncio.shield(turn)  # only this class completes `turn`
        except asyncio.CancelledError:
            if not turn.done():
                self._leave(address, turn)
            elif turn.exception() is None:  # granted as its waiter was cancelled
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
        own_waiters = len(self._queues.get(address, ()))
        heaviest = max(self._queues.values(), key=len, default=deque[asyncio.Future[None]]())
        if len(heaviest) <= own_waiters + 1:
            raise LimiterFullError
        heaviest.pop().set_exception(LimiterFullError())

    def _leave(self, address: str, turn: asyncio.Future[None]) -> None:
        queue = self._queues[address]
        queue.remove(turn)
        if not queue:
            del self._queues[address]
