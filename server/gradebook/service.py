"""Record gradings, choose the one that counts, and read attempts as an account may see them.

Every function works inside the caller's transaction.
"""

from collections.abc import Collection, Mapping
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict
from server.assignments import feedback
from server.assignments.team_repository import is_teammate
from server.base.errors import NotFound
from server.database import Database
from server.gradebook import early_verdicts, repository, standings
from server.gradebook.attempts import StoredAttempt, load_latest_stored_attempt, load_stored_attempt
from server.gradebook.models import Grading
from server.gradebook.schemas import Attempt, AttemptLine, AttemptList, ExerciseProgress, GradingResult
from server.gradebook.standings import CountedAttempt, StandingTotals
from server.identity.models import Account
from server.sandbox.values import LIBRARY_MENTION
from server.submissions import repository as stored
from server.submissions import variants
from server.submissions.models import Submission
from server.submissions.service import UNKNOWN_SUBMISSION, digest_code, may_view_submission, parse_submission_id


def record_grading(db: Session, submission_id: UUID, graded: GradingResult) -> UUID | None:
    """Add a grading, which counts from now on. Return the author, None where the submission is gone meanwhile."""
    row = repository.lock_submission(db, submission_id)
    if row is None:
        return None
    account_id, exercise, sent_at, earlier_grading = row
    repository.set_counting_grading(db, submission_id, repository.add_grading(db, submission_id, graded))
    if graded.verdict.diagnosis is not None or graded.verdict.outcome is not Outcome.OK:
        early_verdicts.delete_early_verdict(db, submission_id)
    if earlier_grading is not None:
        standings.rebuild_account(db, account_id, exercise)
    elif graded.verdict.outcome.counts:
        verdict = graded.verdict
        attempt = CountedAttempt(sent_at, verdict.outcome.value, verdict.score, verdict.counted_misconception)
        standings.add_attempt_to_standing(db, account_id, exercise, attempt)
    return account_id


def add_uncounted_grading(db: Session, submission_id: UUID, graded: GradingResult) -> UUID:
    """Add a grading that does not count (yet) to the history of a submission. Return its id."""
    return repository.add_grading(db, submission_id, graded)


def set_counting_grading(db: Session, submission_id: UUID, grading_id: UUID) -> None:
    """Make another of a submission's gradings count. Raise NotFound."""
    row = repository.lock_submission(db, submission_id)
    if row is None or not repository.is_grading_of(db, grading_id, submission_id):
        raise NotFound(UNKNOWN_SUBMISSION)
    repository.set_counting_grading(db, submission_id, grading_id)
    rebuild_account_standings(db, row[0], row[1])


def set_counting_gradings(
    db: Session, exercise: str, accounts: Collection[UUID], grading_by_submission: Mapping[UUID, UUID]
) -> None:
    """Make these gradings count, of submissions of these accounts to an exercise.

    The caller has locked the accounts (`standings.lock_accounts`) before it read the gradings.
    """
    repository.set_counting_gradings(db, grading_by_submission)
    standings.rebuild_accounts(db, accounts, exercise)


def rebuild_account_standings(db: Session, account_id: UUID, exercise: str | None = None) -> int:
    """Rebuild an account's standings from its history. Return how many have changed."""
    return standings.rebuild_account(db, account_id, exercise)


def rebuild_all_standings(database: Database) -> tuple[int, int]:
    """Rebuild every standing, one account a transaction. Return how many there are, and how many have changed."""
    with database.read() as db:
        accounts = standings.list_accounts_with_standings(db)
    changed = 0
    for account_id in accounts:
        with database.write() as db:
            changed += rebuild_account_standings(db, account_id)
    with database.read() as db:
        return standings.count_standings(db), changed


