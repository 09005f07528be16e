"""HTTP as this service reads it: by llhttp (of httptools), which is faster than what is written in Python, and bounded
here, for it keeps whatever it is sent."""

from __future__ import annotations

from collections.abc import Sequence

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

#: Bytes of a request without its body; and of what comes without anything of a body, or a request, being ended by it.
HEAD = 64 * 1024
#: Requests that may wait on one connection for the answers to those before them.
PIPELINED = 16


class RefusedError(Exception):
    """What was sent is no request of ours: it is answered by 400, and the connection closed."""


class Bounded(HttpToolsProtocol):
    """What uvicorn reads by httptools, within bounds; and as HTTP/1.1 asks, one `Host`, and no header after a body:
    whoever looks at headers before us, as a proxy does, has not seen it."""

    _pending = _head = 0
    _begun = False

    def data_received(self, data: bytes) -> None:
        self._pending += len(data)
        super().data_received(data)
        if self._pending > HEAD and not self.transport.is_closing():
            self.send_400_response("Invalid HTTP request received.")

    def on_message_begin(self) -> None:
        self._head, self._begun = 0, False
        super().on_message_begin()

    def on_url(self, url: bytes) -> None:
        self._count(len(url))
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        self._count(len(name) + len(value))
        if not self._begun:
            super().on_header(name, value)

    def _count(self, size: int) -> None:
        self._head += size
        if self._head > HEAD:
            raise RefusedError("its head is too long")

    def on_headers_complete(self) -> None:
        self._pending, self._begun = 0, True
        hosts = sum(name == b"host" for name, _ in self.headers)
        if hosts > 1 or (not hosts and self.parser.get_http_version() == "1.1"):
            raise RefusedError("one host is asked for")
        if len(self.pipeline) >= PIPELINED:
            raise RefusedError("too many requests at once")
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        self._pending = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        self._pending = 0
        super().on_message_complete()


def configuration(app: ASGIApp, *, grace: int, proxies: Sequence[str] = ()) -> uvicorn.Config:
    """How the application is served. `grace`: seconds left to open connections when it stops; `proxies`: whose word is
    taken for where a request comes from.

    The loop is asyncio's own, whatever is installed: that of uvloop starts no process in a group of its own, and leaves
    those that it starts descriptors which are not theirs.
    """
    return uvicorn.Config(
        app,
        loop="asyncio",
        http=Bounded,
        ws="none",
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=grace,
        server_header=False,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=list(proxies),
    )
