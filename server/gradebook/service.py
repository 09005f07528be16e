"""Gradings and what they open. Every function works inside the caller's transaction."""

from collections.abc import Collection, Mapping
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict
from server.assignments import feedback
from server.base.errors import NotFound
from server.database import Database
from server.gradebook import attempts, repository, standings, verdicts
from server.gradebook.attempts import StoredAttempt
from server.gradebook.models import Grading
from server.gradebook.schemas import Attempt, AttemptLine, Attempts, GradingResult, Progress
from server.gradebook.standings import CountedAttempt, StandingTotals
from server.identity.models import Account
from server.sandbox.values import LIBRARY_MENTION
from server.submissions import deals
from server.submissions import repository as stored
from server.submissions.models import Submission
from server.submissions.service import UNKNOWN, digest, may_see, parse_id


def record_grading(db: Session, submission_id: UUID, graded: GradingResult) -> UUID | None:
    """Adds a grading, which counts from now on; returns whose it is, None when the submission is gone meanwhile."""
    row = repository.lock_submission(db, submission_id)
    if row is None:
        return None
    account_id, exercise, sent_at, earlier = row
    repository.set_counting_grading(db, submission_id, repository.add_grading(db, submission_id, graded))
    if earlier is not None:
        standings.recount(db, account_id, exercise)
    elif graded.verdict.outcome.counts:
        verdict = graded.verdict
        attempt = CountedAttempt(sent_at, verdict.outcome.value, verdict.score, verdict.misconception)
        standings.count_attempt(db, account_id, exercise, attempt)
    return account_id


def add_uncounted_grading(db: Session, submission_id: UUID, graded: GradingResult) -> UUID:
    """Adds a grading that does not count (yet) to a submission's history; returns its name."""
    return repository.add_grading(db, submission_id, graded)


def set_counting_grading(db: Session, submission_id: UUID, grading_id: UUID) -> None:
    """Has another of a submission's gradings count. Raises NotFound."""
    row = repository.lock_submission(db, submission_id)
    if row is None or not repository.is_of(db, grading_id, submission_id):
        raise NotFound(UNKNOWN)
    repository.set_counting_grading(db, submission_id, grading_id)
    recount_standings(db, row[0], row[1])


def set_counting_gradings(db: Session, exercise: str, accounts: Collection[UUID], chosen: Mapping[UUID, UUID]) -> None:
    """The same for many at once: of submissions of these accounts to an exercise, each with a grading of its own.

    The caller has locked the accounts (`standings.lock`), and read what it chooses from since.
    """
    repository.set_counting_gradings(db, chosen)
    standings.recount_all(db, accounts, exercise)


def recount_standings(db: Session, account_id: UUID, exercise: str | None = None) -> int:
    """Makes an account's standings again from its history; returns how many have changed."""
    return standings.recount(db, account_id, exercise)


def rebuild_all_standings(database: Database) -> tuple[int, int]:
    """Makes every standing again, one account at a time: others write between. How many there are, and have changed."""
    with database.read() as db:
        accounts = standings.list_accounts(db)
    changed = 0
    for account_id in accounts:
        with database.write() as db:
            changed += recount_standings(db, account_id)
    with database.read() as db:
        return standings.count_standings(db), changed


