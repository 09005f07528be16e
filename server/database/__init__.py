"""Engine, transactions, base of the tables, and migrations, for SQLite and PostgreSQL alike."""

from server.database.base import END_OF_TIME, Base, UtcDateTime, table_of, utc_now
from server.database.engine import (
    MAX_CONNECTIONS,
    STARTUP_TIMEOUT,
    Database,
    is_lock_timeout,
    is_unavailable,
    run_after_commit,
    upsert_statement,
)
from server.database.prepared import ask, change, loaded, one_of, prepared, rows_of
from server.database.told import Copies, Telling, Told

__all__ = [
    "END_OF_TIME",
    "MAX_CONNECTIONS",
    "STARTUP_TIMEOUT",
    "Base",
    "Copies",
    "Database",
    "Telling",
    "Told",
    "UtcDateTime",
    "ask",
    "change",
    "is_lock_timeout",
    "is_unavailable",
    "loaded",
    "one_of",
    "prepared",
    "rows_of",
    "run_after_commit",
    "table_of",
    "upsert_statement",
    "utc_now",
]
