"""The supervisor: a worker that ends is told and replaced, unless the server has been told to stop."""

from __future__ import annotations

import asyncio
import logging
import socket

import pytest

from server.base.concurrency import Gate
from server.base.settings import Settings
from server.grading.supervisor import WorkerSupervisor, WorkerWakeupSocket
from server.queue.lease_owner import LeaseOwner
from server.queue.wakeups import WakeupDispatcher
from tests.support.quick import in_a_loop

SLEEPS = ("sleep", "600")  # and as many more as its line's number and our own


@pytest.mark.parametrize("told", [True, False])
def test_a_worker_told_to_stop_with_its_server_is_not_replaced(
    told: bool, settings: Settings, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("server.grading.supervisor.QUICK_DEATH_SECONDS", 0.0)
    dead = list[int]()

    def bury(owner: LeaseOwner) -> None:
        dead.append(owner.pid)

    async def scene() -> None:
        supervisor = WorkerSupervisor(settings.model_copy(update={"workers": 1}), WakeupDispatcher(print), bury, SLEEPS)
        async with supervisor:
            first = await worker_besides(supervisor, None)
            if told:
                supervisor.stop_restarting_workers()
            first.terminate()
            if told:
                await asyncio.wait_for(asyncio.gather(*supervisor._tasks), 300)
            else:
                await worker_besides(supervisor, first)

    in_a_loop(scene())
    assert len(dead) == (1 if told else 2)
    errors = [record for record in caplog.records if record.levelno >= logging.ERROR]
    assert len(errors) == (0 if told else 1)


async def worker_besides(
    supervisor: WorkerSupervisor, other: asyncio.subprocess.Process | None
) -> asyncio.subprocess.Process:
    async with asyncio.timeout(20):
        while True:
            for running in supervisor._processes.values():
                if running.process is not other:
                    return running.process
            await asyncio.sleep(0.005)


def test_no_worker_starts_before_the_walls_are_known_to_stand(settings: Settings) -> None:
    async def scene() -> None:
        walls = Gate()
        wanted = settings.model_copy(update={"workers": 1})
        async with WorkerSupervisor(wanted, WakeupDispatcher(print), lambda _owner: None, SLEEPS, walls) as supervisor:
            await asyncio.sleep(0.01)
            assert supervisor.alive_worker_count() == 0
            walls.open()
            await worker_besides(supervisor, None)
            assert supervisor.alive_worker_count() == 1
        walls = Gate()
        async with WorkerSupervisor(wanted, WakeupDispatcher(print), lambda _owner: None, SLEEPS, walls) as supervisor:
            supervisor.stop_restarting_workers()
            walls.close()
        assert supervisor.alive_worker_count() == 0

    in_a_loop(scene())


def test_waking_a_worker_never_blocks_on_a_stuck_or_dead_one() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        wire = WorkerWakeupSocket(ours.dup())
        ours.setblocking(False)  # as the loop does, after which neither name of it waits
        wire.write(b"work\n")
        assert theirs.recv(100) == b"work\n"
        for _ in range(50):
            wire.write(b"work\n" * 10_000)
        theirs.close()
        wire.write(b"work\n")
        wire.close()
