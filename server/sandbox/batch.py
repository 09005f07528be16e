"""Questions sent ahead: calls of one function that go to the program in one frame, and whose answers come one by one.

The program takes a batch in whole before it answers anything, so that the two ends of the wire never wait for each
other to read; the next batch goes only when the last answer of this one is there.
"""

from __future__ import annotations

import secrets
from collections import deque
from collections.abc import Iterable, Iterator

from server.sandbox.child import codec, frames
from server.sandbox.child.codec import Value

#: A batch is closed by the call that brings it to so many bytes, or calls.
_BYTES, _CALLS = 1 << 18, 128


class Batch:
    """What is asked, and which answers are still to come: a token and a number of arguments for each.

    It is `dropped` when some of its answers were given to nobody.
    """

    def __init__(self, function: str, *, return_arguments: bool) -> None:
        self.token = secrets.randbits(64)
        self._function, self._return_arguments = function, return_arguments
        self._asked = bytearray()
        self._waiting: deque[tuple[int, int | None]] = deque()
        self._faults = 0
        self.dropped = False

    def add(self, arguments: tuple[Value, ...]) -> bool:
        """Adds a call; True when the batch should hold no more."""
        token = secrets.randbits(64)
        self._asked += frames.framed(token, frames.ARGUMENTS, codec.encode(arguments, frames.QUESTION_LIMITS))
        self._waiting.append((token, len(arguments) if self._return_arguments else None))
        return len(self._asked) >= _BYTES or len(self._waiting) >= _CALLS

    def payload(self, wall: float, faults: int) -> bytes:
        """The frame's content; the program stops by itself after so many faults."""
        self._faults = faults
        shared: dict[str, Value] = {
            "function": self._function,
            "return_arguments": self._return_arguments,
            "calls": len(self._waiting),
            "faults": faults,
            "wall": wall,
        }
        return frames.framed(self.token, frames.CALLS, codec.encode(shared, frames.QUESTION_LIMITS)) + self._asked

    @property
    def waits(self) -> bool:
        """Are there answers to come?"""
        return bool(self._waiting) and self._faults > 0

    def next(self) -> tuple[int, int | None]:
        """Token of the next answer, and how many arguments must come back with it (None: they were not asked for)."""
        return self._waiting.popleft()

    def fault(self) -> None:
        """The answer that has come is a fault."""
        self._faults -= 1


def batches(function: str, calls: Iterable[tuple[Value, ...]], *, return_arguments: bool) -> Iterator[Batch]:
    """The calls by batches; they are drawn no further ahead than the batch that is made."""
    batch, empty = Batch(function, return_arguments=return_arguments), True
    for arguments in calls:
        full, empty = batch.add(arguments), False
        if full:
            yield batch
            batch, empty = Batch(function, return_arguments=return_arguments), True
    if not empty:
        yield batch
