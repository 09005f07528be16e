"""Engine and transactions, the same for SQLite (write-ahead log) and PostgreSQL.

Every transaction is opened at an edge (an HTTP dependency, a worker's step, a command) by `Database.read` or
`Database.write`. On SQLite a writing transaction begins with BEGIN IMMEDIATE: a read that later turns into a write
would otherwise fail, or lose updates.
"""

import logging
import os
import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event, make_url
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.orm import Session, sessionmaker

from server.base import traces
from server.database.base import Base, table_of
from server.database.write_turns import BEGIN_AND_LOCK, BUSY_TIMEOUT, FairLock, begin_in_turn

log = logging.getLogger(__name__)

#: `busy_timeout` comes first: switching a new file to WAL takes an exclusive lock.
PRAGMAS = (BUSY_TIMEOUT, "journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON")
WAL_TIMEOUT, WAL_RETRY_SECONDS = 15.0, 0.01
AFTER_COMMIT = "after_commit"
#: Execution option: how a transaction of SQLite begins.
BEGIN_STATEMENT = "balise_begin"
POOL_SIZE = 10
#: Connections that one process may open: one or two per thread that answers a request.
MAX_CONNECTIONS = 50
#: PostgreSQL rolls back a transaction that has been idle for so long: its process may be frozen while holding locks.
IDLE_TRANSACTION_TIMEOUT = "60s"
#: Options of libpq, by which a server that is gone without a word is given up after a while.
CONNECT_TIMEOUTS: Mapping[str, str] = {
    **{"connect_timeout": "5", "tcp_user_timeout": "15000"},
    **{"keepalives_idle": "10", "keepalives_interval": "5", "keepalives_count": "3"},
}
#: How long a starting process waits for the database, and the pause between two attempts.
STARTUP_TIMEOUT, RETRY_SECONDS = 20.0, 0.5
#: PostgreSQL's SQLSTATE `idle_in_transaction_session_timeout`.
IDLE_TIMEOUT_SQLSTATE = "25P03"
#: PostgreSQL's SQLSTATEs `disk_full` and `read_only_sql_transaction`.
STORAGE_SQLSTATES = frozenset({"53100", "25006"})
#: SQLite's extended codes hold the primary code in their low byte.
SQLITE_PRIMARY_CODE = 0xFF
STORAGE_CODES = frozenset({sqlite3.SQLITE_FULL, sqlite3.SQLITE_READONLY})


def make_engine(url: str) -> Engine:
    """Create an engine for `url`, and the folder of a SQLite file."""
    database_url = make_url(url)
    is_postgres = database_url.get_backend_name() != "sqlite"
    timeouts = {
        name: value for name, value in CONNECT_TIMEOUTS.items() if is_postgres and name not in database_url.query
    }
    engine = create_engine(
        database_url,
        pool_size=POOL_SIZE,
        max_overflow=MAX_CONNECTIONS - POOL_SIZE,
        pool_pre_ping=is_postgres,
        connect_args=timeouts,
        hide_parameters=True,  # they may hold a student's code, which does not belong in the logs
    )
    if is_postgres:
        event.listen(engine, "connect", _configure_postgres)
    else:
        _create_private_file(Path(database_url.database or ""))
        event.listen(engine, "connect", _configure_sqlite)
        event.listen(engine, "begin", partial(_begin_sqlite, FairLock()))
    return engine


