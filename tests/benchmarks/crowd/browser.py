"""As much of a browser as costs a service something: connections kept open, a cookie, tags of what was seen, events.

It reads HTTP/1.1 as our own service writes it, and is no client for anything else.
"""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, field
from urllib.parse import quote, urlencode, urlsplit

CRLF = b"\r\n"
PATIENCE = 120.0  # seconds: who waits longer has met a failure


class BrokenError(Exception):
    """The connection ended, or what came is no HTTP."""


@dataclass(frozen=True)
class Answer:
    status: int
    headers: Mapping[bytes, bytes]
    body: bytes

    @property
    def text(self) -> str:
        body = gzip.decompress(self.body) if self.headers.get(b"content-encoding") == b"gzip" else self.body
        return body.decode()


@dataclass
class Connection:
    """One at a time; opened again where the service has closed it meanwhile, as browsers do."""

    host: str
    port: int
    reader: asyncio.StreamReader | None = None
    writer: asyncio.StreamWriter | None = None

    async def exchange(self, request: bytes) -> Answer:
        """Raises BrokenError or OSError."""
        used = self.reader is not None and not self.reader.at_eof()
        try:
            return await self._once(request)
        except (BrokenError, ConnectionError):
            if not used:
                raise
            self.close()  # it was being closed as we wrote: nothing of it was read
            return await self._once(request)

    async def _once(self, request: bytes) -> Answer:
        reader, writer = await self.open()
        writer.write(request)
        status, headers = await read_head(reader)
        body = await read_body(reader, status, headers)
        if headers.get(b"connection") == b"close":
            self.close()
        return Answer(status, headers, body)

    async def open(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        if self.reader is None or self.writer is None or self.reader.at_eof():
            self.close()
            self.reader, self.writer = await asyncio.open_connection(self.host, self.port, limit=1 << 20)
        return self.reader, self.writer

    def close(self) -> None:
        if self.writer is not None:
            self.writer.close()
        self.reader = self.writer = None


async def read_head(reader: asyncio.StreamReader) -> tuple[int, dict[bytes, bytes]]:
    try:
        lines = (await reader.readuntil(b"\r\n\r\n")).split(CRLF)
    except asyncio.IncompleteReadError as error:
        raise BrokenError("no answer") from error
    headers = {}
    for line in lines[1:-2]:
        name, _, value = line.partition(b":")
        headers[name.lower()] = value.strip()
    return int(lines[0].split(b" ")[1]), headers


async def read_body(reader: asyncio.StreamReader, status: int, headers: Mapping[bytes, bytes]) -> bytes:
    if status in {204, 304}:
        return b""
    if headers.get(b"transfer-encoding") == b"chunked":
        return b"".join([piece async for piece in pieces(reader)])
    try:
        return await reader.readexactly(int(headers.get(b"content-length", b"0")))
    except asyncio.IncompleteReadError as error:
        raise BrokenError("half an answer") from error


async def pieces(reader: asyncio.StreamReader) -> AsyncIterator[bytes]:
    """Of a chunked body, as they come."""
    try:
        while size := int(await reader.readuntil(CRLF), 16):
            yield (await reader.readexactly(size + 2))[:-2]
        await reader.readuntil(CRLF)
    except asyncio.IncompleteReadError as error:
        raise BrokenError("the stream ended") from error


def events(text: str) -> list[tuple[str, str]]:
    """Name and data of each server-sent event of a piece; our service writes whole ones."""
    found = []
    for event in text.split("\n\n"):
        lines = [line.partition(": ") for line in event.split("\n")]
        name = next((value for key, _, value in lines if key == "event"), "")
        if name:
            found.append((name, "\n".join(value for key, _, value in lines if key == "data")))
    return found


@dataclass
class Browser:
    """One person's. `addresses`: the web processes; pages come from the first, streams from the last: a balancer
    without affinity gives them to whom it likes."""

    addresses: tuple[str, ...]
    cookie: str = ""
    tags: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._pages, self._streams = (self._connection(one) for one in (self.addresses[0], self.addresses[-1]))

    @staticmethod
    def _connection(address: str) -> Connection:
        place = urlsplit(address)
        return Connection(place.hostname or "", place.port or 80)

    def _request(self, method: str, path: str, **headers: str) -> bytes:
        given = {"Host": urlsplit(self.addresses[0]).netloc, "Accept-Encoding": "gzip", **headers}
        if self.cookie:
            given["Cookie"] = f"balise_session={self.cookie}"
        lines = "".join(f"{name.replace('_', '-')}: {value}\r\n" for name, value in given.items())
        return f"{method} {quote(path, safe='/?=&%;:')} HTTP/1.1\r\n{lines}\r\n".encode()

    async def get(self, path: str) -> Answer:
        """A page that was seen before is asked for with its tag."""
        tag = self.tags.get(path, "")
        headers = {"If-None-Match": tag} if tag else {}
        async with asyncio.timeout(PATIENCE):
            answer = await self._pages.exchange(self._request("GET", path, Accept="text/html", **headers))
        if b"etag" in answer.headers:
            self.tags[path] = answer.headers[b"etag"].decode()
        return answer

    async def post(self, path: str, **form: str) -> Answer:
        body = urlencode(form).encode()
        kind = "application/x-www-form-urlencoded"
        head = self._request("POST", path, Accept="application/json", Content_Type=kind, Content_Length=str(len(body)))
        async with asyncio.timeout(PATIENCE):
            answer = await self._pages.exchange(head + body)
        given = answer.headers.get(b"set-cookie", b"").decode()
        if given.startswith("balise_session="):
            self.cookie = given.partition("=")[2].partition(";")[0]
        return answer

    async def follow(self, path: str) -> AsyncIterator[tuple[str, str]]:
        """Server-sent events, until the service ends the stream. Raises BrokenError, with the status of a refusal."""
        reader, writer = await self._streams.open()
        writer.write(self._request("GET", path, Accept="text/event-stream"))
        try:
            async with asyncio.timeout(PATIENCE):
                status, _ = await read_head(reader)
            if status != 200:
                raise BrokenError(f"{path}: {status}")
            async for piece in pieces(reader):
                for event in events(piece.decode()):
                    yield event
        finally:
            self._streams.close()

    def close(self) -> None:
        self._pages.close()
        self._streams.close()
