"""A worker's tickets: pulled one at a time from the consumers, those first of what somebody waits for.

A worker asks each consumer in order whether it has a ticket now; where none has, it waits at all of them at once. What
comes when it has a ticket already goes back at once. Without NATS, or where JetStream does not answer, it looks into
the database again and again instead: slower, but nothing stands still. Where it does answer, and brings nothing, the
worker still looks now and then: what a cluster says of its tickets after a fault may be wrong.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from server.queue.jetstream.connection import FAILURES, Connection, DownError
from server.queue.jetstream.layout import STREAM, Desk
from server.queue.port import Ticket

#: A pull that waits is asked again so often: the server forgets it with the node that held it.
PULL_SECONDS = 2.0
ANSWER_SECONDS = 1.0
RETRY_SECONDS = 0.5
#: Of waits that brought nothing, one in so many is followed by a look into the database.
WAITS_WITHOUT_A_LOOK = 20
NANO = 1_000_000_000
#: A ticket that its holder has no job for goes on to another in so many seconds, doubled each time.
FIRST_DELAY, LONGEST_DELAY = 0.05, 5.0
ACK, NAK, PROGRESS = b"+ACK", b"-NAK", b"+WPI"
EMPTY = frozenset({"404", "408"})


@dataclass(frozen=True)
class Pulled:
    """A ticket of the stream."""

    kinds: Collection[str]
    deliveries: int
    reply: str
    connection: Connection

    @property
    def again(self) -> bool:
        return self.deliveries > 1

    def keep(self) -> None:
        self._answer(PROGRESS)

    def spend(self, *, used: bool) -> None:
        self._answer(ACK)

    def give_back(self, *, later: bool) -> None:
        delay = min(FIRST_DELAY * 2 ** min(self.deliveries, 10), LONGEST_DELAY)
        self._answer(NAK + b" " + json.dumps({"delay": int(delay * NANO)}).encode() if later else NAK)

    def _answer(self, word: bytes) -> None:
        """Where it does not arrive the ticket is passed on in the end, and finds no job: no harm."""
        self.connection.answer(self.reply, word)


class Free:
    """Leave to look for any job, where no ticket comes."""

    again = False

    def __init__(self, kinds: Collection[str]) -> None:
        self.kinds, self.used = kinds, False

    def keep(self) -> None:
        return

    def spend(self, *, used: bool) -> None:
        self.used = used

    def give_back(self, *, later: bool) -> None:
        return


class PulledTickets:
    """Fills `server.queue.port.Tickets`; one worker's. State is shared with the connection's thread under a lock."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._desks = connection.layout.desks
        self._kinds = [desk.kind for desk in self._desks]
        self._lock, self._arrived = threading.Lock(), threading.Event()
        self._wanted = False
        self._ticket: Pulled | None = None
        self._last: Free | None = None
        self._answered, self._vain = False, 0
        self._pulling: asyncio.Task[None] | None = None
        self._waiting: dict[Desk, asyncio.Task[Exception | None]] = {}

    def wait(self, seconds: float) -> None:
        if self._last is not None and self._last.used and not self._answered:
            return  # there was work without a ticket: there may be more
        with self._lock:
            self._wanted = True
        self._connection.on_loop(self._pull)
        self._arrived.wait(seconds)

    def take(self) -> Ticket | None:
        with self._lock:
            ticket, self._ticket = self._ticket, None
            self._arrived.clear()
            if ticket is not None:
                self._wanted, self._last, self._vain = False, None, 0
                return ticket
            self._vain += 1
            if self._answered and self._connection.up and self._vain < WAITS_WITHOUT_A_LOOK:
                self._last = None
                return None
            self._wanted, self._last, self._vain = False, Free(self._kinds), 0
            return self._last

    def close(self) -> None:
        """What came and was not taken goes to another at once."""
        with self._lock:
            self._wanted = False
            ticket, self._ticket = self._ticket, None
        if ticket is not None:
            ticket.give_back(later=False)

    def _pull(self) -> None:
        if self._pulling is None or self._pulling.done():
            self._pulling = asyncio.get_running_loop().create_task(self._keep_pulling())

    async def _keep_pulling(self) -> None:
        """As long as a ticket is wanted."""
        while self._wanted and self._ticket is None:
            try:
                await self._pull_once()
            except (*FAILURES, DownError):
                self._answered = False
                await asyncio.sleep(RETRY_SECONDS)

    async def _pull_once(self) -> None:
        """Asks each consumer in order; then waits at all of them, until one answers.

        A pull that waits goes on when another has brought a ticket: it is not made twice.
        """
        for desk in self._desks:
            if not self._waits_at(desk) and await self._ask(desk, {"no_wait": True}, ANSWER_SECONDS):
                return
        self._answered = True
        for desk in self._desks:
            if not self._waits_at(desk):
                self._waiting[desk] = asyncio.get_running_loop().create_task(self._wait_at(desk))
        done, _ = await asyncio.wait(self._waiting.values(), return_when=asyncio.FIRST_COMPLETED)
        for pull in done:
            if failure := pull.result():
                raise failure

    async def _wait_at(self, desk: Desk) -> Exception | None:
        """Whatever it brings is offered; why it could not, where nobody listens to it any more."""
        try:
            await self._ask(desk, {"expires": int(PULL_SECONDS * NANO)}, PULL_SECONDS + ANSWER_SECONDS)
        except (*FAILURES, DownError) as error:
            return error
        return None

    def _waits_at(self, desk: Desk) -> bool:
        return desk in self._waiting and not self._waiting[desk].done()

    async def _ask(self, desk: Desk, how: Mapping[str, object], seconds: float) -> bool:
        """One pull; whether it has brought a ticket."""
        client = self._connection.client
        subject, asked = f"$JS.API.CONSUMER.MSG.NEXT.{STREAM}.{desk.consumer}", json.dumps({"batch": 1, **how})
        message = await client.request(subject, asked.encode(), timeout=seconds, old_style=True)
        status = (message.headers or {}).get("Status")
        if status is not None:
            if status not in EMPTY:
                raise DownError(f"{status} {(message.headers or {}).get('Description', '')}")
            return False
        self._offer(Pulled([desk.kind], message.metadata.num_delivered, message.reply, self._connection))
        return True

    def _offer(self, ticket: Pulled) -> None:
        with self._lock:
            if self._wanted and self._ticket is None:
                self._ticket = ticket
                self._arrived.set()
                return
        ticket.give_back(later=False)
