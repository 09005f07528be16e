"""A worker's pull subscription: messages are pulled one at a time, interactive consumers first.

A worker asks each consumer in order for a message without waiting; where none has one, it waits at all of them. Surplus
messages are handed back at once. Without NATS, or where JetStream does not answer, it polls the database instead. Where
JetStream answers and brings nothing, the worker still polls now and then: after a fault, a cluster may report wrongly.
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

#: Expiry of a waiting pull, which is then renewed: the server forgets it with the node that held it.
PULL_SECONDS = 2.0
ANSWER_SECONDS = 1.0
RETRY_SECONDS = 0.5
#: After so many empty waits, the worker polls the database.
EMPTY_WAITS_BEFORE_POLL = 20
NANOSECONDS = 1_000_000_000
#: Redelivery delay in seconds of a message without a suitable job: the first, doubled up to the longest.
FIRST_DELAY, LONGEST_DELAY = 0.05, 5.0
ACK, NAK, PROGRESS = b"+ACK", b"-NAK", b"+WPI"
EMPTY_STATUSES = frozenset({"404", "408"})


@dataclass(frozen=True)
class PulledMessage:
    """A message of the stream."""

    kinds: Collection[str]
    deliveries: int
    reply: str
    connection: NatsConnection

    @property
    def redelivered(self) -> bool:
        return self.deliveries > 1

    def in_progress(self) -> None:
        self._reply(PROGRESS)

    def ack(self, *, job_done: bool) -> None:
        self._reply(ACK)

    def nak(self, *, delayed: bool) -> None:
        delay = min(FIRST_DELAY * 2 ** min(self.deliveries, 10), LONGEST_DELAY)
        self._reply(NAK + b" " + json.dumps({"delay": int(delay * NANOSECONDS)}).encode() if delayed else NAK)

    def _reply(self, payload: bytes) -> None:
        """Send a reply; if it is lost, the message is redelivered and finds no job."""
        self.connection.reply(self.reply, payload)


class DatabasePoll:
    """Stands in for a message where none comes: the worker looks for any job."""

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
        self._consumers = connection.layout.consumers
        self._kinds = [consumer.kind for consumer in self._consumers]
        self._lock, self._arrived = threading.Lock(), threading.Event()
        self._wants_message = False
        self._message: PulledMessage | None = None
        self._last_poll: DatabasePoll | None = None
        self._jetstream_answers, self._empty_waits = False, 0
        self._pull_task: asyncio.Task[None] | None = None
        self._waiting_pulls: dict[JobConsumer, asyncio.Task[Exception | None]] = {}

    def wait(self, seconds: float) -> None:
        if self._last_poll is not None and self._last_poll.job_done and not self._jetstream_answers:
            return  # the last poll found a job: there may be more
        with self._lock:
            self._wants_message = True
        self._connection.call_on_loop(self._pull)
        self._arrived.wait(seconds)

    def take_message(self) -> WorkMessage | None:
        with self._lock:
            message, self._message = self._message, None
            self._arrived.clear()
            if message is not None:
                self._wants_message, self._last_poll, self._empty_waits = False, None, 0
                return message
            self._empty_waits += 1
            if self._jetstream_answers and self._connection.is_up and self._empty_waits < EMPTY_WAITS_BEFORE_POLL:
                self._last_poll = None
                return None
            self._wants_message, self._last_poll, self._empty_waits = False, DatabasePoll(self._kinds), 0
            return self._last_poll

    def close(self) -> None:
        """Hand an untaken message back at once."""
        with self._lock:
            self._wants_message = False
            message, self._message = self._message, None
        if message is not None:
            message.nak(delayed=False)

    def _pull(self) -> None:
        if self._pull_task is None or self._pull_task.done():
            self._pull_task = asyncio.get_running_loop().create_task(self._keep_pulling())

    async def _keep_pulling(self) -> None:
        """Pull as long as a message is wanted."""
        while self._wants_message and self._message is None:
            try:
                await self._pull_once()
            except (*FAILURES, NatsUnavailableError):
                self._jetstream_answers = False
                await asyncio.sleep(RETRY_SECONDS)

    async def _pull_once(self) -> None:
        """Ask each consumer in order; then wait at all of them, until one answers.

        A waiting pull stays when another has brought a message: it is not repeated.
        """
        for consumer in self._consumers:
            if not self._is_waiting_at(consumer) and await self._request_message(
                consumer, {"no_wait": True}, ANSWER_SECONDS
            ):
                return
        self._jetstream_answers = True
        for consumer in self._consumers:
            if not self._is_waiting_at(consumer):
                self._waiting_pulls[consumer] = asyncio.get_running_loop().create_task(self._wait_at_consumer(consumer))
        done, _ = await asyncio.wait(self._waiting_pulls.values(), return_when=asyncio.FIRST_COMPLETED)
        for pull in done:
            if failure := pull.result():
                raise failure

    async def _wait_at_consumer(self, consumer: JobConsumer) -> Exception | None:
        """Offer what a waiting pull brings; return its failure, if any."""
        try:
            await self._request_message(
                consumer, {"expires": int(PULL_SECONDS * NANOSECONDS)}, PULL_SECONDS + ANSWER_SECONDS
            )
        except (*FAILURES, NatsUnavailableError) as error:
            return error
        return None

    def _is_waiting_at(self, consumer: JobConsumer) -> bool:
        return consumer in self._waiting_pulls and not self._waiting_pulls[consumer].done()

    async def _request_message(self, consumer: JobConsumer, options: Mapping[str, object], seconds: float) -> bool:
        """Send one pull request; return whether it brought a message."""
        client = self._connection.connected_client
        subject = f"$JS.API.CONSUMER.MSG.NEXT.{STREAM}.{consumer.consumer_name}"
        request = json.dumps({"batch": 1, **options})
        response = await client.request(subject, request.encode(), timeout=seconds, old_style=True)
        status = (response.headers or {}).get("Status")
        if status is not None:
            if status not in EMPTY_STATUSES:
                raise NatsUnavailableError(f"{status} {(response.headers or {}).get('Description', '')}")
            return False
        self._offer_message(
            PulledMessage([consumer.kind], response.metadata.num_delivered, response.reply, self._connection)
        )
        return True

    def _offer_message(self, message: PulledMessage) -> None:
        with self._lock:
            if self._wants_message and self._message is None:
                self._message = message
                self._arrived.set()
                return
        message.nak(delayed=False)
