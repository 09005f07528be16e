"""Nobody passes before the gate is opened, and nobody waits for ever at one that is shut."""

from __future__ import annotations

import asyncio
from threading import Thread

import pytest

from server.base.concurrency import Gate, GateClosed
from tests.support.quick import in_a_loop


def test_who_waits_passes_once_it_is_opened_from_another_thread() -> None:
    async def scene() -> None:
        gate = Gate()
        waiting = [asyncio.create_task(gate.wait_open()) for _ in range(2)]
        given_up = asyncio.create_task(gate.wait_open())
        await asyncio.sleep(0)
        given_up.cancel()
        await asyncio.sleep(0)
        assert not gate.is_open
        assert not any(one.done() for one in waiting)
        Thread(target=gate.open).start()
        await asyncio.gather(*waiting)
        gate.close()
        assert gate.is_open, "who has passed is not concerned"
        await gate.wait_open()

    in_a_loop(scene())


def test_who_waits_at_a_shut_gate_is_told() -> None:
    async def scene() -> None:
        gate = Gate()
        waiting = asyncio.create_task(gate.wait_open())
        await asyncio.sleep(0)
        gate.close()
        with pytest.raises(GateClosed):
            await waiting
        gate.open()
        assert not gate.is_open

    in_a_loop(scene())
