"""What must be known before a student's code runs, while the service answers all else already."""

import asyncio
from concurrent.futures import Future


class ShutError(Exception):
    """The service stops: nobody passes any more."""


class Gate:
    """Opened, or shut for good, from any thread; loops wait at it."""

    def __init__(self, *, opened: bool = False) -> None:
        self._future: Future[None] = Future()
        if opened:
            self.open()

    @property
    def is_open(self) -> bool:
        return self._future.done() and self._future.exception() is None

    def open(self) -> None:
        if not self._future.done():
            self._future.set_result(None)

    def shut(self) -> None:
        """Who waits gets ShutError; who has passed is not concerned."""
        if not self._future.done():
            self._future.set_exception(ShutError())

    async def passed(self) -> None:
        """Raises ShutError."""
        if not self.is_open:
            await asyncio.shield(asyncio.wrap_future(self._future))
