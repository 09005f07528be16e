"""Downloads that take long to make: one piece of one of them is computed at a time, with pauses for everybody else.

The turn of a request ends as its answer begins, and what a stream computes after that was nobody's: eight archives of
the copies of a class at once took half a second of the processor each, beside pages of ten milliseconds.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Iterator, Mapping

from anyio import CapacityLimiter
from anyio.lowlevel import RunVar
from anyio.to_thread import run_sync
from starlette.responses import StreamingResponse

#: Seconds of a pause at most: what waits for the network makes nobody wait.
MAX_PAUSE = 0.05
_limiter: RunVar[CapacityLimiter] = RunVar("bulk")


class OneAtATimeStream(StreamingResponse):
    """Streams pieces, each of which a thread computes while no other download's is."""

    def __init__(self, pieces: Iterator[bytes] | Iterator[str], headers: Mapping[str, str], media_type: str) -> None:
        super().__init__(_pause_after_each_piece(pieces), headers=headers, media_type=media_type)


async def _pause_after_each_piece(pieces: Iterator[bytes] | Iterator[str]) -> AsyncIterator[bytes | str]:
    """Pause after each piece for as long as it took."""
    limiter = _limiter.get(None)
    if limiter is None:
        limiter = CapacityLimiter(1)
        _limiter.set(limiter)

    def compute() -> tuple[bytes | str | None, float]:
        began = time.perf_counter()
        return next(pieces, None), time.perf_counter() - began

    while True:
        piece, seconds = await run_sync(compute, limiter=limiter)
        if piece is None:
            return
        yield piece
        await asyncio.sleep(min(seconds, MAX_PAUSE))
