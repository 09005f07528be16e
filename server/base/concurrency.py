"""Periodic tasks, a gate, a limiter that is fair between flows, and works that are done once for all."""

from __future__ import annotations

import asyncio
import logging
from bisect import insort
from collections import Counter, OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, TypeVar

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.concurrency import run_in_threadpool

log = logging.getLogger(__name__)
T = TypeVar("T")


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
    """The waiting queue is full, or this waiter had to leave it for another."""


@dataclass(frozen=True)
class _Waiter:
    """`lap`: how many of the same part of its flow waited before it."""

    turn: asyncio.Future[None]
    part: str
    lap: int


class FairLimiter:
    """A limiter of concurrency whose bounded waiting queue is shared fairly between flows: addresses, or accounts.

    Lower ranks go first; within a rank, turns go round the flows, and within a flow round its parts: the logins of an
    address. When the queue is full, the last waiter of the highest rank, and there of the flow with the most waiters,
    gives way to a lower rank or to a flow with fewer. For one event loop.

    With a `reserve`, so many turns are given beyond `max_concurrent`, so that nobody holds all of them: each to a flow
    that holds none, the last one to a rank lower than that of some holder.
    """

    def __init__(self, max_concurrent: int, max_waiting: int, reserve: int = 0) -> None:
        self._max_concurrent, self._max_waiting, self._reserve = max_concurrent, max_waiting, reserve
        self._held: Counter[tuple[int, str]] = Counter()
        self._queues: OrderedDict[tuple[int, str], list[_Waiter]] = OrderedDict()

    @property
    def waiting_count(self) -> int:
        return sum(map(len, self._queues.values()))

    async def acquire(self, flow: str, rank: int = 0, part: str = "") -> None:
        """Wait for a turn, which `release` ends. Raise LimiterFullError."""
        key = (rank, flow)
        if self._may_start(key):
            self._held[key] += 1
            return
        if self.waiting_count >= self._max_waiting:
            self._make_room(key)
        turn = asyncio.get_running_loop().create_future()
        queue = self._queues.setdefault(key, [])
        lap = sum(waiter.part == part for waiter in queue)
        insort(queue, _Waiter(turn, part, lap), key=lambda waiter: waiter.lap)
        try:
            await asyncio.shield(turn)  # only this class completes `turn`
        except asyncio.CancelledError:
            if not turn.done():
                self._leave_queue(key, turn)
            elif turn.exception() is None:  # granted as its waiter was cancelled
                self.release(flow, rank)
            raise

    def release(self, flow: str, rank: int = 0) -> None:
        """End a turn, and give those that become free."""
        self._held[rank, flow] -= 1
        if not self._held[rank, flow]:
            del self._held[rank, flow]
        while (key := self._choose_next_turn()) is not None:
            queue = self._queues.pop(key)
            queue.pop(0).turn.set_result(None)
            self._held[key] += 1
            if queue:
                self._queues[key] = queue

    def _may_start(self, key: tuple[int, str]) -> bool:
        beyond = self._held.total() - self._max_concurrent
        if beyond < 0:
            return True
        if beyond >= self._reserve or key in self._held:
            return False
        return beyond < self._reserve - 1 or key[0] < max(rank for rank, _ in self._held)

    def _choose_next_turn(self) -> tuple[int, str] | None:
        return min(filter(self._may_start, self._queues), key=lambda key: key[0], default=None)

    def _make_room(self, key: tuple[int, str]) -> None:
        own_waiters = len(self._queues.get(key, ()))
        heaviest = max(self._queues, key=lambda other: (other[0], len(self._queues[other])), default=None)
        if heaviest is None or heaviest[0] < key[0]:
            raise LimiterFullError
        if heaviest[0] == key[0] and len(self._queues[heaviest]) <= own_waiters + 1:
            raise LimiterFullError
        evicted = self._queues[heaviest][-1].turn
        self._leave_queue(heaviest, evicted)
        evicted.set_exception(LimiterFullError())

    def _leave_queue(self, key: tuple[int, str], turn: asyncio.Future[None]) -> None:
        queue = [waiter for waiter in self._queues[key] if waiter.turn is not turn]
        if queue:
            self._queues[key] = queue
        else:
            del self._queues[key]


class SingleFlight:
    """Does a slow work once for all who ask for it meanwhile. For one event loop.

    The work runs in a thread beside those that serve pages, and nobody waits for it in one of these: readers of
    everything that is made at its first use would take them all.
    """

    def __init__(self, max_concurrent: int = 1) -> None:
        self._max_concurrent = max_concurrent
        self._limiter: CapacityLimiter | None = None
        self._tasks: dict[Hashable, asyncio.Task[Any]] = {}

    async def run(self, key: Hashable, work: Callable[[], T]) -> T:
        """Return what `work` returns, or what it has returned to whoever asked first for this key and still waits."""
        task = self._tasks.get(key)
        if task is None:
            self._limiter = self._limiter or CapacityLimiter(self._max_concurrent)
            task = self._tasks[key] = asyncio.create_task(run_sync(work, limiter=self._limiter))
            task.add_done_callback(lambda done: self._finish(key, done))
        result: T = await asyncio.shield(task)
        return result

    def _finish(self, key: Hashable, task: asyncio.Task[Any]) -> None:
        del self._tasks[key]
        if not task.cancelled():
            task.exception()  # where everybody has left, too