def move_guest_attempts(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's attempts and variants to the account that the same person has just opened."""
    standings.lock_accounts(db, [guest_id, account_id])
    stored.move_submissions(db, guest_id, account_id)
    variants.adopt_guest_variants(db, guest_id, account_id)
    for owner in (guest_id, account_id):
        rebuild_account_standings(db, owner)


def hand_over_attempts(db: Session, account_id: UUID, heir_id: UUID, submissions: Collection[UUID]) -> None:
    """Give attempts to another account, for which they count too."""
    standings.lock_accounts(db, [account_id, heir_id])
    stored.give_submissions_to(db, submissions, heir_id)
    for owner in (account_id, heir_id):
        rebuild_account_standings(db, owner)


def find_attempt(db: Session, account: Account | None, submission_id: UUID | str) -> Attempt:
    """Return an attempt that this account may see (`server.rights`), or that a partner has sent for both.

    Raise NotFound for any other, existing or not.
    """
    attempt = load_stored_attempt(db, parse_submission_id(submission_id))
    if attempt is None or account is None:
        raise NotFound(UNKNOWN_SUBMISSION)
    if may_view_submission(db, account, attempt.submission):
        return _stored_attempt_seen_by(db, account.id, attempt)
    return _attempt_shared_by_teammate(db, account.id, attempt)


def _attempt_shared_by_teammate(db: Session, account_id: UUID, attempt: StoredAttempt) -> Attempt:
    """Return an attempt of somebody with whom the account hands in, without what is withheld from either of them.

    Raise NotFound for the attempt of anybody else, or of a test.
    """
    submission = attempt.submission
    author, exercise, sent_at = submission.account_id, submission.exercise, submission.created_at
    if not is_teammate(db, account_id, author, exercise, sent_at):
        raise NotFound(UNKNOWN_SUBMISSION)
    holds = feedback.load_holds(db, author, exercise)
    own = feedback.load_holds(db, account_id, exercise)
    if holds.find_withholding_test(sent_at) is not None or own.find_withholding_test(sent_at) is not None:
        raise NotFound(UNKNOWN_SUBMISSION)
    return Attempt(submission, attempt.grading, own, shared=True)


def _stored_attempt_seen_by(db: Session, account_id: UUID, attempt: StoredAttempt) -> Attempt:
    if not attempt.may_be_held:
        feedback.memoise_no_holds(db, attempt.submission.account_id, attempt.submission.exercise)
    return attempt_seen_by(db, account_id, attempt.submission, attempt.grading)


def attempt_seen_by(db: Session, account_id: UUID, submission: Submission, grading: Grading | None) -> Attempt:
    """Return an attempt without what is withheld from its author; whole for anybody else who may see it."""
    if submission.account_id != account_id:
        return Attempt(submission, grading)
    holds = feedback.load_holds(db, account_id, submission.exercise)
    if holds.find_withholding_test(submission.created_at) is None:
        return Attempt(submission, grading, holds)
    failed = grading is not None and grading.outcome == Outcome.INTERNAL_ERROR
    load_error = "" if grading is None else grading.verdict.get("load_error", "")
    return Attempt(submission, None, holds, failed, load_error)


def find_latest_attempt(db: Session, account: Account | None, exercise_id: str) -> Attempt | None:
    """Return the account's last attempt at an exercise."""
    attempt = None if account is None else load_latest_stored_attempt(db, account.id, exercise_id)
    return None if attempt is None or account is None else _stored_attempt_seen_by(db, account.id, attempt)


def list_attempts(db: Session, account: Account | None, exercise_id: str, limit: int, offset: int = 0) -> AttemptList:
    """Return the account's attempts at an exercise, newest first, without the `offset` newest."""
    if account is None:
        return AttemptList()
    rows = repository.list_attempts_with_total(db, account.id, exercise_id, limit=limit, offset=offset)
    holds = feedback.load_holds(db, account.id, exercise_id)
    held = {row.id for row in rows if holds.find_withholding_test(row.created_at)}
    not_loaded = repository.load_ids_of_files_not_run(db, held) if held else frozenset()
    lines = (
        AttemptLine(
            id, total - index, sent_at, None, None, True, outcome == Outcome.INTERNAL_ERROR, id not in not_loaded
        )
        if id in held
        else AttemptLine(id, total - index, sent_at, outcome, score)
        for index, (total, id, sent_at, outcome, score) in enumerate(rows, offset)
    )
    return AttemptList(tuple(lines), rows[0][0] if rows else 0)


def find_duplicate(db: Session, account: Account, exercise_id: str, code: str, version: str) -> Submission | None:
    """Return the account's attempt with the same code, where grading it again in this version gives the same verdict.

    An attempt that met a limit of time or memory is no duplicate, as it may be tried again; nor is code that imports
    earlier functions, which may have changed. Where a test withholds verdicts, every attempt is a duplicate, however
    it ended: otherwise a new attempt would reveal how the first one ended.
    """
    source = code.encode(errors="surrogatepass")
    holds = feedback.load_holds(db, account.id, exercise_id)
    if holds.submission_refusal or LIBRARY_MENTION in source:
        return None
    file = repository.SentFile(account.id, exercise_id, digest_code(code), source)
    return repository.find_duplicate(db, file, version, holds.held_since)


def load_previous_verdict(db: Session, attempt: Attempt) -> Verdict | None:
    """Return the verdict of the attempt just before this one, of the same author at the same exercise."""
    verdict = repository.load_previous_verdict(db, attempt.submission)
    return None if verdict is None else attempt.feedback.remove_withheld_parts(Verdict.from_json(verdict))


def attempt_number(db: Session, submission: Submission) -> int:
    """Return 1 for the author's first attempt at the exercise, and so on."""
    return repository.count_attempts_up_to(db, submission)


def load_progress(db: Session, account: Account | None, exercise_id: str | None = None) -> dict[str, ExerciseProgress]:
    """Return an account's progress as it may know it, by exercise: in all that it has tried, or in one alone."""
    if account is None:
        return {}
    visible = load_visible_standings(db, account.id, exercise_id)
    held_since = load_withholding_times(db, account.id, exercise_id)
    waiting = {
        **stored.count_ungraded_by_exercise(db, account.id, exercise_id),
        **stored.count_ungraded_or_sent_since(db, account.id, held_since),
    }
    graded = {
        exercise: ExerciseProgress(
            own.best_score, own.attempts + waiting.get(exercise, 0), own.first_success_at is not None
        )
        for exercise, own in visible.items()
    }
    return {**{exercise: ExerciseProgress(None, count) for exercise, count in waiting.items()}, **graded}


def load_visible_standings(db: Session, account_id: UUID, exercise_id: str | None = None) -> dict[str, StandingTotals]:
    """Return an account's standings as if the attempts that tests withhold had not been sent."""
    totals = dict(standings.load_account_standings(db, account_id, exercise_id))
    held_since = load_withholding_times(db, account_id, exercise_id)
    held_since = {exercise: since for exercise, since in held_since.items() if exercise in totals}
    if not held_since:
        return totals
    visible = {exercise: own for exercise, own in totals.items() if exercise not in held_since}
    return visible | dict(standings.load_standings_until(db, account_id, held_since))


def load_withholding_times(db: Session, account_id: UUID, exercise_id: str | None = None) -> dict[str, datetime]:
    """Return from when on attempts are withheld, by exercise, where some are."""
    if exercise_id is None:
        holds = feedback.load_holds_by_exercise(db, account_id)
    else:
        holds = {exercise_id: feedback.load_holds(db, account_id, exercise_id)}
    return {exercise: own.held_since for exercise, own in holds.items() if own.held_since is not None}


def count_attempts_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """Count an account's attempts sent from these times on, graded or not, by exercise."""
    return stored.count_sent_since(db, account_id, since)


def count_internal_errors_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """Count those that ended as an internal error: all that may be said of withheld attempts."""
    return repository.count_internal_errors_since(db, account_id, since)


def count_distinct_failures(
    db: Session, account: Account | None, exercise_id: str, *, besides: str | None = None
) -> int:
    """Count the different codes whose failure the account knows of, but for `besides` (the starter code)."""
    if account is None:
        return 0
    held_since = feedback.load_holds(db, account.id, exercise_id).held_since
    excluded_digest = "" if besides is None else digest_code(besides)
    return repository.count_distinct_failures(db, account.id, exercise_id, excluded_digest, held_since)
