"""Gradings and what they open. Every function works inside the caller's transaction."""

from collections.abc import Collection, Mapping, Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.assignments import mine
from server.base.errors import NotFound
from server.database import Database, utc_now
from server.gradebook import repository, standings
from server.gradebook.schemas import Attempt, AttemptLine, Attempts, Graded, Progress
from server.gradebook.standings import Counted
from server.identity.models import Account
from server.submissions import deals
from server.submissions import repository as stored
from server.submissions.models import Submission
from server.submissions.service import UNKNOWN, digest, may_see, parse_id


def record(db: Session, submission_id: UUID, graded: Graded) -> UUID | None:
    """Adds a grading, which counts from now on; returns whose it is, None when the submission is gone meanwhile."""
    row = repository.locked(db, submission_id)
    if row is None:
        return None
    account_id, exercise, sent_at, earlier = row
    repository.point(db, submission_id, repository.add(db, submission_id, graded))
    if earlier is not None:
        standings.recount(db, account_id, exercise)
    elif graded.verdict.outcome.counts:
        verdict = graded.verdict
        attempt = Counted(sent_at, verdict.outcome.value, verdict.score, verdict.misconception)
        standings.add(db, account_id, exercise, attempt)
    return account_id


def regraded(db: Session, submission_id: UUID, graded: Graded) -> UUID:
    """Adds a grading that does not count (yet) to a submission's history; returns its name."""
    return repository.add(db, submission_id, graded)


def choose(db: Session, submission_id: UUID, grading_id: UUID) -> None:
    """Has another of a submission's gradings count. Raises NotFound."""
    row = repository.locked(db, submission_id)
    if row is None or not repository.is_of(db, grading_id, submission_id):
        raise NotFound(UNKNOWN)
    repository.point(db, submission_id, grading_id)
    recount(db, row[0], row[1])


def choose_all(db: Session, exercise: str, accounts: Collection[UUID], chosen: Mapping[UUID, UUID]) -> None:
    """The same for many at once: of submissions of these accounts to an exercise, each with a grading of its own.

    The caller has locked the accounts (`standings.lock`), and read what it chooses from since.
    """
    repository.point_all(db, chosen)
    standings.recount_all(db, accounts, exercise)


def recount(db: Session, account_id: UUID, exercise: str | None = None) -> int:
    """Makes an account's standings again from its history; returns how many have changed."""
    return standings.recount(db, account_id, exercise)


def rebuild(database: Database) -> tuple[int, int]:
    """Makes every standing again, one account at a time: others write between. How many there are, and have changed."""
    with database.read() as db:
        accounts = standings.accounts(db)
    changed = 0
    for account_id in accounts:
        with database.write() as db:
            changed += recount(db, account_id)
    with database.read() as db:
        return standings.count(db), changed


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Gives a guest's attempts and deals to the account that the same person has just opened."""
    standings.lock(db, [guest_id, account_id])
    stored.move(db, guest_id, account_id)
    deals.adopt(db, guest_id, account_id)
    for owner in (guest_id, account_id):
        recount(db, owner)


def find(db: Session, account: Account | None, submission_id: UUID | str) -> Attempt:
    """An attempt that this account may see (`server.rights`); raises NotFound for any other, whatever exists."""
    row = repository.attempt(db, parse_id(submission_id))
    if row is None or not may_see(db, account, row[0]):
        raise NotFound(UNKNOWN)
    return Attempt(*row)


def latest(db: Session, account: Account | None, exercise_id: str) -> Attempt | None:
    """One's last attempt at an exercise."""
    row = None if account is None else repository.latest(db, account.id, exercise_id)
    return None if row is None else Attempt(*row)


def attempts(db: Session, account: Account | None, exercise_id: str, most: int, skipped: int = 0) -> Attempts:
    """One's attempts at an exercise, newest first, without the `skipped` newest; empty beyond the oldest."""
    if account is None:
        return Attempts()
    rows = repository.attempts(db, account.id, exercise_id, most=most, skipped=skipped)
    lines = (
        AttemptLine(name, total - place, sent_at, outcome, score)
        for place, (total, name, sent_at, outcome, score) in enumerate(rows, skipped)
    )
    return Attempts(tuple(lines), rows[0][0] if rows else 0)


def sent_before(db: Session, account: Account, exercise_id: str, code: str, version: str) -> Submission | None:
    """One's attempt with this very code, where sending it again to this version of the exercise would tell nothing new.

    None too for an attempt that ended at a limit of time or of memory: it may be tried again; and for one that was
    sent before an assignment opened, which counts nothing of it: sent again it does.
    """
    source = code.encode(errors="surrogatepass")
    found = repository.sent_before(db, account.id, exercise_id, digest=digest(code), source=source, version=version)
    if found is not None and mine.opened_since(db, account.id, exercise_id, found.created_at, utc_now()):
        return None
    return found


def verdict_before(db: Session, submission: Submission) -> Verdict | None:
    """That of its author's attempt just before this one at the exercise."""
    found = repository.before(db, submission)
    return None if found is None else Verdict.from_json(found)


def number_of(db: Session, submission: Submission) -> int:
    """1 for its author's first attempt at the exercise."""
    return repository.count_until(db, submission)


def progress(db: Session, account: Account | None, exercise_id: str | None = None) -> dict[str, Progress]:
    """Where an account stands, by exercise: in all that it has tried, or in one alone."""
    if account is None:
        return {}
    counted = standings.of_account(db, account.id, exercise_id)
    waiting = stored.waiting(db, account.id, exercise_id)
    return {
        name: Progress(sums.best_score, sums.attempts + waiting.get(name, 0), sums.first_success_at is not None)
        for name, sums in counted.items()
    } | {name: Progress(None, count) for name, count in waiting.items() if name not in counted}


def distinct_failed_attempts(
    db: Session, account: Account | None, exercise_id: str, *, besides: Sequence[str] = ()
) -> int:
    """How many different codes have been graded without full marks; `besides`: codes that do not count (starter)."""
    if account is None:
        return 0
    return repository.failed_digests(db, account.id, exercise_id, [digest(code) for code in besides])
