"""How a worker that is told to end does so: at once where nothing is half done, else as soon as it is whole.

A transaction is never cut: a job whose claim is committed, and which its worker does not know of yet, would wait for
the end of its lease.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Stop(BaseException):
    """Raised in a worker that is asked to end (SIGTERM); what it was doing goes back to the queue."""


class Stopping:
    """Told by a signal's handler, in the main thread; asked by it too. Others may wait for `told`."""

    def __init__(self) -> None:
        self.told = threading.Event()
        self._held = False

    def tell(self) -> None:
        """Raises Stop, unless it is held: then `check` or `open` will."""
        self.told.set()
        if not self._held:
            raise Stop

    def check(self) -> None:
        """Raises Stop once it was told."""
        if self.told.is_set():
            raise Stop

    @contextmanager
    def held(self) -> Iterator[None]:
        """Nothing is cut in here, but for what stands in `open`."""
        self._held = True
        try:
            yield
        finally:
            self._held = False

    @contextmanager
    def open(self) -> Iterator[None]:
        """What may be cut at any point, within `held`."""
        held, self._held = self._held, False
        try:
            self.check()
            yield
        finally:
            self._held = held
