"""Notifications of a committed transaction to other machines."""

from collections.abc import Callable

from sqlalchemy.orm import Session

from server.database import run_after_commit
from server.queue.interfaces import JobNotification
from server.queue.jetstream.connection import NatsConnection


class NatsNotifier:
    """`on_changed` receives changes made by this process too: the server does not echo them."""

    def __init__(self, connection: NatsConnection, on_changed: Callable[[str], None] | None = None) -> None:
        self._connection, self._on_changed = connection, on_changed

    def job_queued(self, db: Session, notification: JobNotification, /) -> None:
        run_after_commit(db, lambda: self._connection.publish_job_available(notification))

    def job_changed(self, db: Session, notification: str) -> None:
        run_after_commit(db, lambda: self._connection.publish_change(notification))
        if self._on_changed is not None:
            on_changed = self._on_changed
            run_after_commit(db, lambda: on_changed(notification))
