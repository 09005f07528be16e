"""Students who send, send again what was cut off, and follow what they have sent to its verdict."""

from __future__ import annotations

import asyncio
import json
import random
import time
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import httpx

#: A student gives up then, which fails the run.
PATIENCE = 240.0
REQUEST_SECONDS, AGAIN_SECONDS = 10.0, 0.5
TROUBLED = 500


@dataclass(frozen=True)
class Program:
    code: str
    outcome: str

    def numbered(self, number: int) -> str:
        """The same program, as nobody has sent it before."""
        return f"# envoi {number}\n{self.code}"


@dataclass(frozen=True)
class Failure:
    """A request that had no answer, or one that is no student's fault."""

    when: float
    address: str
    what: str


@dataclass
class Attempt:
    """One submission, from its first sending to its verdict; times are of `time.monotonic`, infinite until then."""

    number: int
    account: str
    expected: str
    begun: float
    tries: int = 0
    accepted: float = float("inf")
    id: str = ""
    told: float = float("inf")
    outcome: str = ""
    score: float | None = None


@dataclass
class Ledger:
    """What all students know."""

    attempts: list[Attempt] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)

    def waiting_at(self, when: float) -> list[Attempt]:
        return [one for one in self.attempts if one.begun <= when < one.told]


class Crowd:
    """Sends `count` programs, each student one at a time."""

    def __init__(
        self, addresses: Sequence[str], exercise: str, programs: Sequence[Program], ledger: Ledger, think: float
    ) -> None:
        self._addresses, self._exercise, self._programs = addresses, exercise, programs
        self._ledger, self._think = ledger, think
        self._left, self._ends = 0, float("inf")

    def close(self, after: float) -> None:
        """In so many seconds nobody begins anything any more."""
        self._ends = time.monotonic() + after

    async def send(self, tokens: dict[str, str], count: int, seed: int) -> None:
        """`tokens` by account."""
        self._left = count
        limits = httpx.Limits(max_keepalive_connections=4 * len(tokens))
        async with httpx.AsyncClient(timeout=REQUEST_SECONDS, limits=limits) as client:
            each = enumerate(tokens.items())
            await asyncio.gather(*(self._work(client, *who, random.Random(seed + n)) for n, who in each))

    async def _work(self, client: httpx.AsyncClient, account: str, token: str, draw: random.Random) -> None:
        student = Student(client, token, self._addresses, self._ledger, draw)
        while self._left > 0 and time.monotonic() < self._ends:
            self._left -= 1
            program = draw.choice(self._programs)
            attempt = Attempt(len(self._ledger.attempts), account, program.outcome, time.monotonic())
            self._ledger.attempts.append(attempt)
            body = {"exercise": self._exercise, "code": program.numbered(attempt.number)}
            try:
                async with asyncio.timeout(PATIENCE):
                    await student.submit(attempt, body)
                    await student.follow(attempt)
            except TimeoutError:
                continue  # which the ledger shows
            await asyncio.sleep(draw.uniform(0.0, 2.0 * self._think))


class Student:
    """Turns to another web process when one does not answer, as a load balancer would have it."""

    def __init__(
        self, client: httpx.AsyncClient, token: str, addresses: Sequence[str], ledger: Ledger, draw: random.Random
    ) -> None:
        self._client, self._headers = client, {"Authorization": f"Bearer {token}"}
        self._addresses, self._ledger, self._draw = addresses, ledger, draw
        self._avoided = ""

    def _address(self) -> str:
        """Any, but for the one that has just failed."""
        return self._draw.choice([one for one in self._addresses if one != self._avoided] or self._addresses)

    async def submit(self, attempt: Attempt, body: dict[str, Any]) -> None:
        while not attempt.id:
            attempt.tries += 1
            headers = {**self._headers, "Idempotency-Key": f"envoi-{attempt.number}"}
            answer = await self._ask("POST", "/api/v1/submissions", json=body, headers=headers)
            if answer is not None:
                assert answer.status_code in {200, 202}, answer.text
                attempt.accepted, attempt.id = time.monotonic(), answer.json()["id"]

    async def follow(self, attempt: Attempt) -> None:
        """By its events or by looking again, as it falls."""
        url = f"/api/v1/submissions/{attempt.id}"
        while not attempt.outcome:
            if self._draw.random() < 0.5:
                async for current in self._events(f"{url}/events"):
                    self._note(attempt, current)
            else:
                answer = await self._ask("GET", url, headers=self._headers)
                if answer is not None:
                    assert answer.status_code == 200, answer.text
                    self._note(attempt, answer.json())
                if not attempt.outcome:
                    await asyncio.sleep(0.1)

    def _note(self, attempt: Attempt, current: dict[str, Any]) -> None:
        if current["status"] == "done":
            verdict = current["verdict"]
            attempt.told, attempt.outcome, attempt.score = time.monotonic(), verdict["outcome"], verdict["score"]

    async def _ask(self, method: str, path: str, **options: Any) -> httpx.Response | None:
        """None where there was no answer, or the service was troubled."""
        address = self._address()
        try:
            answer = await self._client.request(method, address + path, **options)
        except httpx.HTTPError as error:
            await self._failed(address, type(error).__name__)
            return None
        if answer.status_code >= TROUBLED:
            await self._failed(address, str(answer.status_code))
            return None
        self._avoided = ""
        return answer

    async def _events(self, path: str) -> AsyncIterator[dict[str, Any]]:
        """Until the stream ends, as it may at any time."""
        address = self._address()
        try:
            async with self._client.stream("GET", address + path, headers=self._headers) as answer:
                if answer.status_code >= TROUBLED:
                    await self._failed(address, str(answer.status_code))
                    return
                async for line in answer.aiter_lines():
                    if line.startswith("data:"):
                        yield json.loads(line.removeprefix("data:"))
        except httpx.HTTPError as error:
            await self._failed(address, f"events: {type(error).__name__}")

    async def _failed(self, address: str, what: str) -> None:
        self._ledger.failures.append(Failure(time.monotonic(), address, what))
        self._avoided = address
        await asyncio.sleep(self._draw.uniform(0.0, 2.0 * AGAIN_SECONDS))
