"""Idle times of a worker: background work runs then, and takes no processor time from gradings."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Lock

#: Seconds without a job after which a worker is idle, and between two checks.
IDLE_SECONDS, CHECK_SECONDS = 0.5, 0.05


class WorkerIdleMonitor:
    """Tracks one worker, whose threads each run one job at a time; `wait_until_idle` is for its other threads."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock, self._running, self._last_job_end = Lock(), 0, -IDLE_SECONDS

    @contextmanager
    def mark_busy(self) -> Iterator[None]:
        """Mark a job as running for the duration of the block."""
        with self._lock:
            self._running += 1
        try:
            yield
        finally:
            with self._lock:
                self._running -= 1
                self._last_job_end = self._clock()

    @property
    def is_idle(self) -> bool:
        return not self._running and self._clock() - self._last_job_end >= IDLE_SECONDS

    def wait_until_idle(self, stopping: Event) -> bool:
        """Wait until the worker is idle; False where it is to stop first."""
        while not self.is_idle:
            if stopping.wait(CHECK_SECONDS):
                return False
        return not stopping.is_set()
