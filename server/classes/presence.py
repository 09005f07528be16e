"""When members were last there: noted every few minutes, so that reading a page does not write each time."""

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
    """For several threads; each process of the service knows whom it has looked at lately."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._lately: TTLCache[UUID, bool] = TTLCache(MAX_CACHED_ACCOUNTS, PRESENCE_INTERVAL.total_seconds())
        self._lock = Lock()

    def record(self, db: Session, account: Account | None) -> None:
        """That this account looks at a page, through `db`, which only reads."""
        if account is None or not self._is_new(account.id):
            return
        if repository.is_presence_stale(db, account.id, utc_now() - PRESENCE_INTERVAL):
            with self._database.write() as writing:
                record_presence(writing, account.id)

    def _is_new(self, account_id: UUID) -> bool:
        with self._lock:
            if account_id in self._lately:
                return False
            self._lately[account_id] = True
            return True
