"""Password hashing off the event loop: Argon2 takes 0.1 s, four threads and 64 MiB, so few run at once, by address."""

import os
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from starlette.concurrency import run_in_threadpool

from server.base.concurrency import FairLimiter, LimiterFullError
from server.base.errors import Overloaded
from server.identity import secrets

THREADS_PER_HASH = 4
MAX_WAITING = 200  # a few classes at once; on two processors the last waits for some twenty seconds
T = TypeVar("T")
BUSY = "Beaucoup de monde se connecte en ce moment. Réessayez dans quelques secondes."


class PasswordHasher:
    """Hashes for one event loop, with fair queueing by address. Raises Overloaded where too many wait."""

    def __init__(self, at_once: int | None = None, waiting: int = MAX_WAITING) -> None:
        self._turns = FairLimiter(at_once or max(1, (os.cpu_count() or 1) // THREADS_PER_HASH), waiting)

    async def hash(self, password: str, *, address: str) -> str:
        return await self._in_turn(address, partial(secrets.hash_password, password))

    async def verify(self, password: str, stored: str | None, *, address: str) -> bool:
        """Verify a password in the same time whether the account exists (`stored` given) or not."""
        return await self._in_turn(address, partial(secrets.verify_password, password, stored))

    async def _in_turn(self, address: str, work: Callable[[], T]) -> T:
        try:
            await self._turns.acquire(address)
        except LimiterFullError:
            raise Overloaded(BUSY, retry_after=5) from None
        try:
            return await run_in_threadpool(work)
        finally:
            self._turns.release(address)
