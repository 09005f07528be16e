"""What is slow and made once: whoever waits for it takes no thread from the pages."""

from __future__ import annotations

import asyncio
import threading

import anyio.to_thread
import pytest

from server.base.concurrency import SingleFlight
from tests.support.quick import in_a_loop


def test_a_work_is_done_once_for_all_who_wait_for_it() -> None:
    done: list[int] = []

    async def scene() -> list[int]:
        once, gate = SingleFlight(), threading.Event()

        def work() -> int:
            gate.wait()
            done.append(1)
            return len(done)

        waiting = [asyncio.create_task(once.run("a", work)) for _ in range(200)]
        await asyncio.sleep(0)
        assert anyio.to_thread.current_default_thread_limiter().borrowed_tokens == 0
        waiting.pop().cancel()  # who leaves does not end it for the others
        gate.set()
        results = await asyncio.gather(*waiting)
        return [*results, await once.run("a", work)]

    assert in_a_loop(scene()) == [1] * 199 + [2]


def test_a_failure_is_told_to_all_and_not_kept() -> None:
    async def scene() -> None:
        once = SingleFlight()
        tasks = [once.run("a", lambda: 1 // 0) for _ in range(3)]
        results = await asyncio.gather(*tasks, return_exceptions=True)
        assert [type(result) for result in results] == [ZeroDivisionError] * 3
        with pytest.raises(KeyError):
            await once.run("a", lambda: {}["b"])

    in_a_loop(scene())
