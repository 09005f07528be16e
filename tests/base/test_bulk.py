"""Downloads are computed a piece at a time, whoever asks for how many."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Iterator

from starlette.types import Message

from server.base.bulk import OneAtATimeStream
from tests.support.quick import in_a_loop

PIECES = [b"a", b"", b"bc", b"d"]


def test_one_piece_of_all_downloads_is_computed_at_a_time() -> None:
    busy, most, lock = 0, 0, threading.Lock()

    def pieces() -> Iterator[bytes]:
        nonlocal busy, most
        for piece in PIECES:
            with lock:
                busy += 1
                most = max(most, busy)
            time.sleep(0.001)  # long enough for another to begin
            with lock:
                busy -= 1
            yield piece

    async def download() -> bytes:
        sent = list[Message]()

        async def receive() -> Message:
            await asyncio.Event().wait()
            raise AssertionError

        async def send(message: Message) -> None:
            sent.append(message)

        scope = {"type": "http", "method": "GET", "path": "/", "headers": [], "asgi": {"spec_version": "2.4"}}
        await OneAtATimeStream(pieces(), {}, "application/zip")(scope, receive, send)
        return b"".join(message.get("body", b"") for message in sent)

    async def download_all() -> list[bytes]:
        return await asyncio.gather(*(download() for _ in range(6)))

    assert in_a_loop(download_all()) == [b"abcd"] * 6
    assert most == 1
