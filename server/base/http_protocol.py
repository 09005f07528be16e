"""uvicorn's protocol of HTTP/1.1, with bounds on what a connection makes the loop do that serves everybody.

h11 parses in Python, on the loop. Bytes are bounded elsewhere; here, their pieces: lines of a head, chunks of a body,
arrivals of a few bytes each. What is not parsed yet stays here, and h11 gets one whole head or the rest of one body.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Collection, Sequence
from functools import partial
from ipaddress import IPv4Network, IPv6Network, ip_address, ip_network
from typing import Any, cast

import h11
import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from server.base.admission import RequestAdmission
from server.base.http import visitor_key
from server.base.turns import CROWDED

#: Bytes of the line of a request with its headers.
MAX_HEAD_BYTES = 16 * 1024
#: Lines of a head. A browser sends some twenty, a proxy adds as many.
MAX_HEAD_LINES = 128
#: Seconds from a connection to its first byte, and from the first byte of a head to its end.
IDLE_SECONDS, HEAD_SECONDS = 300.0, 30.0
#: Arrivals of pieces of one request, after which the next are waited for together, so many seconds long.
FREE_ARRIVALS, GATHERING_SECONDS = 32, 0.02
#: Bytes of a body in chunks that are parsed at once; the least mean of bytes between its line ends.
CHUNKED_BYTES, MIN_CHUNK_BYTES = 16 * 1024, 64

#: New connections that one pass of the loop accepts, and those that the machine holds ready: asyncio has one number.
ACCEPTED_AT_ONCE, BACKLOG = 4, 2048
CROWDED_ANSWER = (
    b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 5\r\nConnection: close\r\n"
    b"Content-Type: text/plain; charset=utf-8\r\nContent-Length: %d\r\n\r\n%s"
    % (len(CROWDED.encode()), CROWDED.encode())
)
#: Of who has sent a whole request, with or without an offer to switch to another protocol.
_WAITS_FOR_ANSWER = frozenset({"DONE", "MIGHT_SWITCH_PROTOCOL"})
Network = IPv4Network | IPv6Network
#: Proxies one behind another that are looked through for an address.
MAX_PROXIES = 8
_FORWARDED = re.compile(rb"\nx-forwarded-for:([^\r\n]*)", re.IGNORECASE)
_END_OF_HEAD = re.compile(rb"\n\r?\n")


class BoundedProtocol(H11Protocol):
    """One connection."""

    def __init__(
        self,
        *arguments: Any,
        admission: RequestAdmission | None = None,
        proxies: Collection[Network] = (),
        **options: Any,
    ) -> None:
        super().__init__(*arguments, **options)
        self._proxies, self._address = proxies, ""
        self._admission, self._is_admitted, self._is_waiting = admission or RequestAdmission(), False, False
        self._unread, self._searched = bytearray(), 0
        self._body_left: int | None = 0
        self._arrivals = self._chunked_bytes = self._chunked_lines = 0
        self._is_over = False
        self._head_timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._start_head_timer(IDLE_SECONDS)

    def connection_lost(self, exc: Exception | None) -> None:
        self._stop_head_timer()
        self._unread.clear()
        self._is_over = True
        self._admission.note_request_ended(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        if not self._is_over:
            self._unread += data
            self._parse()
            if self._is_waiting and len(self._unread) > MAX_HEAD_BYTES:
                self.flow.pause_reading()
        self._arrivals += 1
        if self._arrivals > FREE_ARRIVALS:
            self.transport.pause_reading()
            self.loop.call_later(GATHERING_SECONDS, self._read_again)

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._admission.note_request_ended(self)
        if not self.transport.is_closing():
            self._parse()

    def _read_again(self) -> None:
        if not (self.flow.read_paused or self.transport.is_closing()):
            self.transport.resume_reading()

    def _parse(self) -> None:
        """Hand what has come to h11: a head once it is whole, a body as it comes, the next request after its answer."""
        while self._unread and not self._is_over:
            if self.conn.their_state is h11.IDLE:
                if self._is_waiting or not self._parse_head():
                    return
            elif self.conn.their_state is h11.SEND_BODY:
                if not self._parse_body():
                    return
            elif str(self.conn.their_state) in _WAITS_FOR_ANSWER:
                self.flow.pause_reading()
                return
            else:
                self._end()

    def _parse_head(self) -> bool:
        """Hand a whole head to h11, or what cannot become one; return False where more has to come."""
        found = _END_OF_HEAD.search(self._unread, max(0, self._searched - 2))
        if found is None and len(self._unread) <= MAX_HEAD_BYTES and self._unread[0] > ord(" "):
            if not self._searched:
                self._start_head_timer(HEAD_SECONDS)
            self._searched = len(self._unread)
            return False
        self._stop_head_timer()
        head = bytes(self._unread[: found.end()] if found else self._unread)
        if not self._is_admitted:
            self._address = sender_key(self.client[0] if self.client else "", head, self._proxies)
            if not self._admission.may_pass(head, self):
                self._is_waiting = True
                return False
        self._is_admitted = False
        del self._unread[: len(head)]
        self._searched = self._arrivals = 0
        if len(head) > MAX_HEAD_BYTES or head.count(b"\n") > MAX_HEAD_LINES:
            self.send_400_response("The request line and the headers are too long, or too many.")
            self._end()
            return True
        super().data_received(head)
        if self.conn.their_state is h11.SEND_BODY:
            self._body_left = _content_length(self.headers)
            self._chunked_bytes = self._chunked_lines = 0
        return True

    @property
    def address(self) -> str:
        return self._address

    @property
    def is_gone(self) -> bool:
        return self._is_over or self.transport.is_closing()

    def take_up(self) -> None:
        self._is_waiting, self._is_admitted = False, True
        self.flow.resume_reading()
        self._parse()

    def refuse(self) -> None:
        """Refuse a request that has waited with too many others, by an answer that costs nothing."""
        if not self.transport.is_closing():
            self.transport.write(CROWDED_ANSWER)
            self._end()
            self.transport.close()

    def _parse_body(self) -> bool:
        """Hand what has come of a body to h11; return False where the rest is handed over later, or never.

        Of a body in chunks, that is a little at a time: the application may refuse it meanwhile.
        """
        piece = bytes(self._unread[: CHUNKED_BYTES if self._body_left is None else self._body_left])
        del self._unread[: len(piece)]
        if self._body_left is not None:
            self._body_left -= len(piece)
            super().data_received(piece)
            return True
        self._chunked_bytes += len(piece)
        self._chunked_lines += piece.count(b"\n")
        if self._chunked_lines > max(MAX_HEAD_LINES, self._chunked_bytes / MIN_CHUNK_BYTES):
            self._end()
            self.transport.close()
            return False
        super().data_received(piece)
        if not self._unread:
            return True
        self.transport.pause_reading()
        self.loop.call_later(GATHERING_SECONDS, self._parse_again)
        return False

    def _parse_again(self) -> None:
        if not self.transport.is_closing():
            self._parse()
            self._read_again()

    def _end(self) -> None:
        """Take nothing more of this connection: what comes is thrown away until it is closed."""
        self._is_over = True
        self._unread.clear()

    def _start_head_timer(self, seconds: float) -> None:
        """Wait for a head so long and no longer; the bound of an idle connection ends as a head begins."""
        if self.timeout_keep_alive_task is not None:
            self.timeout_keep_alive_task.cancel()
            self.timeout_keep_alive_task = None
        self._stop_head_timer()
        self._head_timer = self.loop.call_later(seconds, self.transport.close)

    def _stop_head_timer(self) -> None:
        if self._head_timer is not None:
            self._head_timer.cancel()
            self._head_timer = None


def sender_key(peer: str, head: bytes, proxies: Collection[Network]) -> str:
    """Return the key of whoever sends a request: the peer, or whom the nearest trusted proxies name.

    Without this, all who come through a proxy would wait in one line, and a flood would stand before each of them.
    """
    if _is_in(peer, proxies):
        named = b",".join(_FORWARDED.findall(head)).rsplit(b",", MAX_PROXIES)[-MAX_PROXIES:]
        hosts = [name.strip().decode("latin-1") for name in named]
        peer = next((host for host in reversed(hosts) if host and not _is_in(host, proxies)), peer)
    return visitor_key(peer)


def _is_in(host: str, networks: Collection[Network]) -> bool:
    try:
        return bool(networks) and any(ip_address(host) in network for network in networks)
    except ValueError:
        return False


def _content_length(headers: list[tuple[bytes, bytes]]) -> int | None:
    """Return the length of a body, which h11 has checked; None for one in chunks."""
    if any(name == b"transfer-encoding" for name, _ in headers):
        return None
    return next(int(value) for name, value in headers if name == b"content-length")


def uvicorn_config(app: ASGIApp, *, grace: int, proxies: Sequence[str] = ()) -> uvicorn.Config:
    """Return the configuration of uvicorn. `grace` is the shutdown timeout in seconds, `proxies` are trusted proxies.

    Parser and loop are explicit. httptools parses the body of an upgrade request as the next request, and bounds
    nothing; uvloop starts no process in a group of its own, and leaks descriptors to child processes.
    """
    return uvicorn.Config(
        app,
        loop="asyncio",
        http=cast(
            type[asyncio.Protocol],
            partial(BoundedProtocol, admission=RequestAdmission(), proxies=[ip_network(proxy) for proxy in proxies]),
        ),
        backlog=ACCEPTED_AT_ONCE,
        h11_max_incomplete_event_size=MAX_HEAD_BYTES,
        ws="none",
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=grace,
        server_header=False,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=list(proxies),
    )