def _create_private_file(file: Path) -> None:
    """Create the file of a database for its owner alone: it holds password hashes. Side files take its mode.

    A file that exists is not opened: closing it would drop the locks that this process holds on it (SQLite, "How To
    Corrupt", 2.2), and another process would take it for unused.
    """
    file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with suppress(OSError):  # SQLite gives the reason where the file cannot be written
        os.close(os.open(file, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        return
    for path in (file.parent, *(file.with_name(file.name + suffix) for suffix in ("", "-wal", "-shm"))):
        _remove_rights_of_others(path)


def _remove_rights_of_others(path: Path) -> None:
    """Remove all rights but the owner's, which versions before 1.0 granted. A path of somebody else stays as it is."""
    with suppress(OSError):
        status = path.stat()
        if status.st_uid == os.geteuid() and status.st_mode & 0o077:
            path.chmod(status.st_mode & 0o700)


def writing_engine(engine: Engine) -> Engine:
    """Return the same engine, whose transactions take SQLite's write lock when they begin."""
    return engine.execution_options(**{BEGIN_STATEMENT: BEGIN_AND_LOCK})


def _begin_sqlite(turnstile: FairLock, connection: Connection) -> None:
    """Begin the transaction explicitly: the driver's implicit BEGIN comes after the first read."""
    statement = connection.get_execution_options().get(BEGIN_STATEMENT, "BEGIN")
    begin = partial(connection.exec_driver_sql, statement)
    driver_connection = connection.connection.driver_connection
    if statement == BEGIN_AND_LOCK and driver_connection is not None:
        begin_in_turn(turnstile, driver_connection, begin)
    else:
        begin()


def _configure_sqlite(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # no implicit BEGIN: see `_begin_sqlite`
    for pragma in PRAGMAS:
        _set_pragma(connection, pragma)


def _set_pragma(connection: Any, pragma: str) -> None:
    """Set a pragma, retrying: of two that switch a new file to WAL, SQLite refuses one without waiting."""
    deadline = time.monotonic() + WAL_TIMEOUT
    while True:
        try:
            connection.execute(f"PRAGMA {pragma}")
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() > deadline:
                raise
            time.sleep(WAL_RETRY_SECONDS)
        else:
            return


def _configure_postgres(connection: Any, _record: object) -> None:
    with connection.cursor() as cursor:
        setting = "SELECT set_config('idle_in_transaction_session_timeout', %s, false)"
        cursor.execute(setting, (IDLE_TRANSACTION_TIMEOUT,))
    connection.commit()


def run_after_commit(db: Session, action: Callable[[], None]) -> None:
    """Run `action` once the writing transaction of `db` is committed; never if it is rolled back."""
    db.info.setdefault(AFTER_COMMIT, []).append(action)


def _commit_and_run_actions(db: Session) -> None:
    with traces.span("commit"):
        db.commit()
    for action in db.info.pop(AFTER_COMMIT, ()):
        action()


def commit_then_read(db: Session) -> None:
    """Commit the changes of a writing session, which only reads from then on.

    To be called before a page is built: that takes milliseconds, for which no other writer of SQLite waits.
    """
    _commit_and_run_actions(db)
    _begin_without_write_lock(db)


def roll_back_then_read(db: Session) -> None:
    """Drop the changes of a writing session, which only reads from then on: before the page of a refusal is built."""
    db.rollback()
    db.info.pop(AFTER_COMMIT, None)
    _begin_without_write_lock(db)


def _begin_without_write_lock(db: Session) -> None:
    bind = db.get_bind()
    assert isinstance(bind, Engine)
    db.bind = bind.execution_options(**{BEGIN_STATEMENT: "BEGIN"})


def holds_write_lock(db: Session) -> bool:
    """Whether this session has begun a transaction for which other writers of SQLite wait."""
    return db.in_transaction() and db.get_bind().get_execution_options().get(BEGIN_STATEMENT) == BEGIN_AND_LOCK


def is_lock_timeout(error: OperationalError) -> bool:
    """Whether another writer of SQLite has held the lock for longer than the busy timeout: a retry may succeed."""
    return getattr(error.orig, "sqlite_errorcode", None) in {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}


def is_unavailable(error: DBAPIError) -> bool:
    """Whether PostgreSQL does not answer or has ended the transaction. A retry may succeed; so may the commit have."""
    sqlstate = getattr(error.orig, "sqlstate", None)
    is_lost = error.connection_invalidated or isinstance(error, OperationalError | InterfaceError)
    return (is_lost or sqlstate == IDLE_TIMEOUT_SQLSTATE) and not isinstance(error.orig, sqlite3.Error)


def is_storage_full(error: DBAPIError) -> bool:
    """Whether the database cannot write for want of space, or on a read-only disk: nothing of the transaction stays."""
    sqlite_code = getattr(error.orig, "sqlite_errorcode", 0) & SQLITE_PRIMARY_CODE
    return sqlite_code in STORAGE_CODES or getattr(error.orig, "sqlstate", None) in STORAGE_SQLSTATES


def upsert_statement(db: Session, model: type[Base]) -> sqlite.Insert | postgresql.Insert:
    """Return an INSERT of the database's dialect, which has `on_conflict_do_update` and `on_conflict_do_nothing`."""
    insert = postgresql.insert if db.get_bind().dialect.name == "postgresql" else sqlite.insert
    return insert(table_of(model))


class Database:
    """The transactions of one process."""

    def __init__(self, url: str) -> None:
        self.engine = make_engine(url)
        self._read_sessions = sessionmaker(self.engine, expire_on_commit=False)
        self._write_sessions = sessionmaker(writing_engine(self.engine), expire_on_commit=False)

    @property
    def is_local_file(self) -> bool:
        """Whether the database is a SQLite file: beginning or closing an unused transaction waits for nothing."""
        return self.engine.dialect.name == "sqlite"

    def open_read_session(self) -> Session:
        """Return a session whose changes are dropped; the caller closes it."""
        return self._read_sessions()

    @contextmanager
    def read(self) -> Iterator[Session]:
        """Yield a session whose changes are dropped."""
        with self.open_read_session() as db:
            yield db

    @contextmanager
    def write(self) -> Iterator[Session]:
        """Yield a session that is committed at the end of the block, or rolled back when the block raises."""
        with self._write_sessions() as db:
            yield db
            _commit_and_run_actions(db)

    def wait_until_available(self, seconds: float) -> None:
        """Retry until the database answers. Raise DBAPIError where it still does not after so many seconds."""
        deadline, has_warned = time.monotonic() + seconds, False
        while True:
            try:
                self.engine.connect().close()
                return
            except DBAPIError as error:
                if not is_unavailable(error) or time.monotonic() > deadline:
                    raise
                if not has_warned:
                    log.warning("the database does not answer yet, asking for %g s: %s", seconds, error.orig)
                has_warned = True
            time.sleep(RETRY_SECONDS)

    def close(self) -> None:
        self.engine.dispose()
