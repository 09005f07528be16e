"""One who attacks a running service by HTTP alone, from a process of its own."""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from http.client import HTTPConnection, HTTPException
from random import Random
from typing import Any
from urllib.parse import urlencode, urlsplit

FORM = "application/x-www-form-urlencoded"
#: Of the attacker's processes: one's own machine is not the attacked one.
NICE = 19
SECONDS = 20.0
#: Seconds between two tries of what was refused or has failed at once.
PAUSE = 0.02


@dataclass(frozen=True)
class Target:
    """What an attacker knows: web processes, session cookies of guests, a teacher's, and pages of theirs."""

    addresses: tuple[str, ...]
    guests: tuple[str, ...]
    teacher: str
    teachers_class: str
    exercise: str
    code: str
    #: Of one guest each, with a wrong answer.
    attempts: tuple[str, ...] = ()


@dataclass
class Attacker:
    """One thread of an attack; `state` is its own from one call to the next."""

    target: Target
    number: int
    random: Random
    counts: Counter[str]
    stopped: threading.Event
    state: dict[str, Any] = field(default_factory=dict)

    @property
    def address(self) -> str:
        return self.target.addresses[self.number % len(self.target.addresses)]

    @property
    def guest(self) -> str:
        """A guest's cookie, which fewer than all threads share."""
        return self.target.guests[self.number % len(self.target.guests)]

    def request(
        self,
        method: str,
        path: str,
        body: bytes | str | Mapping[str, str] | None = None,
        *,
        cookie: str = "",
        kind: str = FORM,
        **headers: str,
    ) -> tuple[int, str, bytes]:
        """Return status, where it leads, and body. A connection is kept from one request to the next."""
        if isinstance(body, Mapping):
            body = urlencode(body)
        values = {name.replace("_", "-"): value for name, value in headers.items()}
        if cookie:
            values["Cookie"] = cookie
        if body is not None:
            values["Content-Type"] = kind
        connection = self.state.get("connection") or HTTPConnection(urlsplit(self.address).netloc, timeout=SECONDS)
        self.state["connection"] = connection
        try:
            connection.request(method, path, body, values)
            answer = connection.getresponse()
            content = answer.read()
        except (OSError, HTTPException):
            connection.close()
            raise
        self.counts[str(answer.status)] += 1
        return answer.status, answer.getheader("Location", ""), content

    def submit(self, code: str, exercise: str = "") -> str:
        """Send a file as a guest; return the address of the attempt, empty where it was refused."""
        module, slug = (exercise or self.target.exercise).split("/")
        form = {"code": code + f"\n# {self.random.random()}"}
        status, location, _ = self.request("POST", f"/{module}/exercices/{slug}/soumissions", form, cookie=self.guest)
        if status != 303:
            self.stopped.wait(0.2)
        return location if status == 303 else ""

    @contextmanager
    def connection(self) -> Iterator[socket.socket]:
        """A bare connection."""
        parts = urlsplit(self.address)
        with socket.create_connection((parts.hostname, parts.port), timeout=SECONDS) as bare:
            yield bare
        self.counts["bare"] += 1

    def send_pieces(self, head: bytes, piece: bytes, pieces: int, pause: float = 0.0) -> None:
        """Send a head, then the same piece many times, until the service hangs up."""
        with self.connection() as bare, suppress(OSError):
            bare.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            bare.sendall(head)
            for _ in range(pieces):
                if self.stopped.wait(pause) if pause else self.stopped.is_set():
                    return
                bare.sendall(piece)
            bare.recv(1 << 16)


def attack(target: Target, names: list[str], seconds: float | None = None) -> dict[str, dict[str, int]]:
    """Let these floods go on until the standard input is closed; return what came of their requests."""
    from tests.contract.gate.floods import FLOODS

    stopped, threads, counts = threading.Event(), list[threading.Thread](), dict[str, Counter[str]]()

    def repeat(name: str, attacker: Attacker) -> None:
        while not stopped.is_set():
            try:
                FLOODS[name].act(attacker)
                attacker.counts["acts"] += 1
            except (OSError, HTTPException) as error:
                attacker.counts[type(error).__name__] += 1
                stopped.wait(PAUSE)

    for name in names:
        counts[name] = Counter()
        for number in range(FLOODS[name].at_once):
            attacker = Attacker(target, number, Random(f"{name}{number}"), counts[name], stopped)
            threads.append(threading.Thread(target=repeat, args=(name, attacker), daemon=True))
    for thread in threads:
        thread.start()
    print("begun", flush=True)
    sys.stdin.read()
    stopped.set()
    deadline = time.monotonic() + 2.0
    for thread in threads:
        thread.join(max(0.0, deadline - time.monotonic()))
    return {name: dict(counter) for name, counter in counts.items()}


def main() -> None:
    os.nice(NICE)
    given = json.loads(sys.argv[1])
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in given["target"].items()}
    print(json.dumps(attack(Target(**values), given["floods"])), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
