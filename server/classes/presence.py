"""When members were last seen: recorded every few minutes, so that reading a page does not write each time."""

from datetime import timedelta
from threading import Lock
from uuid import UUID

from cachetools import TTLCache
from sqlalchemy.orm import Session

from server.classes import repository
from server.database import Database, utc_now
from server.identity.models import Account

PRESENCE_INTERVAL = timedelta(minutes=5)
MAX_CACHED_ACCOUNTS = 10_000


def record_presence(db: Session, account_id: UUID) -> None:
    """Record that a member is present; written every few minutes only."""
    now = utc_now()
    repository.update_last_seen(db, account_id, now, now - PRESENCE_INTERVAL)


def is_active_member(db: Session, account_id: UUID) -> bool:
    """Whether the account is an active member of a class that is not archived, which gives its work priority."""
    return any(archived_at is None for _, archived_at in repository.load_presence(db, account_id))


def record_presence_and_check_membership(db: Session, account_id: UUID) -> bool:
    """Record the account's presence as `record_presence` does, and return `is_active_member`: with one query for
    both."""
    memberships = repository.load_presence(db, account_id)
    since = utc_now() - PRESENCE_INTERVAL
    if any(last_seen is None or last_seen < since for last_seen, _ in memberships):
        record_presence(db, account_id)
    return any(archived_at is None for _, archived_at in memberships)


class PresenceRecorder:
    """Records presence from several threads; each process caches the accounts that it checked recently."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._recent: TTLCache[UUID, bool] = TTLCache(MAX_CACHED_ACCOUNTS, PRESENCE_INTERVAL.total_seconds())
        self._lock = Lock()

    def record(self, db: Session, account: Account | None) -> None:
        """Record that this account reads a page; `db` is a read-only session."""
        if account is None or not self._should_check_now(account.id):
            return
        if repository.is_presence_stale(db, account.id, utc_now() - PRESENCE_INTERVAL):
            with self._database.write() as write_db:
                record_presence(write_db, account.id)

    def _should_check_now(self, account_id: UUID) -> bool:
        with self._lock:
            if account_id in self._recent:
                return False
            self._recent[account_id] = True
            return True