def adopt_attempts(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Gives a guest's attempts and deals to the account that the same person has just opened."""
    standings.lock_accounts(db, [guest_id, account_id])
    stored.move(db, guest_id, account_id)
    deals.adopt(db, guest_id, account_id)
    for owner in (guest_id, account_id):
        recount_standings(db, owner)


def find_attempt(db: Session, account: Account | None, submission_id: UUID | str) -> Attempt:
    """An attempt that this account may see (`server.rights`); raises NotFound for any other, whatever exists."""
    found = attempts.load_attempt(db, parse_id(submission_id))
    if found is None or account is None or not may_see(db, account, found.submission):
        raise NotFound(UNKNOWN)
    return _seen(db, account.id, found)


def _seen(db: Session, account_id: UUID, found: StoredAttempt) -> Attempt:
    if not found.may_be_held:
        feedback.remember_no_holds(db, found.submission.account_id, found.submission.exercise)
    return attempt_seen_by(db, account_id, found.submission, found.grading)


def attempt_seen_by(db: Session, account_id: UUID, submission: Submission, grading: Grading | None) -> Attempt:
    """To its author, without what is held back from them; to anybody else who may see it, whole."""
    if submission.account_id != account_id:
        return Attempt(submission, grading)
    known = feedback.load_holds(db, account_id, submission.exercise)
    if known.test_holding(submission.created_at) is None:
        return Attempt(submission, grading, known)
    failed = grading is not None and grading.outcome == Outcome.INTERNAL_ERROR
    return Attempt(submission, None, known, failed)


def find_latest_attempt(db: Session, account: Account | None, exercise_id: str) -> Attempt | None:
    """One's last attempt at an exercise."""
    found = None if account is None else attempts.load_latest_attempt(db, account.id, exercise_id)
    return None if found is None or account is None else _seen(db, account.id, found)


def list_attempts(db: Session, account: Account | None, exercise_id: str, most: int, skipped: int = 0) -> Attempts:
    """One's attempts at an exercise, newest first, without the `skipped` newest; empty beyond the oldest."""
    if account is None:
        return Attempts()
    rows = repository.attempts(db, account.id, exercise_id, most=most, skipped=skipped)
    known = feedback.load_holds(db, account.id, exercise_id)
    lines = (
        AttemptLine(name, total - place, sent_at, None, None, True, outcome == Outcome.INTERNAL_ERROR)
        if known.test_holding(sent_at)
        else AttemptLine(name, total - place, sent_at, outcome, score)
        for place, (total, name, sent_at, outcome, score) in enumerate(rows, skipped)
    )
    return Attempts(tuple(lines), rows[0][0] if rows else 0)


def find_duplicate(db: Session, account: Account, exercise_id: str, code: str, version: str) -> Submission | None:
    """One's attempt with this very code, where sending it again to this version of the exercise would tell nothing new.

    None too for an attempt that ended at a limit of time or of memory: it may be tried again. But of attempts that a
    test holds back any will do, however it ended: whether a new one is made would tell it. And for code that speaks of
    earlier functions, which may be others by now.
    """
    source = code.encode(errors="surrogatepass")
    known = feedback.load_holds(db, account.id, exercise_id)
    if known.refusal or LIBRARY_MENTION in source:
        return None
    file = repository.File(account.id, exercise_id, digest(code), source)
    return repository.sent_before(db, file, version, known.held_since)


def previous_verdict(db: Session, attempt: Attempt) -> Verdict | None:
    """That of its author's attempt just before this one at the exercise."""
    found = repository.before(db, attempt.submission)
    return None if found is None else attempt.feedback.redact(verdicts.read(*found))


def attempt_number(db: Session, submission: Submission) -> int:
    """1 for its author's first attempt at the exercise."""
    return repository.count_until(db, submission)


def load_progress(db: Session, account: Account | None, exercise_id: str | None = None) -> dict[str, Progress]:
    """Where an account stands, by exercise, as it may know it: in all that it has tried, or in one alone."""
    if account is None:
        return {}
    counted = load_visible_standings(db, account.id, exercise_id)
    waiting = stored.waiting(db, account.id, exercise_id)
    waiting = {
        **waiting,
        **stored.waiting_or_since(db, account.id, load_withholding_times(db, account.id, exercise_id)),
    }
    return {
        name: Progress(sums.best_score, sums.attempts + waiting.get(name, 0), sums.first_success_at is not None)
        for name, sums in counted.items()
    } | {name: Progress(None, count) for name, count in waiting.items() if name not in counted}


def load_visible_standings(db: Session, account_id: UUID, exercise_id: str | None = None) -> dict[str, StandingTotals]:
    """An account's standings, as if what tests hold back had not been sent."""
    counted = dict(standings.load_account_standings(db, account_id, exercise_id))
    since = {
        name: when for name, when in load_withholding_times(db, account_id, exercise_id).items() if name in counted
    }
    if since:
        earlier = standings.load_standings_until(db, account_id, since)
        counted = {name: one for name, one in counted.items() if name not in since} | dict(earlier)
    return counted


def load_withholding_times(db: Session, account_id: UUID, exercise_id: str | None = None) -> dict[str, datetime]:
    """From when on attempts are held back, by exercise, in those where some are."""
    if exercise_id is None:
        known = feedback.load_all_holds(db, account_id)
    else:
        known = {exercise_id: feedback.load_holds(db, account_id, exercise_id)}
    return {name: one.held_since for name, one in known.items() if one.held_since is not None}


def count_attempts_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """How many attempts somebody has sent from these times on, graded or not, by exercise, in these alone."""
    return stored.sent_since(db, account_id, since)


def count_internal_errors_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """How many of these we have failed to grade: the one thing that may be told of what a test holds back."""
    return repository.failed_since(db, account_id, since)


def count_distinct_failures(
    db: Session, account: Account | None, exercise_id: str, *, besides: str | None = None
) -> int:
    """How many different codes one knows to have been graded without full marks; `besides`: a code that does not count
    (starter)."""
    if account is None:
        return 0
    held_from = feedback.load_holds(db, account.id, exercise_id).held_since
    uncounted = "" if besides is None else digest(besides)
    return repository.failed_digests(db, account.id, exercise_id, uncounted, held_from)
