"""A few at once, others in a queue of bounded length, fairly shared between the addresses that they come from.

Turns go round the addresses. When the queue is full, the last to have come from the address that has the most in it
gives way to one from an address that has fewer: nobody's flood keeps the others out. For one event loop.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict, deque


class FullError(Exception):
    """There is no room, or there is none any more."""


class Turns:
    def __init__(self, at_once: int, waiting: int) -> None:
        self._free, self._most = at_once, waiting
        self._queues: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()

    @property
    def waiting(self) -> int:
        return sum(map(len, self._queues.values()))

    async def take(self, address: str) -> None:
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
                self.give_back()
            raise

    def give_back(self) -> None:
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
            raise FullError
        heaviest.pop().set_exception(FullError())

    def _leave(self, address: str, turn: asyncio.Future[None]) -> None:
        queue = self._queues[address]
        queue.remove(turn)
        if not queue:
            del self._queues[address]
