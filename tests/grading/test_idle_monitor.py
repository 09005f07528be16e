"""What nobody waits for is done while nothing is graded."""

from __future__ import annotations

from threading import Event

import pytest

from server.grading.idle_monitor import IDLE_SECONDS, WorkerIdleMonitor


class Clock:
    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


class Stopping(Event):
    """Passes a look's time on the clock, instead of waiting; `told` after so many."""

    def __init__(self, clock: Clock, looks: int) -> None:
        super().__init__()
        self.clock, self.looks = clock, looks

    def wait(self, timeout: float | None = None) -> bool:
        assert timeout is not None
        self.clock.now += timeout
        self.looks -= 1
        if not self.looks:
            self.set()
        return self.is_set()


def test_a_worker_is_calm_from_the_start_and_a_while_after_a_job() -> None:
    clock = Clock()
    calm = WorkerIdleMonitor(clock)
    assert calm.is_idle
    with calm.mark_busy():
        clock.now += 60
        assert not calm.is_idle, "however long it takes"
    assert not calm.is_idle, "another may follow"
    clock.now += IDLE_SECONDS
    assert calm.is_idle


def test_a_job_that_fails_is_over_too() -> None:
    clock = Clock()
    calm = WorkerIdleMonitor(clock)
    with pytest.raises(ValueError, match="no"), calm.mark_busy():
        raise ValueError("no")
    clock.now += IDLE_SECONDS
    assert calm.is_idle


def test_what_waits_for_calm_goes_on_after_the_job_or_leaves_with_the_worker() -> None:
    clock = Clock()
    calm = WorkerIdleMonitor(clock)
    with calm.mark_busy():
        assert not calm.wait_until_idle(Stopping(clock, 3)), "it is to stop"
    assert calm.wait_until_idle(Stopping(clock, 1000))
    assert calm.is_idle
    told = Event()
    told.set()
    assert not calm.wait_until_idle(told)
