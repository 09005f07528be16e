"""Graceful stop of a worker: at once where nothing is half done, else after the current transaction.

A transaction is never interrupted: a job whose claim is committed but unknown to its worker would wait for its lease to
expire.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class StopRequested(BaseException):
    """Raised in a worker that is asked to stop (SIGTERM); its job goes back to the queue."""


class GracefulStop:
    """Requested and checked by a signal handler of the main thread; other threads may wait for `requested`."""

    def __init__(self) -> None:
        self.requested = threading.Event()
        self._deferred = False

    def request_stop(self) -> None:
        """Raise StopRequested, or let `raise_if_requested` or `allow_interruption` do so where it is deferred."""
        self.requested.set()
        if not self._deferred:
            raise StopRequested

    def raise_if_requested(self) -> None:
        """Raise StopRequested if a stop was requested."""
        if self.requested.is_set():
            raise StopRequested

    @contextmanager
    def defer_stop(self) -> Iterator[None]:
        """Defer a stop within this block, but for `allow_interruption` parts."""
        self._deferred = True
        try:
            yield
        finally:
            self._deferred = False

    @contextmanager
    def allow_interruption(self) -> Iterator[None]:
        """Mark a part of a `defer_stop` block that a stop may interrupt at any point."""
        was_deferred, self._deferred = self._deferred, False
        try:
            self.raise_if_requested()
            yield
        finally:
            self._deferred = was_deferred
