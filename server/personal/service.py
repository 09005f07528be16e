"""Export and erasure of a person's data."""

from collections.abc import Iterator, Sequence
from datetime import datetime, timedelta
from uuid import UUID

from server.audit import repository as audit
from server.base.settings import Settings
from server.course import Course
from server.database import Database, utc_now
from server.identity import repository as identity
from server.identity.models import Account
from server.limits import service as limits
from server.personal import erasures, repository
from server.personal.export import iter_export_files
from server.personal.team_copies import give_team_attempts_to_partners
from server.personal.zip_stream import stream_zip

ERASE_BATCH = 100  # bounds how long a transaction delays others
GUEST_GRACE = timedelta(days=1)
GUEST_BATCH = 200  # the service starts only after the first batch
PURGE_BATCH = 200
TOO_MANY_EXPORTS = "Vous venez de télécharger vos données : réessayez dans {seconds} s."


class PersonalDataService:
    """Thread-safe: each method opens its own short transactions."""

    def __init__(self, database: Database, settings: Settings, course: Course) -> None:
        self._database, self._settings, self._course = database, settings, course

    def export(self, account: Account) -> Iterator[bytes]:
        """Yield the chunks of a ZIP of all data of this person. Raises RateLimited before the first one."""
        with self._database.write() as db:
            limits.take_token(db, f"export:{account.id}", self._settings.export_bucket, TOO_MANY_EXPORTS)
        return stream_zip(iter_export_files(self._database, self._course, account.id), utc_now())

    def erase_on_request(self, account_id: UUID, *, by: UUID | None = None, class_id: UUID | None = None) -> bool:
        """Record a request to erase an account, or what it has in a class; carry it out unless a test puts it off.

        `by` None: the person themselves. Return whether it is done. Raises NotFound, or Conflict for the last
        administrator.
        """
        now = utc_now()
        with self._database.write() as db:
            erasures.request_erasure(db, account_id, class_id, by or account_id, now)
            begun = erasures.begin_erasure_if_allowed(db, account_id, class_id, self._settings, now)
        if begun and class_id is None:
            self.erase(account_id)
        return begun

    def carry_out_pending_erasures(self, now: datetime) -> int:
        """Carry out the erasures that nothing puts off any more, or that have stood too long; return how many."""
        with self._database.read() as db:
            requests = erasures.load_pending_erasure_ids(db)
        done = 0
        for account_id, class_id in requests:
            with self._database.write() as db:
                begun = erasures.begin_erasure_if_allowed(db, account_id, class_id, self._settings, now)
            if begun and class_id is None:
                self.erase(account_id)
            done += begun
        return done

    def erase(self, account_id: UUID) -> None:
        """Erase everything that belongs to the account, then the account; after an interruption it can be repeated.

        Solutions that a teacher has opened stay open, without their name. Audit logs of classes stay, without names and
        without the reasons of changes about this person.
        """
        with self._database.write() as db:
            give_team_attempts_to_partners(db, account_id)
        erased = ERASE_BATCH
        while erased == ERASE_BATCH:
            with self._database.write() as db:
                erased = repository.delete_submissions(db, account_id, ERASE_BATCH)
        with self._database.write() as db:
            audit.erase_reasons(db, account_id)
            identity.delete_account(db, account_id)

    def erase_unreachable_and_idle_guests(self, now: datetime) -> int:
        """Erase a batch of unreachable guests, and of idle ones; return how many."""
        with self._database.read() as db:
            guest_ids = repository.load_unreachable_guest_ids(db, now - GUEST_GRACE, limit=GUEST_BATCH)
        for account_id in guest_ids:
            self.erase_on_request(account_id)
        if not self._settings.guest_days:
            return len(guest_ids)
        return len(guest_ids) + self._erase_idle_batch(now - timedelta(days=self._settings.guest_days))

    def count_idle_guests(self, before: datetime) -> int:
        """Count the guests created before a time who have no work."""
        with self._database.read() as db:
            return repository.count_idle_guests(db, before)

    def erase_idle_guests(self, before: datetime) -> int:
        """Erase all of them; return how many."""
        total = erased = self._erase_idle_batch(before)
        while erased == GUEST_BATCH:
            total += (erased := self._erase_idle_batch(before))
        return total

    def _erase_idle_batch(self, before: datetime) -> int:
        """Erase a batch; a guest who submits meanwhile is kept, as the transaction checks again."""
        with self._database.write() as db:
            return repository.delete_idle_guests(db, before, limit=GUEST_BATCH)

    def find_expired_students(self, now: datetime) -> Sequence[Account]:
        """Load a batch of students past the retention settings `left_days` and `silent_days`."""
        settings = self._settings
        rules = (
            (settings.left_days, repository.load_departed_student_ids),
            (settings.silent_days, repository.load_inactive_student_ids),
        )
        with self._database.read() as db:
            account_ids = [
                account_id
                for days, find in rules
                if days
                for account_id in find(db, now - timedelta(days=days), PURGE_BATCH)
            ]
            return repository.load_accounts_sorted_by_name(db, account_ids[:PURGE_BATCH])

    def erase_expired_students(self, now: datetime) -> Sequence[Account]:
        """Erase a batch of them; return who they were. Who has sat a test that is not published waits."""
        return [account for account in self.find_expired_students(now) if self.erase_on_request(account.id)]


def export_archive_headers(now: datetime) -> dict[str, str]:
    """Return the headers of the archive, which is compressed already."""
    return {
        "Content-Disposition": f'attachment; filename="balise-mes-donnees-{now:%Y-%m-%d}.zip"',
        "Content-Encoding": "identity",
        "Cache-Control": "private, no-store",
    }
