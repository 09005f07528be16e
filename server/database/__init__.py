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

__all__ = [
    "END_OF_TIME",
    "MAX_CONNECTIONS",
    "STARTUP_TIMEOUT",
    "Base",
    "Database",
    "UtcDateTime",
    "is_lock_timeout",
    "is_unavailable",
    "run_after_commit",
    "table_of",
    "upsert_statement",
    "utc_now",
]
