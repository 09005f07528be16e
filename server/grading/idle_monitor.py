"""When a worker has nothing to grade: what nobody waits for is done then, and takes no processor from who waits."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event

#: Seconds without a job after which one is calm, and between two looks at it.
IDLE_AFTER, LOOK = 0.5, 0.05


class IdleMonitor:
    """Of one worker, which does one job at a time; `wait` is for its other threads."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._busy, self._ended = False, -IDLE_AFTER

    @contextmanager
    def busy(self) -> Iterator[None]:
        """While a job is done."""
        self._busy = True
        try:
            yield
        finally:
            self._ended, self._busy = self._clock(), False

    @property
    def is_idle(self) -> bool:
        return not self._busy and self._clock() - self._ended >= IDLE_AFTER

    def wait_idle(self, stopping: Event) -> bool:
        """Until it is calm; False where it is to stop first."""
        while not self.is_idle:
            if stopping.wait(LOOK):
                return False
        return not stopping.is_set()
