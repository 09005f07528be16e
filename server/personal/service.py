"""A person takes their data away, or has them erased."""

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
from server.personal import repository
from server.personal.export import export_files
from server.personal.zip_stream import stream_zip

ERASED_AT_ONCE = 100  # who waits for a verdict meanwhile waits for no more than these
GUEST_GRACE = timedelta(days=1)
GUESTS_AT_ONCE = 200  # the service starts only then
PURGED_AT_ONCE = 200
TOO_MANY_EXPORTS = "Vous venez de télécharger vos données : réessayez dans {seconds} s."


class PersonalData:
    """For several threads: each entry opens its own short transactions."""

    def __init__(self, database: Database, settings: Settings, course: Course) -> None:
        self._database, self._settings, self._course = database, settings, course

    def export(self, account: Account) -> Iterator[bytes]:
        """The pieces of a ZIP of all that is kept of this person. Raises TooMany, before the first of them."""
        with self._database.write() as db:
            limits.take_token(db, f"export:{account.id}", self._settings.export_bucket, TOO_MANY_EXPORTS)
        return stream_zip(export_files(self._database, self._course, account.id), utc_now())

    def erase(self, account_id: UUID) -> None:
        """Everything that hangs on the account, then the account: interrupted, it can be asked for again.

        A solution that its teacher has opened to all stays open, without their name. So does a class's log, without
        the names and without the reasons of what was changed about this person.
        """
        erased = ERASED_AT_ONCE
        while erased == ERASED_AT_ONCE:
            with self._database.write() as db:
                erased = repository.delete_submissions(db, account_id, ERASED_AT_ONCE)
        with self._database.write() as db:
            audit.erase_reasons(db, account_id)
            identity.delete_account(db, account_id)

    def erase_lost_guests(self, now: datetime) -> int:
        """Erases some of the guests that nothing leads to any more, and some who have done nothing; how many."""
        with self._database.read() as db:
            lost = repository.unreachable_guest_ids(db, now - GUEST_GRACE, most=GUESTS_AT_ONCE)
        for account_id in lost:
            self.erase(account_id)
        if not self._settings.guest_days:
            return len(lost)
        return len(lost) + self._forget_some_idle(now - timedelta(days=self._settings.guest_days))

    def count_idle_guests(self, before: datetime) -> int:
        """The guests from before that time without any work."""
        with self._database.read() as db:
            return repository.count_idle_guests(db, before)

    def erase_idle_guests(self, before: datetime) -> int:
        """Erases all of them; how many."""
        total = erased = self._forget_some_idle(before)
        while erased == GUESTS_AT_ONCE:
            total += (erased := self._forget_some_idle(before))
        return total

    def _forget_some_idle(self, before: datetime) -> int:
        """Who sends a first file in this very moment keeps it: it is asked again in the transaction that erases."""
        with self._database.write() as db:
            return repository.delete_idle_guests(db, before, most=GUESTS_AT_ONCE)

    def find_expired_students(self, now: datetime) -> Sequence[Account]:
        """Some of the students whom the establishment's settings keep no longer: those of left_days and silent_days."""
        settings = self._settings
        rules = (
            (settings.left_days, repository.departed_student_ids),
            (settings.silent_days, repository.inactive_student_ids),
        )
        with self._database.read() as db:
            found = [
                one for days, find in rules if days for one in find(db, now - timedelta(days=days), PURGED_AT_ONCE)
            ]
            return repository.accounts_by_name(db, found[:PURGED_AT_ONCE])

    def erase_expired_students(self, now: datetime) -> Sequence[Account]:
        """Erases them; who they were. Those that are left are for the next time."""
        erased = self.find_expired_students(now)
        for account in erased:
            self.erase(account.id)
        return erased


def archive_headers(now: datetime) -> dict[str, str]:
    """How it is sent, under which name; it is compressed already."""
    return {
        "Content-Disposition": f'attachment; filename="balise-mes-donnees-{now:%Y-%m-%d}.zip"',
        "Content-Encoding": "identity",
        "Cache-Control": "private, no-store",
    }
