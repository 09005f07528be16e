"""Password hashing off the event loop: Argon2 takes 0.1 s, four threads and 64 MiB, so few run at once, by address.

It gives way to pages, and goes before the passwords of strangers for those whom a browser or a link tells to be known.
Turns go round the addresses, and at an address round the logins that are tried from there.
"""

import asyncio
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TypeVar

from server.base.concurrency import FairLimiter, LimiterFullError
from server.base.errors import Overloaded
from server.base.turns import out_of_turn
from server.identity import secrets

THREADS_PER_HASH = 4
#: As helpers: a flood of passwords would take every processor from pages.
NICE = 5
#: Ranks of those who are known, of others, and of who names no account: wrong logins are endless, right ones are not.
#: While strangers keep the queue full, who waits less has named an account; the form of sign-ups tells as much.
KNOWN, UNKNOWN, NOBODY = 0, 1, 2
MAX_WAITING = 200  # a few classes at once; on two processors the last waits for some twenty seconds
T = TypeVar("T")
BUSY = "Beaucoup de monde se connecte en ce moment. Réessayez dans quelques secondes."


class PasswordHasher:
    """Hashes for one event loop, with fair queueing by address. Raises Overloaded where too many wait."""

    def __init__(self, at_once: int | None = None, waiting: int = MAX_WAITING) -> None:
        at_once = at_once or max(1, (os.cpu_count() or 1) // THREADS_PER_HASH)
        self._turns = FairLimiter(at_once, waiting, reserve=1)
        self._threads = ThreadPoolExecutor(
            at_once + 1, thread_name_prefix="password", initializer=_lower_thread_priority
        )

    async def hash(self, password: str, *, address: str, rank: int = UNKNOWN) -> str:
        return await self._run_in_turn(address, rank, "", partial(secrets.hash_password, password))

    async def verify(
        self, password: str, stored: str | None, *, address: str, rank: int = UNKNOWN, login: str = ""
    ) -> bool:
        """Verify a password in the same time whether the account exists (`stored` given) or not."""
        return await self._run_in_turn(address, rank, login, partial(secrets.verify_password, password, stored))

    async def _run_in_turn(self, address: str, rank: int, login: str, work: Callable[[], T]) -> T:
        async with out_of_turn():
            try:
                await self._turns.acquire(address, rank, login)
            except LimiterFullError:
                raise Overloaded(BUSY, retry_after=5) from None
            try:
                return await asyncio.get_running_loop().run_in_executor(self._threads, work)
            finally:
                self._turns.release(address, rank)


def _lower_thread_priority() -> None:
    """Lower the priority of this thread, which those that Argon2 starts have too."""
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), os.getpriority(os.PRIO_PROCESS, 0) + NICE)
