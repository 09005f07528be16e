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

from server.queue.interfaces import WorkMessage
from server.queue.jetstream.connection import FAILURES, NatsConnection, NatsUnavailableError
from server.queue.jetstream.stream_layout import STREAM, JobConsumer

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
class PulledMessage:
    """A ticket of the stream."""

    kinds: Collection[str]
    deliveries: int
    reply: str
    connection: NatsConnection

    @property
    def redelivered(self) -> bool:
        return self.deliveries > 1

    def in_progress(self) -> None:
        self._answer(PROGRESS)

    def ack(self, *, job_done: bool) -> None:
        self._answer(ACK)

    def nak(self, *, delayed: bool) -> None:
        delay = min(FIRST_DELAY * 2 ** min(self.deliveries, 10), LONGEST_DELAY)
        self._answer(NAK + b" " + json.dumps({"delay": int(delay * NANO)}).encode() if delayed else NAK)

    def _answer(self, word: bytes) -> None:
        """Where it does not arrive the ticket is passed on in the end, and finds no job: no harm."""
        self.connection.reply(self.reply, word)


class DatabasePoll:
    """Leave to look for any job, where no ticket comes."""

    redelivered = False

    def __init__(self, kinds: Collection[str]) -> None:
        self.kinds, self.job_done = kinds, False

    def in_progress(self) -> None:
        return

    def ack(self, *, job_done: bool) -> None:
        self.job_done = job_done

    def nak(self, *, delayed: bool) -> None:
        return


class PullSubscription:
    """One worker's pull subscription (a `WorkSubscription`). A lock guards what the connection's thread shares."""

    def __init__(self, connection: NatsConnection) -> None:
        self._connection = connection
        self._desks = connection.layout.consumers
        self._kinds = [desk.kind for desk in self._desks]
        self._lock, self._arrived = threading.Lock(), threading.Event()
        self._wanted = False
        self._ticket: PulledMessage | None = None
        self._last: DatabasePoll | None = None
        self._answered, self._vain = False, 0
        self._pulling: asyncio.Task[None] | None = None
        self._waiting: dict[JobConsumer, asyncio.Task[Exception | None]] = {}

    def wait(self, seconds: float) -> None:
        if self._last is not None and self._last.job_done and not self._answered:
            return  # there was work without a ticket: there may be more
        with self._lock:
            self._wanted = True
        self._connection.call_on_loop(self._pull)
        self._arrived.wait(seconds)

    def take_message(self) -> WorkMessage | None:
        with self._lock:
            ticket, self._ticket = self._ticket, None
            self._arrived.clear()
            if ticket is not None:
                self._wanted, self._last, self._vain = False, None, 0
                return ticket
            self._vain += 1
            if self._answered and self._connection.is_up and self._vain < WAITS_WITHOUT_A_LOOK:
                self._last = None
                return None
            self._wanted, self._last, self._vain = False, DatabasePoll(self._kinds), 0
            return self._last

    def close(self) -> None:
        """What came and was not taken goes to another at once."""
        with self._lock:
            self._wanted = False
            ticket, self._ticket = self._ticket, None
        if ticket is not None:
            ticket.nak(delayed=False)

    def _pull(self) -> None:
        if self._pulling is None or self._pulling.done():
            self._pulling = asyncio.get_running_loop().create_task(self._keep_pulling())

    async def _keep_pulling(self) -> None:
        """As long as a ticket is wanted."""
        while self._wanted and self._ticket is None:
            try:
                await self._pull_once()
            except (*FAILURES, NatsUnavailableError):
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

    async def _wait_at(self, desk: JobConsumer) -> Exception | None:
        """Whatever it brings is offered; why it could not, where nobody listens to it any more."""
        try:
            await self._ask(desk, {"expires": int(PULL_SECONDS * NANO)}, PULL_SECONDS + ANSWER_SECONDS)
        except (*FAILURES, NatsUnavailableError) as error:
            return error
        return None

    def _waits_at(self, desk: JobConsumer) -> bool:
        return desk in self._waiting and not self._waiting[desk].done()

    async def _ask(self, desk: JobConsumer, how: Mapping[str, object], seconds: float) -> bool:
        """One pull; whether it has brought a ticket."""
        client = self._connection.client
        subject, asked = f"$JS.API.CONSUMER.MSG.NEXT.{STREAM}.{desk.consumer_name}", json.dumps({"batch": 1, **how})
        message = await client.request(subject, asked.encode(), timeout=seconds, old_style=True)
        status = (message.headers or {}).get("Status")
        if status is not None:
            if status not in EMPTY:
                raise NatsUnavailableError(f"{status} {(message.headers or {}).get('Description', '')}")
            return False
        self._offer(PulledMessage([desk.kind], message.metadata.num_delivered, message.reply, self._connection))
        return True

    def _offer(self, ticket: PulledMessage) -> None:
        with self._lock:
            if self._wanted and self._ticket is None:
                self._ticket = ticket
                self._arrived.set()
                return
        ticket.nak(delayed=False)
