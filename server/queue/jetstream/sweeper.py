"""Resends messages of jobs that the stream has lost: a crash before publication, an emptied stream, a restored backup.

Each waiting or running job has a message: the stream holds as many or more, pending or being processed. Those missing
at two checks in a row are sent again. A surplus message finds no job, and costs one query; several sweepers use the
same message ids, which the stream deduplicates.
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

#: Maximum number of messages resent at one check, by kind.
MAX_RESENT = 2000
QUERY_SECONDS = 5.0
#: Messages for the same job within so many seconds have the same id.
SLOT_SECONDS = 2.0


class LostMessageSweeper:
    """Checked at intervals."""

    def __init__(self, connection: NatsConnection, clock: Callable[[], float] = time.time) -> None:
        self._connection, self._clock = connection, clock
        self._missing: Mapping[str, int] = {}
        self.error = ""

    def resend_missing(self, db: Session) -> int:
        """Resend what is missing; return how many messages."""
        jobs = repository.count_by_kind(db)  # before the stream is asked: jobs enqueued meanwhile have their message
        try:
            messages = self._connection.run_blocking(self._count_messages, QUERY_SECONDS)
        except NatsUnavailableError as down:
            self._missing = {}
            self._report(str(down))
            return 0
        self._report("")
        missing = {kind: jobs.get(kind, 0) - count for kind, count in messages.items()}
        missing_twice = {kind: min(count, self._missing.get(kind, 0)) for kind, count in missing.items()}
        self._missing = missing
        return sum(self._resend(db, kind, count) for kind, count in missing_twice.items() if count > 0)

    async def _count_messages(self) -> Mapping[str, int]:
        """Count pending and unacknowledged messages by kind; create a missing stream."""
        context, layout = self._connection.jetstream, self._connection.layout
        messages = {}
        for consumer in layout.consumers:
            try:
                info = await context.consumer_info(STREAM, consumer.consumer_name)
            except NotFoundError:
                await layout.create_or_update(context)
                info = await context.consumer_info(STREAM, consumer.consumer_name)
            messages[consumer.kind] = (info.num_pending or 0) + (info.num_ack_pending or 0)
        return messages

    def _resend(self, db: Session, kind: str, count: int) -> int:
        slot = int(self._clock() / SLOT_SECONDS)
        job_ids = repository.oldest_waiting_ids(db, kind, min(count, MAX_RESENT))
        for job_id in job_ids:
            self._connection.publish_job_available(JobNotification(kind, f"{job_id}:again:{slot}"))
        if job_ids:
            log.warning("%d %s jobs waited without a message, which is sent again", len(job_ids), kind)
        return len(job_ids)

    def _report(self, error: str) -> None:
        if error and not self.error:
            log.error("JetStream does not answer: %s", error)
        self.error = error
