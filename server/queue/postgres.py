"""The wake-up across machines: LISTEN/NOTIFY on PostgreSQL. A notification leaves with its transaction's commit."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from server.queue.port import Signals

if TYPE_CHECKING:
    import psycopg

log = logging.getLogger(__name__)

QUEUED, CHANGED = "balise_queued", "balise_changed"
RECONNECT_AFTER = 1.0


class PostgresSignals:
    def queued(self, db: Session) -> None:
        db.execute(select(func.pg_notify(QUEUED, "")))

    def changed(self, db: Session, key: str) -> None:
        db.execute(select(func.pg_notify(CHANGED, key)))


class AllSignals:
    """The same signals by several ways."""

    def __init__(self, ways: Sequence[Signals]) -> None:
        self._ways = ways

    def queued(self, db: Session) -> None:
        for way in self._ways:
            way.queued(db)

    def changed(self, db: Session, key: str) -> None:
        for way in self._ways:
            way.changed(db, key)


def listen(url: str, channels: Sequence[str]) -> psycopg.Connection[tuple[object, ...]]:
    """A connection that hears `channels`; `url` is SQLAlchemy's."""
    import psycopg

    connection = psycopg.connect(url.replace("postgresql+psycopg://", "postgresql://", 1), autocommit=True)
    for channel in channels:
        connection.execute(f"LISTEN {channel}".encode())
    return connection


class PostgresSource:
    """A remote worker's source of work. Raises psycopg.OperationalError when the database is lost."""

    def __init__(self, url: str) -> None:
        self._connection = listen(url, [QUEUED])

    def wait(self, seconds: float) -> bool:
        for _ in self._connection.notifies(timeout=seconds, stop_after=1):
            break
        return True


class Listener:
    """A thread of the web process that hears what other machines do; it reconnects when the database comes back."""

    def __init__(self, url: str, on_queued: Callable[[], None], on_changed: Callable[[str], None]) -> None:
        self._url, self._on_queued, self._on_changed = url, on_queued, on_changed
        self.listening = threading.Event()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="postgres-listener", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopping.set()
        self._thread.join(timeout=3)

    def _run(self) -> None:
        import psycopg

        while not self._stopping.is_set():
            try:
                self._hear()
            except psycopg.OperationalError:
                log.exception("the listening connection is lost; trying again")
                self._stopping.wait(RECONNECT_AFTER)

    def _hear(self) -> None:
        with listen(self._url, [QUEUED, CHANGED]) as connection:
            self.listening.set()
            while not self._stopping.is_set():
                for notice in connection.notifies(timeout=0.5):
                    self._dispatch(notice.channel, notice.payload)

    def _dispatch(self, channel: str, payload: str) -> None:
        if channel == QUEUED:
            self._on_queued()
        else:
            self._on_changed(payload)
