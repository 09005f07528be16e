"""Fair turns on the processor of a web process: a request of somebody quiet goes at once, others wait behind.

One process serves everybody, and Python computes one thing at a time: who sends request after request takes as many
shares as it has requests in progress, a page that somebody opens has one. So whoever has used much processor lately, or
has many requests in progress, is served one request at a time, in turn with others like them, after the requests of
the quiet and of whoever has used half as much. Nothing is lost by that: as much is computed in a second. A queue of
bounded length waits, of which the busiest leave first (503).

Processor time is counted by account. Visitors and guests cost nothing to become, so that theirs is counted by address
as well: a class of guests behind the address of its school takes turns, one with another, as soon as it is busy; an
account with a password never waits for what others of its address do. A visitor's session is known from its first
request on, which looks it up anyway.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from hashlib import blake2b
from http import HTTPStatus
from uuid import UUID

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.base.caches import LRUCache
from server.base.concurrency import FairLimiter, LimiterFullError
from server.base.errors import Overloaded, ServiceError
from server.base.http import API, MONITORING_PATHS, SAFE_METHODS, bearer_token, client_address, session_token

#: Seconds of processor after which one is busy; seconds in which half of what was used is forgotten.
BUSY_SECONDS, HALF_LIFE = 1.0, 10.0
#: Requests in progress beyond which one is busy: browsers open six connections.
IN_PROGRESS = 6
#: Requests that wait: ten of each in a class of 35 that has just been told to begin, all behind one address.
MAX_WAITING = 400
#: Seconds after which a turn ends by itself; seconds for which a turn lets requests of the quiet go before.
TURN_SECONDS, GIVE_WAY_SECONDS = 0.25, 0.1
#: Accounts and addresses that are remembered; sessions and tokens of which the account is.
MAX_FLOWS, MAX_SENDERS = 10_000, 20_000
#: Ranks: of the busy, the last ones; each doubling of what they have used is one more.
QUIET, CROWD, BUSY = 0, 1, 2
CROWDED = "Beaucoup de demandes arrivent en ce moment : réessayez dans quelques secondes."


@dataclass(frozen=True)
class RequestFlow:
    """Whose a request is: the name of an account or of an address's visitors; and the crowd that it is one of, if any.

    The crowd are all visitors and guests of an address.
    """

    name: str
    crowd: str = ""


class ProcessorClock:
    """Shares the processor time of this process, at each moment equally, among the requests in progress."""

    def __init__(self, spent: Callable[[], float] = time.process_time) -> None:
        self._spent, self._last = spent, spent()
        self._count, self._share = 0, 0.0

    def begin(self) -> float:
        """Return the moment at which a request begins, for `end`."""
        self._advance()
        self._count += 1
        return self._share

    def end(self, begun: float) -> float:
        """Return the seconds of processor that a request is taken to have used since it began."""
        self._advance()
        self._count -= 1
        return self._share - begun

    def _advance(self) -> None:
        now = self._spent()
        if self._count:
            self._share += (now - self._last) / self._count
        self._last = now


class ProcessorUsage:
    """Seconds of processor that each flow has used lately."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._used: LRUCache[str, tuple[float, float]] = LRUCache(MAX_FLOWS)

    def recent_seconds(self, name: str) -> float:
        """Return the processor seconds of a flow, each halved every `HALF_LIFE` seconds since it was used."""
        seconds, at = self._used.get(name) or (0.0, 0.0)
        return seconds * 0.5 ** ((self._now() - at) / HALF_LIFE) if seconds else 0.0

    def add(self, name: str, seconds: float) -> None:
        self._used.put(name, (self.recent_seconds(name) + seconds, self._now()))


class RequestTurns:
    """The turns of one web process. For one event loop at a time."""

    def __init__(self, clock: ProcessorClock | None = None, usage: ProcessorUsage | None = None) -> None:
        self._clock, self._usage = clock or ProcessorClock(), usage or ProcessorUsage()
        self._limiter = FairLimiter(1, MAX_WAITING)
        self._in_progress: Counter[str] = Counter()
        self._quiet, self._no_quiet = 0, asyncio.Event()
        self._no_quiet.set()

    @property
    def waiting_count(self) -> int:
        return self._limiter.waiting_count

    async def begin(self, flow: RequestFlow) -> Callable[[], None]:
        """Wait for the turn of a request, and return what ends it, however often that is called. Raises Overloaded."""
        rank = self._rank_of_flow(flow)
        names = tuple(filter(None, (flow.name, flow.crowd)))
        if rank != QUIET:
            try:
                await self._limiter.acquire(flow.name, rank)
            except LimiterFullError:
                raise Overloaded(CROWDED, retry_after=5) from None
            try:
                await self._wait_for_quiet_requests()
            except BaseException:
                self._limiter.release(flow.name, rank)
                raise
        self._in_progress.update(names)
        self._count_quiet(rank, 1)
        begun, is_over = self._clock.begin(), False

        def end() -> None:
            nonlocal is_over
            if is_over:
                return
            is_over = True
            timer.cancel()
            seconds = self._clock.end(begun)
            for name in names:
                self._usage.add(name, seconds)
                self._in_progress[name] -= 1
                if not self._in_progress[name]:
                    del self._in_progress[name]
            self._count_quiet(rank, -1)
            if rank != QUIET:
                self._limiter.release(flow.name, rank)

        timer = asyncio.get_running_loop().call_later(TURN_SECONDS, end)
        return end

    def _rank_of_flow(self, flow: RequestFlow) -> int:
        doublings = self._count_usage_doublings(flow.name)
        if doublings is not None:
            return BUSY + doublings
        return CROWD if flow.crowd and self._count_usage_doublings(flow.crowd) is not None else QUIET

    def _count_usage_doublings(self, name: str) -> int | None:
        """Return how often one has used twice what makes one busy; None for who is quiet."""
        used = self._usage.recent_seconds(name) / BUSY_SECONDS
        if used > 1.0:
            return int(math.log2(used))
        return 0 if self._in_progress[name] >= IN_PROGRESS else None

    def _count_quiet(self, rank: int, change: int) -> None:
        if rank != QUIET:
            return
        if not self._quiet:
            self._no_quiet = asyncio.Event()  # a fresh one: each belongs to the loop that first waits for it
        self._quiet += change
        if not self._quiet:
            self._no_quiet.set()

    async def _wait_for_quiet_requests(self) -> None:
        """Wait until no request of the quiet is in progress, for a moment at most."""
        with suppress(TimeoutError):
            async with asyncio.timeout(GIVE_WAY_SECONDS if self._quiet else None):
                await self._no_quiet.wait()


