"""Engine and transactions, the same for SQLite (write-ahead log) and PostgreSQL.

Every transaction is opened at an edge (an HTTP dependency, a worker's step, a command) by `Database.read` or
`Database.write`. On SQLite a writing transaction begins with BEGIN IMMEDIATE: a read that later turns into a write
would otherwise fail, or lose updates.
"""

import logging
import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, create_engine, event, make_url
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.orm import Session, sessionmaker

from server.base import traces
from server.database.base import Base, table_of
from server.database.beginning import DRIVER, writing

log = logging.getLogger(__name__)

#: How long to wait comes first: the mode of a new file is changed by one process at a time.
PRAGMAS = ("busy_timeout=15000", "journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON")
MODE_SECONDS, MODE_PAUSE = 15.0, 0.01
AFTER_COMMIT = "after_commit"
KEPT_CONNECTIONS = 10
#: That one process may open to the database: one or two for each thread that answers somebody.
MAX_CONNECTIONS = 50
#: Of PostgreSQL, in its own units: a transaction in which its process has said nothing for so long is undone, for it
#: may be frozen, and what it has locked is waited for. A server that is gone without a word is given up after a while.
IDLE_TRANSACTION = "60s"
REACHING: Mapping[str, str] = {
    **{"connect_timeout": "5", "tcp_user_timeout": "15000"},
    **{"keepalives_idle": "10", "keepalives_interval": "5", "keepalives_count": "3"},
}
#: How long who starts waits for it, and between two questions.
STARTUP_TIMEOUT, AGAIN_SECONDS = 20.0, 0.5
#: By which PostgreSQL says that it has undone such a transaction.
ENDED_IDLE = "25P03"


def make_engine(url: str) -> Engine:
    """An engine for `url`; a SQLite file's folder is created."""
    asked = make_url(url)
    checked = asked.get_backend_name() != "sqlite"
    reaching = {name: value for name, value in REACHING.items() if checked and name not in asked.query}
    # What a statement carries is no business of the logs: it may be a student's code.
    engine = create_engine(
        asked if checked else asked.set(drivername=f"sqlite+{DRIVER}"),
        pool_size=KEPT_CONNECTIONS,
        max_overflow=MAX_CONNECTIONS - KEPT_CONNECTIONS,
        pool_pre_ping=checked,
        connect_args=reaching,
        hide_parameters=True,
    )
    if checked:
        event.listen(engine, "connect", _prepare_postgres)
    else:
        Path(asked.database or "").parent.mkdir(parents=True, exist_ok=True)
        event.listen(engine, "connect", _prepare_sqlite)
    return engine


def _prepare_sqlite(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # the driver would open its transactions by itself, too late
    for pragma in PRAGMAS:
        _set(connection, pragma)


def _set(connection: Any, pragma: str) -> None:
    """Where two change the mode of a new file, SQLite refuses one of them without waiting: it asks again."""
    deadline = time.monotonic() + MODE_SECONDS
    while True:
        try:
            connection.execute(f"PRAGMA {pragma}")
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() > deadline:
                raise
            time.sleep(MODE_PAUSE)
        else:
            return


def _prepare_postgres(connection: Any, _record: object) -> None:
    with connection.cursor() as cursor:
        cursor.execute("SELECT set_config('idle_in_transaction_session_timeout', %s, false)", (IDLE_TRANSACTION,))
    connection.commit()


def run_after_commit(db: Session, action: Callable[[], None]) -> None:
    """Runs `action` once the writing transaction of `db` is committed (never if it is rolled back)."""
    db.info.setdefault(AFTER_COMMIT, []).append(action)


def is_lock_timeout(error: OperationalError) -> bool:
    """Whether another writer of SQLite has outlasted the driver's wait: what failed may be tried again."""
    return getattr(error.orig, "sqlite_errorcode", None) in {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}


def is_unavailable(error: DBAPIError) -> bool:
    """Whether PostgreSQL does not answer now, or has cut the transaction off: what failed may be tried again, and its
    commit may yet have succeeded."""
    state = getattr(error.orig, "sqlstate", None)
    ours = error.connection_invalidated or isinstance(error, OperationalError | InterfaceError) or state == ENDED_IDLE
    return ours and not isinstance(error.orig, sqlite3.Error)


def upsert_statement(db: Session, model: type[Base]) -> sqlite.Insert | postgresql.Insert:
    """An INSERT that can say what to do `on_conflict_…`."""
    insert = postgresql.insert if db.get_bind().dialect.name == "postgresql" else sqlite.insert
    return insert(table_of(model))


class Database:
    """The transactions of one process."""

    def __init__(self, url: str) -> None:
        self.engine = make_engine(url)
        self._reads = sessionmaker(self.engine, expire_on_commit=False)
        self._writes = sessionmaker(writing(self.engine), expire_on_commit=False)

    @property
    def is_local_file(self) -> bool:
        """Whether it is a file: nothing is waited for where nothing is read or written."""
        return self.engine.dialect.name == "sqlite"

    def open_read_session(self) -> Session:
        """A session whose changes are dropped, which the caller closes."""
        return self._reads()

    @contextmanager
    def read(self) -> Iterator[Session]:
        """A session whose changes are dropped."""
        with self.open_read_session() as db:
            yield db

    @contextmanager
    def write(self) -> Iterator[Session]:
        """A session committed at the end of the block, rolled back when it raises."""
        with self._writes() as db:
            yield db
            with traces.span("commit"):
                db.commit()
            for action in db.info.pop(AFTER_COMMIT, ()):
                action()

    def wait_until_available(self, seconds: float) -> None:
        """Until it answers; raises DBAPIError where it still does not after so long. Starting is dear, and a database
        that restarts is back soon."""
        deadline, told = time.monotonic() + seconds, False
        while True:
            try:
                self.engine.connect().close()
                return
            except DBAPIError as error:
                if not is_unavailable(error) or time.monotonic() > deadline:
                    raise
                if not told:
                    log.warning("the database does not answer yet, asking for %g s: %s", seconds, error.orig)
                told = True
            time.sleep(AGAIN_SECONDS)

    def close(self) -> None:
        self.engine.dispose()
