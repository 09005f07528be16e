"""As little of a client as there may be, so that what is measured is the service: sockets, one request each, kept open;
and the processor time of the parts of a service."""

from __future__ import annotations

import json
import re
import selectors
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from tests.benchmarks import processes
from tests.support.live import children

LENGTH = re.compile(rb"^content-length: *(\d+)", re.IGNORECASE | re.MULTILINE)
PATH = "/api/v1/submissions?wait=30"
PIECE = 1 << 16
#: Parts of a service: what answers, what judges, the students' programs with their templates, what draws.
WEB, GRADERS, PROGRAMS, OTHERS = PARTS = ("web", "graders", "programs", "figures")
SETTLED, LOOK = 0.04, 1.0  # a service that takes less processor than this between two looks has warmed up
PATIENCE = 180.0


@dataclass(frozen=True)
class Answer:
    status: int
    body: bytes
    began: float
    ended: float

    def json(self) -> Any:
        return json.loads(self.body)


class Line:
    """One connection, with one request on it at a time."""

    def __init__(self, address: str, token: str) -> None:
        place = urlsplit(address)
        self._host, self._token = place.netloc, token
        self.socket = socket.create_connection((place.hostname or "", place.port or 80))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._held, self._began = bytearray(), 0.0

    def request(self, exercise: str, code: str) -> bytes:
        body = json.dumps({"exercise": exercise, "code": code}).encode()
        head = f"POST {PATH} HTTP/1.1\r\nHost: {self._host}\r\nAuthorization: Bearer {self._token}\r\n"
        head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        return head.encode() + body

    def send(self, request: bytes) -> None:
        self._began = time.time()
        self.socket.sendall(request)

    def receive(self) -> Answer | None:
        """What has come, once it is whole. Raises ConnectionError."""
        piece = self.socket.recv(PIECE)
        if not piece:
            raise ConnectionError("the service has closed the connection")
        self._held += piece
        head, found, body = bytes(self._held).partition(b"\r\n\r\n")
        length = LENGTH.search(head)
        if not found or length is None or len(body) < int(length[1]):
            return None
        self._held.clear()
        return Answer(int(head.split(b" ", 2)[1]), body, self._began, time.time())

    def exchange(self, request: bytes) -> Answer:
        self.send(request)
        while (answer := self.receive()) is None:
            pass
        return answer

    def close(self) -> None:
        self.socket.close()


def crowd(lines: list[Line], next_request: Callable[[int], bytes | None]) -> Iterator[Answer]:
    """Each line sends again as soon as it is answered, until its next request is None; the answers as they come.

    Raises RuntimeError for one that is no verdict.
    """
    with selectors.DefaultSelector() as watched:
        for number, line in enumerate(lines):
            if (request := next_request(number)) is not None:
                line.send(request)
                watched.register(line.socket, selectors.EVENT_READ, number)
        while watched.get_map():
            for key, _ in watched.select():
                number = key.data
                answer = lines[number].receive()
                if answer is None:
                    continue
                if answer.status != 200:
                    raise RuntimeError(f"{answer.status}: {answer.body.decode(errors='replace')[:300]}")
                if (request := next_request(number)) is None:
                    watched.unregister(key.fileobj)
                else:
                    lines[number].send(request)
                yield answer


def spent(pid: int) -> dict[str, float]:
    """Seconds of processor of each part of a service, with its processes that have ended."""
    found = dict.fromkeys(PARTS, 0.0)
    found[WEB] += processes.spent(pid)[0]
    for child in processes.direct(pid):
        grading = processes.grades(child)
        found[GRADERS if grading else OTHERS] += processes.spent(child)[0]
        for one in children(child):
            found[PROGRAMS if grading else OTHERS] += sum(processes.spent(one))
    return found


def settle(pid: int) -> None:
    """Until the service has warmed up: it reads texts and rehearses graders as it starts."""
    deadline, before = time.monotonic() + PATIENCE, -1.0
    while time.monotonic() < deadline:
        now = sum(spent(pid).values())
        if 0 <= now - before < SETTLED and before >= 0:
            return
        before = now
        time.sleep(LOOK)
    raise RuntimeError("the service does not come to rest")
