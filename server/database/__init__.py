"""Engine, transactions, base of the tables, and migrations, for SQLite and PostgreSQL alike."""

from server.database.base import END_OF_TIME, Base, UtcDateTime, table_of, utc_now
from server.database.engine import (
    MAX_CONNECTIONS,
    STARTUP_TIMEOUT,
    Database,
    commit_then_read,
    holds_write_lock,
    is_lock_timeout,
    is_storage_full,
    is_unavailable,
    roll_back_then_read,
    run_after_commit,
    upsert_statement,
)
from server.database.hot_path import (
    detached_instance,
    detached_instances,
    prepared_statement,
    select_core,
    write_core,
)

__all__ = [
    "END_OF_TIME",
    "MAX_CONNECTIONS",
    "STARTUP_TIMEOUT",
    "Base",
    "Database",
    "UtcDateTime",
    "commit_then_read",
    "detached_instance",
    "detached_instances",
    "holds_write_lock",
    "is_lock_timeout",
    "is_storage_full",
    "is_unavailable",
    "prepared_statement",
    "roll_back_then_read",
    "run_after_commit",
    "select_core",
    "table_of",
    "upsert_statement",
    "utc_now",
    "write_core",
]
