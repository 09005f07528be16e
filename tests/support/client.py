"""Starlette's client of an application in this process, for which a request crosses from thread to thread once.

Starlette's own, which can stream, crosses nine times to hand over an answer piece by piece, and starts a thread and a
loop for each request of a client that was not entered: half of what a page costs. Here a request that is not streamed
runs from end to end in the loop of the client that serves the application, or, where none does, in one loop that this
process keeps for all.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from functools import cache
from typing import Any, Self
from urllib.parse import unquote

import anyio
import httpx2 as httpx
from anyio.from_thread import BlockingPortal
from starlette import testclient
from starlette.types import Message

#: The portal of the client that was entered, by the application that it serves.
_SERVING: dict[int, BlockingPortal] = {}
STREAMED = "streamed"


class TestClient(testclient.TestClient):
    """The same, quicker."""

    __test__ = False

    def __init__(self, app: Any, **options: Any) -> None:
        super().__init__(app, **options)
        self._transport = _Whole(self, self._transport)

    @contextmanager
    def _portal_factory(self) -> Iterator[BlockingPortal]:  # type: ignore[override]
        yield self.portal or _SERVING.get(id(self.app)) or _aside()

    def __enter__(self) -> Self:
        entered = super().__enter__()
        assert self.portal is not None
        _SERVING[id(self.app)] = self.portal
        return entered

    def __exit__(self, *args: object) -> None:
        del _SERVING[id(self.app)]
        super().__exit__(*args)

    def send(self, request: httpx.Request, *, stream: bool = False, **options: Any) -> httpx.Response:
        request.extensions = {**request.extensions, STREAMED: stream}
        return super().send(request, stream=stream, **options)


class _Whole(httpx.BaseTransport):
    """Hands over whole answers; what is streamed goes the other way."""

    def __init__(self, owner: TestClient, other: Any) -> None:
        self._owner, self._other = owner, other
        self._raising: bool = other.raise_server_exceptions

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        if request.extensions.get(STREAMED, True):
            return self._other.handle_request(request)
        body = request.read()
        with self._owner._portal_factory() as portal:
            sent = portal.call(self._answered, self._scope(request), body)
        started = next((message for message in sent if message["type"] == "http.response.start"), None)
        if started is None:
            assert not self._raising, "the application has not answered"
            return httpx.Response(500, request=request)
        pieces = [message.get("body", b"") for message in sent if message["type"] == "http.response.body"]
        content = b"" if request.method == "HEAD" else b"".join(pieces)
        return httpx.Response(
            started["status"], headers=started["headers"], stream=httpx.ByteStream(content), request=request
        )

    async def _answered(self, scope: dict[str, Any], body: bytes) -> list[Message]:
        """What the application sends, until it has nothing left to do."""
        sent: list[Message] = []
        asked, complete = False, anyio.Event()

        async def receive() -> Message:
            nonlocal asked
            if asked:
                await complete.wait()
                return {"type": "http.disconnect"}
            asked = True
            return {"type": "http.request", "body": body}

        async def send(message: Message) -> None:
            assert not complete.is_set(), f"sent after the end: {message}"
            sent.append(message)
            if message["type"] == "http.response.body" and not message.get("more_body", False):
                complete.set()

        try:
            await self._owner.app(scope, receive, send)
        except Exception:
            if self._raising:
                raise
        return sent

    def _scope(self, request: httpx.Request) -> dict[str, Any]:
        url = request.url
        named = [] if "host" in request.headers else [(b"host", url.netloc)]
        return {
            "type": "http",
            "http_version": "1.1",
            "method": request.method,
            "path": unquote(url.path),
            "raw_path": url.raw_path.split(b"?", 1)[0],
            "root_path": self._other.root_path,
            "scheme": url.scheme,
            "query_string": url.query,
            "headers": named + [(name.lower(), value) for name, value in request.headers.raw],
            "client": self._other.client,
            "server": [url.raw_host.decode("ascii"), url.port or {"http": 80, "https": 443}[url.scheme]],
            "state": self._owner.app_state.copy(),
        }

    def close(self) -> None:
        self._other.close()


@cache
def _aside() -> BlockingPortal:
    """A loop in a thread that ends with this process."""
    ready: Future[BlockingPortal] = Future()

    async def serve() -> None:
        async with BlockingPortal() as portal:
            ready.set_result(portal)
            await portal.sleep_until_stopped()

    threading.Thread(target=anyio.run, args=(serve,), daemon=True, name="requests-of-tests").start()
    return ready.result()
