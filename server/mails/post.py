"""The thread of the web process that composes and sends the mails that are due."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from datetime import datetime
from email.message import EmailMessage
from threading import Event, Thread
from typing import Protocol
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.database import Database, utc_now
from server.mails import outbox, smtp
from server.mails.errors import MailError

log = logging.getLogger(__name__)

LOOK_SECONDS = 20.0
STOP_SECONDS = 5.0
#: Of one look; the others wait for the next.
BATCH = 100
#: Failures in a row, of the server and not of an address, after which a look ends.
MAX_FAILURES = 3

Send = Callable[[Settings, EmailMessage, Callable[[], None]], None]


class _MailStopped(Exception):
    """A mail was stopped after it was composed."""


class MailComposer(Protocol):
    """Knows what is to be told, and to whom."""

    def list_due(self, db: Session, now: datetime) -> Collection[tuple[UUID, str]]:
        """Return the mails that have become due and are not queued: subscription and key."""

    def compose(self, db: Session, sending: outbox.OutgoingMail, now: datetime) -> EmailMessage | None:
        """Return the message, reading; None where nothing is to be told any more, to nobody."""


class MailSender:
    """Sends mails one by one, in short transactions: none is open while the server answers."""

    def __init__(
        self,
        database: Database,
        settings: Settings,
        composer: MailComposer,
        send: Send = smtp.send_message,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self._database, self._settings, self._composer = database, settings, composer
        self._send, self._clock = send, clock

    def start(self) -> Callable[[], None]:
        """Work in a thread of its own; return what stops it, and waits a little for a server that answers slowly."""
        stopping = Event()
        thread = Thread(target=self.run_until, args=(stopping,), name="mails", daemon=True)
        thread.start()

        def stop() -> None:
            stopping.set()
            thread.join(STOP_SECONDS)

        return stop

    def run_until(self, stopping: Event) -> None:
        """Work until `stopping` is set. After an error, try again at the next look."""
        while not stopping.wait(LOOK_SECONDS):
            try:
                self.work(stopping)
            except Exception:
                log.exception("mails could not be sent; trying again later")

    def work(self, stopping: Event | None = None) -> int:
        """Queue what is due and send it; return how many messages the server has taken."""
        now = self._clock()
        with self._database.read() as db:
            due = self._composer.list_due(db, now)
            if not due and not outbox.has_due_mail(db, now):
                return 0
        with self._database.write() as db:
            outbox.end_mails_lost_after_handover(db, now)
            for subscription_id, key in due:
                outbox.queue_mail(db, subscription_id, key, now)
        taken = failures = 0
        for _ in range(BATCH):
            if failures >= MAX_FAILURES or (stopping is not None and stopping.is_set()):
                break
            with self._database.write() as db:
                sending = outbox.take_next_due_mail(db, self._clock())
            if sending is None:
                break
            has_left, error = self._deliver(sending)
            taken += has_left
            failures = failures + 1 if error is not None and not error.is_address else 0
        return taken

    def _deliver(self, sending: outbox.OutgoingMail) -> tuple[bool, MailError | None]:
        """Return whether the server has taken the message, and its refusal."""
        with self._database.read() as db:
            message = self._composer.compose(db, sending, self._clock())
        if message is None:
            with self._database.write() as db:
                outbox.drop_mail(db, sending, self._clock())
            return False, None

        def on_handover() -> None:
            with self._database.write() as db:
                if not outbox.record_handover(db, sending, self._clock()):
                    raise _MailStopped

        error = None
        try:
            self._send(self._settings, message, on_handover)
        except _MailStopped:
            return False, None
        except MailError as failure:
            error = failure
            log.warning("a mail was not sent (try %d): %s", sending.tries, failure.reason)
        with self._database.write() as db:
            outbox.record_result(db, sending, error, self._clock())
        return error is None, error
