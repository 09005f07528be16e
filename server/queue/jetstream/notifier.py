"""What a committed transaction tells the other machines."""

from collections.abc import Callable

from sqlalchemy.orm import Session

from server.database import run_after_commit
from server.queue.interfaces import JobNotification
from server.queue.jetstream.connection import NatsConnection


class NatsNotifier:
    """`here` is told of changes too, in this process: the server does not send back what it was sent."""

    def __init__(self, connection: NatsConnection, here: Callable[[str], None] | None = None) -> None:
        self._connection, self._here = connection, here

    def job_queued(self, db: Session, call: JobNotification, /) -> None:
        run_after_commit(db, lambda: self._connection.publish_job_available(call))

    def job_changed(self, db: Session, news: str) -> None:
        run_after_commit(db, lambda: self._connection.publish_change(news))
        if self._here is not None:
            here = self._here
            run_after_commit(db, lambda: here(news))
