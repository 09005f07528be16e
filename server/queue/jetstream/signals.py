"""What a committed transaction tells the other machines."""

from collections.abc import Callable

from sqlalchemy.orm import Session

from server.database import run_after_commit
from server.queue.jetstream.connection import Connection
from server.queue.port import Call


class NatsSignals:
    """`here` is told of changes too, in this process: the server does not send back what it was sent."""

    def __init__(self, connection: Connection, here: Callable[[str], None] | None = None) -> None:
        self._connection, self._here = connection, here

    def queued(self, db: Session, call: Call, /) -> None:
        run_after_commit(db, lambda: self._connection.call(call))

    def changed(self, db: Session, news: str) -> None:
        run_after_commit(db, lambda: self._connection.tell(news))
        if self._here is not None:
            here = self._here
            run_after_commit(db, lambda: here(news))
