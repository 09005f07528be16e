"""What is sent as HTTP: what is read of it, what is refused, and that nobody has more kept than is bounded."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
from collections.abc import Iterator
from typing import Any

import h11
import pytest
import uvicorn

from server.base import http_protocol

HOST = b"Host: x\r\n"
REFUSED = b"HTTP/1.1 400 "
PATIENCE = 300.0  # seconds, against hanging alone: each wait ends by what it waits for


class Told:
    """An application that answers with what it was asked, and knows what it has seen."""

    def __init__(self) -> None:
        self.begun: list[str] = []
        self.bodies: list[bytes] = []
        self.left = threading.Event()

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            return
        self.begun.append(scope["path"])
        if scope["path"] == "/stream":
            return await self._stream(receive, send)
        body, more = b"", True
        while more:
            message = await receive()
            if message["type"] == "http.disconnect":
                return
            body, more = body + message.get("body", b""), message.get("more_body", False)
        self.bodies.append(body)
        headers = [[name.decode(), value.decode()] for name, value in scope["headers"]]
        told = json.dumps({"path": scope["path"], "headers": headers, "body": len(body)}).encode()
        lines = [(b"content-length", b"%d" % len(told))]
        await send({"type": "http.response.start", "status": 200, "headers": lines})
        await send({"type": "http.response.body", "body": told})

    async def _stream(self, receive: Any, send: Any) -> None:
        await receive()
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"a", "more_body": True})
        assert (await receive())["type"] == "http.disconnect"
        self.left.set()


class Site:
    def __init__(self, port: int, told: Told, loop: asyncio.AbstractEventLoop) -> None:
        self.port, self.told, self.loop = port, told, loop

    def line(self) -> socket.socket:
        return socket.create_connection(("127.0.0.1", self.port), PATIENCE)

    def answer(self, *pieces: bytes) -> bytes:
        """All that comes until the connection is closed."""
        with self.line() as line:
            for piece in pieces:
                line.sendall(piece)
            return received(line)

    def flood(self, begin: bytes, again: bytes, most: int = 4_000_000) -> tuple[bytes, int]:
        """What comes for `begin` and then the same `again` and again; how much of it could be sent."""
        sent = 0
        with self.line() as line:
            try:
                line.sendall(begin)
                while sent < most:
                    line.sendall(again)
                    sent += len(again)
            except ConnectionError:
                pass
            return received(line), sent


def received(line: socket.socket) -> bytes:
    found = b""
    try:
        while piece := line.recv(65536):
            found += piece
    except ConnectionError:
        pass
    return found


def until(line: socket.socket, end: bytes) -> bytes:
    found = b""
    while not found.endswith(end):
        piece = line.recv(65536)
        assert piece, "the connection is closed"
        found += piece
    return found


@pytest.fixture(scope="module")
def running() -> Iterator[Site]:
    told, ready = Told(), threading.Event()
    listener = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(http_protocol.uvicorn_config(told, grace=1))
    found: list[asyncio.AbstractEventLoop] = []
    startup = server.startup

    async def started(sockets: list[socket.socket] | None = None) -> None:
        await startup(sockets)
        found.append(asyncio.get_running_loop())
        ready.set()

    server.startup = started  # type: ignore[method-assign]
    thread = threading.Thread(target=server.run, args=([listener],))
    thread.start()
    assert ready.wait(PATIENCE)
    yield Site(listener.getsockname()[1], told, found[0])
    server.should_exit = True
    thread.join()


@pytest.fixture
def site(running: Site) -> Site:
    running.told.begun.clear()
    running.told.bodies.clear()
    running.told.left.clear()
    return running


def bodies(answer: bytes) -> list[Any]:
    return [json.loads(part.partition(b"\r\n\r\n")[2]) for part in answer.split(b"HTTP/1.1 200 OK\r\n")[1:]]


def test_the_loop_is_asyncio_s_own_whatever_is_installed(site: Site) -> None:
    assert type(site.loop).__module__.startswith("asyncio."), "another starts helpers otherwise"


def test_requests_are_answered_in_their_order_on_one_connection(site: Site) -> None:
    first = b"GET /a?q=1 HTTP/1.1\r\n" + HOST + b"\r\n"
    second = b"POST /b HTTP/1.1\r\n" + HOST + b"Content-Length: 3\r\n\r\nabc"
    last = b"GET /c HTTP/1.1\r\n" + HOST + b"Connection: close\r\n\r\n"
    told = bodies(site.answer(first + second + last))
    assert [(one["path"], one["body"]) for one in told] == [("/a", 0), ("/b", 3), ("/c", 0)]
    with site.line() as line:
        for path in (b"/d", b"/e"):
            line.sendall(b"GET " + path + b" HTTP/1.1\r\n" + HOST + b"\r\n")
            assert path in until(line, b"}")


@pytest.mark.parametrize("size", [10, 100_000, 3_000_000])
def test_a_body_comes_whole_whatever_pieces_it_is_sent_in(site: Site, size: int) -> None:
    head = b"POST /b HTTP/1.1\r\n" + HOST + b"Connection: close\r\n"
    body = bytes(range(256)) * (size // 256 + 1)
    counted = site.answer(head + b"Content-Length: %d\r\n\r\n" % len(body), body)
    pieces = [body[at : at + 7777] for at in range(0, len(body), 7777)]
    chunks = b"".join(b"%x\r\n%s\r\n" % (len(piece), piece) for piece in pieces)
    chunked = site.answer(head + b"Transfer-Encoding: chunked\r\n\r\n", chunks, b"0\r\n\r\n")
    assert [one["body"] for one in bodies(counted + chunked)] == [len(body)] * 2
    assert site.told.bodies == [body, body]


def test_who_asks_first_whether_to_send_is_told_to(site: Site) -> None:
    with site.line() as line:
        line.sendall(b"POST /b HTTP/1.1\r\n" + HOST + b"Content-Length: 3\r\nExpect: 100-continue\r\n\r\n")
        assert line.recv(65536) == b"HTTP/1.1 100 Continue\r\n\r\n"
        line.sendall(b"abc")
        assert b'"body": 3' in until(line, b"}")


def test_who_leaves_a_stream_is_missed(site: Site) -> None:
    with site.line() as line:
        line.sendall(b"GET /stream HTTP/1.1\r\n" + HOST + b"\r\n")
        assert b"200" in line.recv(65536)
    assert site.told.left.wait(PATIENCE)


@pytest.mark.parametrize(
    ("begin", "again"),
    [
        (b"GET / HTTP/1.1\r\n" + HOST, b"X-More: " + b"y" * 1000 + b"\r\n"),
        (b"GET / HTTP/1.1\r\n" + HOST, b"a:\r\n" * 200),
        (b"GET / HTTP/1.1\r\n" + HOST + b"X-More: ", b"y" * 1000),
        (b"GET / HTTP/1.1\r\n" + HOST, b"y" * 1000),
        (b"GET /", b"y" * 1000),
        (b"POST / HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n3;", b"y" * 1000),
        (b"POST / HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n0\r\n", b"a: " + b"y" * 1000 + b"\r\n"),
    ],
    ids=["headers", "empty headers", "one header", "one name", "address", "extension", "trailers"],
)
def test_what_never_ends_is_refused_before_much_of_it_is_kept(site: Site, begin: bytes, again: bytes) -> None:
    answer, sent = site.flood(begin, again * (20_000 // len(again)))
    assert not answer or REFUSED in answer, "what is sent meanwhile may cost who floods the answer"
    assert sent < 4_000_000
    assert not any(site.told.bodies)


def test_the_longest_head_is_read(site: Site) -> None:
    head = b"GET / HTTP/1.1\r\n" + HOST + b"Connection: close\r\n%s\r\n"
    line = b"X-More: " + b"y" * 992 + b"\r\n"
    assert len(line) * 15 < http_protocol.MAX_HEAD_BYTES
    assert bodies(site.answer(head % (line * 15)))[0]["path"] == "/"


@pytest.mark.parametrize(
    "request_",
    [
        b"POST / HTTP/1.1\r\n" + HOST + b"Content-Length: 3\r\nContent-Length: 4\r\n\r\nabcd",
        b"POST / HTTP/1.1\r\n" + HOST + b"Content-Length: +3\r\n\r\nabc",
        b"POST / HTTP/1.1\r\n" + HOST + b"Content-Length: 99999999999999999999999\r\n\r\nabc",
        b"POST / HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: identity\r\n\r\nabc",
        b"POST / HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked, identity\r\n\r\n0\r\n\r\n",
        b"GET / HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + HOST + b"Host: y\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + HOST + b"Bad name: y\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + HOST + b"Name : y\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + HOST + b"A: y\0z\r\n\r\n",
        b"GET /\xc3\xa9 HTTP/1.1\r\n" + HOST + b"\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc",
    ],
)
def test_what_may_be_read_in_two_ways_is_refused_and_the_connection_closed(site: Site, request_: bytes) -> None:
    answer = site.answer(request_ + b"GET /smuggled HTTP/1.1\r\n" + HOST + b"\r\n")
    assert answer.startswith(REFUSED)
    assert answer.count(b"HTTP/1.1 ") == 1
    assert "/smuggled" not in site.told.begun
    assert not site.told.bodies


def test_the_body_of_who_would_speak_another_protocol_is_no_request(site: Site) -> None:
    """Some clients offer HTTP/2 with each request: their bodies are read as they are."""
    body = b"GET /smuggled HTTP/1.1\r\n" + HOST + b"X-Forwarded-For: 6.6.6.6\r\n\r\n"
    asked = b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: AAMAAABkAAQAAP__\r\n"
    with site.line() as line:
        line.sendall(b"POST /b HTTP/1.1\r\n" + HOST + asked + b"Content-Length: %d\r\n\r\n" % len(body))
        line.sendall(body)
        assert b'"path": "/b"' in until(line, b"}")
        line.sendall(b"GET /c HTTP/1.1\r\n" + HOST + b"\r\n")
        assert b'"path": "/c"' in until(line, b"}")
    assert site.told.bodies == [body, b""]


@pytest.mark.parametrize("chunks", [b"x\r\nabc\r\n0\r\n\r\n", b"3\r\nabcdef\r\n0\r\n\r\n", b"-3\r\nabc\r\n0\r\n\r\n"])
def test_a_body_in_bad_chunks_never_comes_whole(site: Site, chunks: bytes) -> None:
    head = b"POST / HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n"
    assert REFUSED in site.answer(head, chunks)
    assert not site.told.bodies


def test_what_comes_after_a_body_is_no_header(site: Site) -> None:
    head = b"POST / HTTP/1.1\r\n" + HOST + b"Connection: close\r\nTransfer-Encoding: chunked\r\n\r\n"
    answer = site.answer(head + b"3\r\nabc\r\n0\r\nX-Forwarded-For: 6.6.6.6\r\nAuthorization: other\r\n\r\n")
    told = bodies(answer)[0]
    assert told["body"] == 3
    assert [name for name, _ in told["headers"]] == ["host", "connection", "transfer-encoding"]


def test_another_protocol_is_not_spoken(site: Site) -> None:
    head = b"GET /a HTTP/1.1\r\n" + HOST + b"Connection: Upgrade\r\nUpgrade: websocket\r\n"
    key = b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    with site.line() as line:
        line.sendall(head + key)
        assert line.recv(65536).startswith(b"HTTP/1.1 200 ")


def answer_whole(site: Site, head: bytes) -> bytes:
    return site.answer(head + b"Connection: close\r\n\r\n")


@pytest.mark.parametrize(("lines", "served"), [(100, True), (http_protocol.MAX_HEAD_LINES, False)])
def test_the_lines_of_a_head_are_counted(site: Site, lines: int, served: bool) -> None:
    answer = answer_whole(site, b"GET / HTTP/1.1\r\n" + HOST + b"a:b\r\n" * lines)
    assert answer.startswith(b"HTTP/1.1 200 " if served else REFUSED)


def test_a_long_head_is_refused_though_it_comes_in_one_piece(site: Site) -> None:
    head = b"GET /?" + b"q&" * (http_protocol.MAX_HEAD_BYTES // 2) + b" HTTP/1.1\r\n" + HOST
    assert answer_whole(site, head).startswith(REFUSED)
    assert not site.told.begun


@pytest.mark.parametrize(
    "begin",
    [
        b"POST /b HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n",
        b"GET /a HTTP/1.1\r\n" + HOST + b"\r\nPOST /b HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n",
    ],
    ids=["alone", "behind another request"],
)
def test_crumbs_of_a_body_are_not_parsed_one_by_one(site: Site, begin: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    parsed, next_event = list[int](), h11.Connection.next_event

    def count(connection: h11.Connection) -> Any:
        parsed.append(1)
        return next_event(connection)

    monkeypatch.setattr(h11.Connection, "next_event", count)
    _, sent = site.flood(begin, b"1\r\na\r\n" * 1000, 600_000)
    assert len(parsed) < 3 * http_protocol.MAX_HEAD_LINES, f"{sent} bytes were sent"
    assert not any(site.told.bodies)


def test_a_request_may_come_byte_by_byte_and_another_with_its_end(site: Site) -> None:
    request = b"POST /b HTTP/1.1\r\n" + HOST + b"Content-Length: 90\r\n\r\n" + b"x" * 90
    last = b"GET /c HTTP/1.1\r\n" + HOST + b"Connection: close\r\n\r\n"
    with site.line() as line:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in request[:-1]:
            line.sendall(bytes([byte]))
        line.sendall(request[-1:] + last)
        told = bodies(received(line))
    assert [(answer["path"], answer["body"]) for answer in told] == [("/b", 90), ("/c", 0)]


@pytest.mark.parametrize("before", [b"", b"GET / HTTP/1.1\r\n" + HOST + b"\r\n"], ids=["first", "later"])
def test_half_a_head_is_not_waited_for_without_end(site: Site, before: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_protocol, "HEAD_SECONDS", 0.05)
    with site.line() as line:
        if before:
            line.sendall(before)
            until(line, b"}")
        line.sendall(b"GET / HTTP/1.1\r\n")
        assert received(line) == b""