_senders: LRUCache[bytes, tuple[str, bool]] = LRUCache(MAX_SENDERS)


class RequestTurn:
    """The turn of one request, which ends while the request waits for something, and for good as its answer begins."""

    def __init__(self, turns: RequestTurns, flow: RequestFlow) -> None:
        self._turns, self._flow = turns, flow
        self._end: Callable[[], None] = lambda: None
        self._is_over = False

    async def begin(self) -> None:
        """Wait for the turn. Raises Overloaded."""
        if not self._is_over:
            self._end = await self._turns.begin(self._flow)

    def pause(self) -> None:
        self._end()

    def end(self) -> None:
        self._is_over = True
        self._end()


_turn: ContextVar[RequestTurn | None] = ContextVar("turn", default=None)


def record_sender(token: str, account: UUID, *, is_guest: bool) -> None:
    """Remember whose a session or a token is, for the turns of the requests that show it."""
    _senders.put(_hash_token(token), (account.hex, is_guest))


def known_account(token: str) -> str:
    """Return the name of the account of a session or a token that was seen lately; empty for a guest's."""
    account, is_guest = _senders.get(_hash_token(token)) or ("", True)
    return "" if is_guest else account


@asynccontextmanager
async def out_of_turn() -> AsyncIterator[None]:
    """Wait for something else than the processor of this process: the turn of this request ends.

    What the request does next, and be it a page that refuses it, has a turn again. Raises Overloaded.
    """
    turn = _turn.get()
    if turn is None:
        yield
        return
    turn.pause()
    try:
        yield
    except Exception:
        await turn.begin()
        raise
    await turn.begin()


def flow_of_request(scope: Scope) -> RequestFlow:
    """Return whose a request is, as far as it is known before anything is read."""
    connection = HTTPConnection(scope)
    address = client_address(connection)
    token = session_token(connection) or bearer_token(connection)
    account, is_guest = (_senders.get(_hash_token(token)) if token else None) or ("", True)
    return RequestFlow(account or f"visitors of {address}", f"crowd of {address}" if is_guest else "")


def _hash_token(token: str) -> bytes:
    return blake2b(token.encode("utf-8", "replace"), digest_size=16).digest()


def _plain_refusal(error: Overloaded) -> Response:
    """Return a refusal that costs nothing, where nothing typed is to be shown again: a page takes longer to render than
    a flood takes to ask for it."""
    return PlainTextResponse(error.detail, error.status, error.headers)


async def _has_client_left(scope: Scope, receive: Receive) -> bool:
    """Whether the sender of a request without a body has closed the connection: nobody would read the answer."""
    request = Request(scope, receive)
    return await request.is_disconnected() or await request.is_disconnected()  # the first message is the empty body


class FairTurnsMiddleware:
    """Has each request wait for its turn, which ends as its answer begins."""

    def __init__(self, app: ASGIApp, refuse: Callable[[Request, ServiceError], Response]) -> None:
        self._app, self._refuse = app, refuse
        self._turns, self._refusals = RequestTurns(), CapacityLimiter(1)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["path"] in MONITORING_PATHS:
            return await self._app(scope, receive, send)
        is_crowded = self._turns.waiting_count > 0
        turn = RequestTurn(self._turns, flow_of_request(scope))
        try:
            await turn.begin()
        except Overloaded as error:
            is_page = scope["method"] in SAFE_METHODS and not scope["path"].startswith(API)
            answer = _plain_refusal(error) if is_page else await self._render_refusal(Request(scope), error)
            return await answer(scope, receive, send)
        if is_crowded and scope["method"] in SAFE_METHODS and await _has_client_left(scope, receive):
            turn.end()
            return await Response(status_code=HTTPStatus.SERVICE_UNAVAILABLE)(scope, receive, send)

        def send_and_end(message: Message) -> Awaitable[None]:
            if message["type"] == "http.response.body":
                turn.end()
            return send(message)

        _turn.set(turn)
        try:
            await self._app(scope, receive, send_and_end)
        finally:
            turn.end()

    async def _render_refusal(self, request: Request, error: Overloaded) -> Response:
        """Return a page for whom has sent a form: one is made at a time, as the queue is full."""
        return await run_sync(self._refuse, request, error, limiter=self._refusals)
