"""How a worker that is told to end does so: at once where nothing is half done, else as soon as it is whole.

A transaction is never cut: a job whose claim is committed, and which its worker does not know of yet, would wait for
the end of its lease.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class StopRequested(BaseException):
    """Raised in a worker that is asked to end (SIGTERM); what it was doing goes back to the queue."""


class GracefulStop:
    """Told by a signal's handler, in the main thread; asked by it too. Others may wait for `told`."""

    def __init__(self) -> None:
        self.requested = threading.Event()
        self._held = False

    def request(self) -> None:
        """Raises Stop, unless it is held: then `check` or `open` will."""
        self.requested.set()
        if not self._held:
            raise StopRequested

    def raise_if_requested(self) -> None:
        """Raises Stop once it was told."""
        if self.requested.is_set():
            raise StopRequested

    @contextmanager
    def deferred(self) -> Iterator[None]:
        """Nothing is cut in here, but for what stands in `open`."""
        self._held = True
        try:
            yield
        finally:
            self._held = False

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """What may be cut at any point, within `held`."""
        held, self._held = self._held, False
        try:
            self.raise_if_requested()
            yield
        finally:
            self._held = held
