"""Engine, transactions, base of the tables, and migrations, for SQLite and PostgreSQL alike."""

from server.database.base import NEVER, Base, UtcDateTime, table_of, utc_now
from server.database.engine import (
    MOST_CONNECTIONS,
    STARTING_SECONDS,
    Database,
    after_commit,
    is_away,
    is_locked,
    upserting,
)
from server.database.prepared import ask, change, loaded, one_of, prepared, rows_of
from server.database.told import Copies, Telling, Told

__all__ = [
    "MOST_CONNECTIONS",
    "NEVER",
    "STARTING_SECONDS",
    "Base",
    "Copies",
    "Database",
    "Telling",
    "Told",
    "UtcDateTime",
    "after_commit",
    "ask",
    "change",
    "is_away",
    "is_locked",
    "loaded",
    "one_of",
    "prepared",
    "rows_of",
    "table_of",
    "upserting",
    "utc_now",
]
