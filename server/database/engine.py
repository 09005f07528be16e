"""Engine and transactions, the same for SQLite (write-ahead log) and PostgreSQL.

Every transaction is opened at an edge (an HTTP dependency, a worker's step, a command) by `Database.read` or
`Database.write`. On SQLite a writing transaction begins with BEGIN IMMEDIATE: a read that later turns into a write
would otherwise fail, or lose updates.
"""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event, make_url
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session, sessionmaker

from server.base import traces
from server.database.base import Base, table_of

#: How long to wait comes first: the mode of a new file is changed by one process at a time.
PRAGMAS = ("busy_timeout=15000", "journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON")
AFTER_COMMIT = "after_commit"
KEPT_CONNECTIONS = 10
#: That one process may open to the database: one or two for each thread that answers somebody.
MOST_CONNECTIONS = 50


def make_engine(url: str) -> Engine:
    """An engine for `url`; a SQLite file's folder is created."""
    checked = not url.startswith("sqlite")
    # What a statement carries is no business of the logs: it may be a student's code.
    engine = create_engine(
        url,
        pool_size=KEPT_CONNECTIONS,
        max_overflow=MOST_CONNECTIONS - KEPT_CONNECTIONS,
        pool_pre_ping=checked,
        hide_parameters=True,
    )
    if engine.dialect.name == "sqlite":
        Path(make_url(url).database or "").parent.mkdir(parents=True, exist_ok=True)
        event.listen(engine, "connect", _prepare_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # the driver would open its transactions by itself, too late
    for pragma in PRAGMAS:
        connection.execute(f"PRAGMA {pragma}")


def _begin_sqlite(connection: Connection) -> None:
    immediate = connection.get_execution_options().get("immediate", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if immediate else "BEGIN")


def after_commit(db: Session, action: Callable[[], None]) -> None:
    """Runs `action` once the writing transaction of `db` is committed (never if it is rolled back)."""
    db.info.setdefault(AFTER_COMMIT, []).append(action)


def is_locked(error: OperationalError) -> bool:
    """Whether another writer of SQLite has outlasted the driver's wait: what failed may be tried again."""
    return getattr(error.orig, "sqlite_errorcode", None) in {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}


def upserting(db: Session, model: type[Base]) -> sqlite.Insert | postgresql.Insert:
    """An INSERT that can say what to do `on_conflict_…`."""
    insert = postgresql.insert if db.get_bind().dialect.name == "postgresql" else sqlite.insert
    return insert(table_of(model))


class Database:
    """The transactions of one process."""

    def __init__(self, url: str) -> None:
        self.engine = make_engine(url)
        self._reads = sessionmaker(self.engine, expire_on_commit=False)
        self._writes = sessionmaker(self.engine.execution_options(immediate=True), expire_on_commit=False)

    @contextmanager
    def read(self) -> Iterator[Session]:
        """A session whose changes are dropped."""
        with self._reads() as db:
            yield db

    @contextmanager
    def write(self) -> Iterator[Session]:
        """A session committed at the end of the block, rolled back when it raises."""
        with self._writes() as db:
            yield db
            with traces.step("commit"):
                db.commit()
            for action in db.info.pop(AFTER_COMMIT, ()):
                action()

    def close(self) -> None:
        self.engine.dispose()
