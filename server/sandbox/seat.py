"""The programs of one seat, which a worker can stop for a while, or end so that they are executed again later.

While they are stopped, their clock stands still: no limit of theirs passes, and their answers are those of a program
that was never stopped.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Protocol
from uuid import UUID

_current: ContextVar[SeatPrograms | None] = ContextVar("seat", default=None)


class Abandoned(BaseException):
    """Raised in the thread of a seat whose programs were ended by `SeatPrograms.abandon`: nothing is known of them."""


class StoppableProgram(Protocol):
    """A process of a seat."""

    def stop(self) -> None: ...

    def go_on(self) -> None: ...

    def kill(self) -> None: ...


class SeatPrograms:
    """The programs that one thread executes for one job at a time; `stop`, `go_on`, `abandon` are for other threads.

    These name the job that they mean: they do nothing once the seat has another one.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._job: UUID | None = None
        self._programs: set[StoppableProgram] = set()
        self._stopped_at: float | None = None
        self._stopped_seconds = 0.0
        self._abandoned = False

    def stopped_seconds(self, job: UUID) -> float:
        """Return the seconds for which the programs of the job have been stopped since they last went on."""
        with self._lock:
            stopped_at = self._stopped_at
            return 0.0 if stopped_at is None or self._job != job else time.monotonic() - stopped_at

    def clock_without_stops(self) -> float:
        """Return the seconds of `time.monotonic`, without those for which the programs were stopped."""
        stopped_at = self._stopped_at
        return (time.monotonic() if stopped_at is None else stopped_at) - self._stopped_seconds

    @contextmanager
    def running(self, job: UUID) -> Iterator[None]:
        """Execute the programs that this thread starts within the block as those of this job."""
        with self._lock:
            self._job, self._abandoned = job, False
        token = _current.set(self)
        try:
            yield
        finally:
            _current.reset(token)
            with self._lock:
                self._job = None
                self._go_on()

    def stop(self, job: UUID) -> None:
        """Stop the programs of the job, and those that it starts from now on."""
        with self._lock:
            if self._job == job and self._stopped_at is None:
                self._stopped_at = time.monotonic()
                for program in self._programs:
                    program.stop()

    def go_on(self, job: UUID) -> None:
        """Let the stopped programs of the job go on."""
        with self._lock:
            if self._job == job:
                self._go_on()

    def _go_on(self) -> None:
        if self._stopped_at is not None:
            self._stopped_seconds += time.monotonic() - self._stopped_at
            self._stopped_at = None
            for program in self._programs:
                program.go_on()

    def abandon(self, job: UUID) -> None:
        """End the programs of the job; its thread gets Abandoned as it next waits for one, or starts one."""
        with self._lock:
            if self._job == job:
                self._abandoned = True
                for program in self._programs:
                    program.kill()

    def raise_if_abandoned(self) -> None:
        """Raise Abandoned once the programs were abandoned."""
        if self._abandoned:
            raise Abandoned

    def add(self, program: StoppableProgram) -> None:
        """Count a process among the programs. Raises Abandoned."""
        with self._lock:
            self.raise_if_abandoned()
            self._programs.add(program)
            if self._stopped_at is not None:
                program.stop()

    def remove(self, program: StoppableProgram) -> None:
        """Stop counting a process, which may be counted no longer."""
        with self._lock:
            self._programs.discard(program)


def seat_clock() -> Callable[[], float]:
    """Return the clock of the programs that this thread executes: that of its seat, else `time.monotonic`."""
    seat = current_seat()
    return time.monotonic if seat is None else seat.clock_without_stops


def current_seat() -> SeatPrograms | None:
    """Return the seat whose job this thread does, if any."""
    return _current.get()
