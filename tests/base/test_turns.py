"""Turns: bounded, fair between addresses, and none is lost when somebody leaves."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from server.base.concurrency import FairLimiter, LimiterFullError
from tests.support.quick import in_a_loop


async def settled() -> None:
    """Until whoever may go on has."""
    for _ in range(8):
        await asyncio.sleep(0)


class Queue:
    """Who comes from where, and who has had a turn."""

    def __init__(self, at_once: int, waiting: int, reserve: int = 0) -> None:
        self.turns, self.served, self.refused = FairLimiter(at_once, waiting, reserve), list[str](), list[str]()
        self.running = list[str]()

    async def come(self, *names: str) -> list[asyncio.Task[None]]:
        """A name is a flow, then anything; in capitals, one of a higher number of rank."""
        tasks = [asyncio.create_task(self._wait(name)) for name in names]
        await settled()
        return tasks

    async def _wait(self, name: str) -> None:
        try:
            await self.turns.acquire(name[0], int(name.isupper()))
        except LimiterFullError:
            self.refused.append(name)
        else:
            self.served.append(name)
            self.running.append(name)

    async def end(self, times: int = 1) -> None:
        for _ in range(times):
            self.release()
            await settled()

    def release(self) -> None:
        """End the turn that was given first."""
        name = self.running.pop(0)
        self.turns.release(name[0], int(name.isupper()))


def test_turns_go_round_the_addresses() -> None:
    async def test() -> None:
        queue = Queue(1, 9)
        await queue.come("a1", "a2", "a3", "a4", "b1", "c1", "b2")
        await queue.end(6)
        assert queue.served == ["a1", "a2", "b1", "c1", "a3", "b2", "a4"]
        await queue.end()
        await queue.come("d1")
        assert queue.served[-1] == "d1"

    in_a_loop(test())


def test_within_a_flow_turns_go_round_its_parts() -> None:
    async def test() -> None:
        limiter, served = FairLimiter(1, 9), list[str]()

        async def wait(name: str) -> None:
            await limiter.acquire("a", part=name[0])
            served.append(name)

        tasks = []
        for name in ("x1", "x2", "x3", "x4", "y1", "z1", "y2"):
            tasks.append(asyncio.create_task(wait(name)))
            await settled()
        for _ in range(6):
            limiter.release("a")
            await settled()
        assert served == ["x1", "x2", "y1", "z1", "x3", "y2", "x4"]

    in_a_loop(test())


def test_a_flood_gives_way_to_others_and_to_nobody_of_its_own() -> None:
    async def test() -> None:
        queue = Queue(1, 3)
        await queue.come("a1", "a2", "a3", "a4", "a5")
        assert queue.refused == ["a5"]
        await queue.come("b1")
        assert queue.refused == ["a5", "a4"]
        await queue.come("b2")
        assert queue.refused == ["a5", "a4", "b2"]
        assert queue.turns.waiting_count == 3
        await queue.end(3)
        assert queue.served == ["a1", "a2", "b1", "a3"]

    in_a_loop(test())


def test_without_a_queue_nobody_waits() -> None:
    async def test() -> None:
        queue = Queue(1, 0)
        await queue.come("a1", "b1")
        assert (queue.served, queue.refused) == (["a1"], ["b1"])

    in_a_loop(test())


async def _before(queue: Queue, leaving: asyncio.Task[None]) -> None:
    leaving.cancel()
    await settled()
    await queue.end()


async def _as_the_turn_comes(queue: Queue, leaving: asyncio.Task[None]) -> None:
    queue.release()
    leaving.cancel()


async def _just_before_the_turn_comes(queue: Queue, leaving: asyncio.Task[None]) -> None:
    leaving.cancel()
    queue.release()


@pytest.mark.parametrize("leave", [_before, _just_before_the_turn_comes, _as_the_turn_comes])
def test_who_leaves_keeps_no_turn(leave: Callable[[Queue, asyncio.Task[None]], Awaitable[None]]) -> None:
    async def test() -> None:
        queue = Queue(1, 5)
        _, leaving, _ = await queue.come("a1", "b1", "c1")
        await leave(queue, leaving)
        await settled()
        assert queue.served == ["a1", "c1"]
        assert queue.turns.waiting_count == 0
        await queue.end()
        await queue.come("d1", "d2")
        assert queue.served == ["a1", "c1", "d1"]

    in_a_loop(test())


def test_lower_ranks_go_first_and_take_the_places_of_higher_ones() -> None:
    async def test() -> None:
        queue = Queue(1, 3)
        await queue.come("A1", "A2", "B1", "B2", "c1", "d1")
        assert queue.refused == ["B2", "A2"]
        await queue.end(3)
        assert queue.served == ["A1", "c1", "d1", "B1"]

    in_a_loop(test())


def test_a_reserve_keeps_a_turn_from_each_flow_and_one_from_the_highest_rank() -> None:
    async def test() -> None:
        queue = Queue(2, 9, reserve=2)
        await queue.come("A1", "A2", "A3", "B1", "C1", "D1")
        assert queue.served == ["A1", "A2", "B1"], "others than A have one more, all of that rank together no other"
        await queue.come("e1", "e2", "f1")
        assert queue.served == ["A1", "A2", "B1", "e1"]
        await queue.end()
        assert queue.served[4:] == ["f1"]
        await queue.end()
        assert queue.served[5:] == [], "e holds a turn, and the last one is not for the highest rank"
        await queue.end()
        assert queue.served[5:] == ["A3"]

    in_a_loop(test())


@pytest.mark.parametrize("at_once", [1, 2])
def test_one_flow_never_holds_all_turns(at_once: int) -> None:
    async def test() -> None:
        queue = Queue(at_once, 9, reserve=2)
        await queue.come(*(f"a{n}" for n in range(5)))
        assert len(queue.served) == at_once
        await queue.come("b1")
        assert queue.served[-1] == "b1"

    in_a_loop(test())
