"""Calls again for what the database says is waiting, where the stream does not: a ticket was lost, the stream emptied,
a backup restored.

Each job that waits or is being done has a ticket: the stream holds as many, waiting or in a worker's hands, or more.
What is missing at two looks in a row is called for again. A ticket too many finds no job, and costs one question to
the database; several sweepers name a call alike, and the stream takes it once.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping

from nats.js.errors import NotFoundError
from sqlalchemy.orm import Session

from server.queue import repository
from server.queue.interfaces import JobNotification
from server.queue.jetstream.connection import NatsConnection, NatsUnavailableError
from server.queue.jetstream.stream_layout import STREAM

log = logging.getLogger(__name__)

#: At one look, of each kind.
MOST_CALLS = 2000
LOOK_SECONDS = 5.0
#: Calls of the same job within so many seconds are one.
SLOT_SECONDS = 2.0


class LostMessageSweeper:
    """To be asked to look again and again."""

    def __init__(self, connection: NatsConnection, clock: Callable[[], float] = time.time) -> None:
        self._connection, self._clock = connection, clock
        self._missing: Mapping[str, int] = {}
        self.error = ""

    def resend_missing(self, db: Session) -> int:
        """How many were called for."""
        wanted = repository.count_by_kind(db)  # before the stream is asked: what comes between has its ticket
        try:
            held = self._connection.run_blocking(self._held, LOOK_SECONDS)
        except NatsUnavailableError as down:
            self._missing = {}
            self._say(str(down))
            return 0
        self._say("")
        missing = {kind: wanted.get(kind, 0) - count for kind, count in held.items()}
        twice = {kind: min(count, self._missing.get(kind, 0)) for kind, count in missing.items()}
        self._missing = missing
        return sum(self._call(db, kind, count) for kind, count in twice.items() if count > 0)

    async def _held(self) -> Mapping[str, int]:
        """By kind, the tickets that wait or are in somebody's hands; a stream that is gone is made again."""
        context, layout = self._connection.jetstream, self._connection.layout
        found = {}
        for desk in layout.consumers:
            try:
                one = await context.consumer_info(STREAM, desk.consumer_name)
            except NotFoundError:
                await layout.ensure(context)
                one = await context.consumer_info(STREAM, desk.consumer_name)
            found[desk.kind] = (one.num_pending or 0) + (one.num_ack_pending or 0)
        return found

    def _call(self, db: Session, kind: str, count: int) -> int:
        slot = int(self._clock() / SLOT_SECONDS)
        names = repository.oldest_waiting_ids(db, kind, min(count, MOST_CALLS))
        for name in names:
            self._connection.publish_job_available(JobNotification(kind, f"{name}:again:{slot}"))
        if names:
            log.warning("%d %s jobs waited without a ticket, they are called for again", len(names), kind)
        return len(names)

    def _say(self, amiss: str) -> None:
        if amiss and not self.error:
            log.error("JetStream does not answer: %s", amiss)
        self.error = amiss
