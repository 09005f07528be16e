"""When members were last seen: recorded every few minutes, so that reading a page does not write each time."""

from threading import Lock
from uuid import UUID

from cachetools import TTLCache
from sqlalchemy.orm import Session

from server.classes import repository
from server.classes.service import PRESENCE_INTERVAL, record_presence
from server.database import Database, utc_now
from server.identity.models import Account

MAX_CACHED_ACCOUNTS = 10_000


class PresenceRecorder:
    """Records presence from several threads; each process caches the accounts that it checked recently."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._recent: TTLCache[UUID, bool] = TTLCache(MAX_CACHED_ACCOUNTS, PRESENCE_INTERVAL.total_seconds())
        self._lock = Lock()

    def record(self, db: Session, account: Account | None) -> None:
        """Record that this account reads a page; `db` is a read-only session."""
        if account is None or not self._is_due(account.id):
            return
        if repository.is_presence_stale(db, account.id, utc_now() - PRESENCE_INTERVAL):
            with self._database.write() as write_db:
                record_presence(write_db, account.id)

    def _is_due(self, account_id: UUID) -> bool:
        with self._lock:
            if account_id in self._recent:
                return False
            self._recent[account_id] = True
            return True
