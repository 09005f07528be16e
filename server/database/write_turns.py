"""The write lock of a SQLite file, taken in turn by the threads of a process.

SQLite asks for a held lock again and again, at pauses that grow to a tenth of a second, so that who has waited longest
asks least often: of twenty threads that write without end, one was overtaken a thousand times, and waited nine seconds
where half of them waited one millisecond. Here the first of the process alone asks, often; the others wait behind it.
"""

import sqlite3
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Self

BUSY_TIMEOUT_SECONDS = 15.0
BUSY_TIMEOUT = f"busy_timeout={BUSY_TIMEOUT_SECONDS * 1000:.0f}"
BEGIN_AND_LOCK = "BEGIN IMMEDIATE"
#: Pauses between two attempts of the first: doubled up to the longest.
FIRST_PAUSE, LONGEST_PAUSE = 0.0005, 0.004


class FairLock:
    """A lock that is granted in the order in which it was asked for. A context manager."""

    def __init__(self) -> None:
        self._mutex = threading.Lock()
        self._waiting: deque[threading.Lock] = deque()
        self.is_taken = False

    @property
    def waiting(self) -> int:
        """The number of threads that wait behind the first."""
        return len(self._waiting)

    def __enter__(self) -> Self:
        with self._mutex:
            if not self.is_taken:
                self.is_taken = True
                return self
            gate = threading.Lock()
            gate.acquire()
            self._waiting.append(gate)
        try:
            gate.acquire()
        except BaseException:  # a signal in the main thread
            self._leave_queue(gate)
            raise
        return self

    def __exit__(self, *_exc: object) -> None:
        with self._mutex:
            self._wake_next_thread()

    def _leave_queue(self, gate: threading.Lock) -> None:
        with self._mutex:
            if gate in self._waiting:
                self._waiting.remove(gate)
            else:  # it was granted meanwhile
                self._wake_next_thread()

    def _wake_next_thread(self) -> None:
        if self._waiting:
            self._waiting.popleft().release()
        else:
            self.is_taken = False


def begin_in_turn(turnstile: FairLock, connection: sqlite3.Connection, begin: Callable[[], object]) -> None:
    """Begin a transaction with the write lock.

    `begin` does the same through SQLAlchemy: it raises the error where another process holds the lock for
    BUSY_TIMEOUT_SECONDS, and any other error.
    """
    deadline, pause = time.monotonic() + BUSY_TIMEOUT_SECONDS, FIRST_PAUSE
    with turnstile:
        connection.execute("PRAGMA busy_timeout=0")
        try:
            while not _try_to_begin(connection, deadline):
                time.sleep(pause)
                pause = min(2 * pause, LONGEST_PAUSE)
            if not connection.in_transaction:
                begin()
        finally:
            connection.execute(f"PRAGMA {BUSY_TIMEOUT}")


def _try_to_begin(connection: sqlite3.Connection, deadline: float) -> bool:
    """Try to begin; False where it is worth another try."""
    try:
        connection.execute(BEGIN_AND_LOCK)
    except sqlite3.OperationalError as error:
        return error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() > deadline
    return True
