"""Sending a file, finding one's attempts again, and what they open (hints, solution).

Every function works inside the caller's transaction; the session's context gives the limits and the signals.
"""

import hashlib
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.answers import canonical
from server.base.encoding import encoded
from server.base.errors import Invalid, NotFound
from server.base.settings import Settings
from server.identity.models import Account
from server.limits import service as limits
from server.queue import service as queue
from server.submissions import draws, repository
from server.submissions.draws import SEED_BITS
from server.submissions.models import SolutionOpening, Submission

TOO_FAST = (
    "Vous avez envoyé beaucoup de propositions en peu de temps : la prochaine est possible dans {seconds} s. "
    "Profitez-en pour relire le dernier verdict."
)


@dataclass(frozen=True)
class Progress:
    """Where one account stands in one exercise; `best` in [0, 1], None while nothing is graded."""

    best: float | None
    attempts: int

    @property
    def succeeded(self) -> bool:
        return self.best == 1


def submit(db: Session, account: Account, exercise_id: str, code: str) -> Submission:
    """Stores the submission and queues it. Raises TooLarge, TooMany or Invalid (each with its sentence in French)."""
    return _store(db, account, exercise_id, code, encoded(code, _settings(db).code_bytes), secrets.randbits(SEED_BITS))


def submit_answers(db: Session, account: Account, exercise_id: str, answers: Mapping[str, Any]) -> Submission:
    """Stores answers given without code, to this account's draw, as canonical JSON. Raises as `submit` does."""
    try:
        text = canonical(answers)
    except RecursionError as error:
        raise Invalid("Ces réponses sont trop imbriquées.") from error
    source = encoded(text, _settings(db).code_bytes, "Le texte des réponses")
    return _store(db, account, exercise_id, text, source, draws.seed_of(db, account, exercise_id))


def _store(db: Session, account: Account, exercise_id: str, code: str, source: bytes, seed: int) -> Submission:
    settings = _settings(db)
    limits.take(db, limits.of_submissions(account.id), settings.submission_bucket, TOO_FAST)
    submission = Submission(
        account_id=account.id,
        exercise=exercise_id,
        source=source,
        digest=digest(code),
        seed=seed,
    )
    queue.enqueue(db, submission)
    return submission


def _settings(db: Session) -> Settings:
    settings = db.info["settings"]
    if not isinstance(settings, Settings):
        raise TypeError("the session's context must hold the settings")
    return settings


def digest(code: str) -> str:
    """What identifies a changed attempt: blank lines, whole-line comments and trailing spaces do not count."""
    lines = (line.rstrip() for line in code.removeprefix("\ufeff").splitlines())
    kept = "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))
    return hashlib.sha256(kept.encode("utf-8", errors="replace")).hexdigest()


def get_for(db: Session, account: Account | None, submission_id: UUID | str) -> Submission:
    """One's own submission (any, for a teacher); raises NotFound for anything else, whatever exists."""
    submission = repository.by_id(db, parse_id(submission_id))
    if submission is None or account is None or not _may_see(account, submission):
        raise NotFound("Cette soumission n’existe pas.")
    return submission


def parse_id(text: UUID | str) -> UUID:
    try:
        return text if isinstance(text, UUID) else UUID(text)
    except ValueError as error:
        raise NotFound("Cette soumission n’existe pas.") from error


def _may_see(account: Account, submission: Submission) -> bool:
    return account.is_teacher or submission.account_id == account.id


def attempts(db: Session, account: Account | None, exercise_id: str) -> Sequence[Submission]:
    """One's submissions to an exercise, newest first."""
    return [] if account is None else repository.of_account(db, account.id, exercise_id)


def progress(db: Session, account: Account | None) -> dict[str, Progress]:
    if account is None:
        return {}
    rows = repository.progress(db, account.id)
    return {exercise: Progress(best, count) for exercise, best, count in rows}


def distinct_failed_attempts(
    db: Session, account: Account | None, exercise_id: str, *, besides: Sequence[str] = ()
) -> int:
    """How many different codes have been graded without full marks; `besides`: codes that do not count (starter)."""
    if account is None:
        return 0
    return repository.failed_digests(db, account.id, exercise_id, [digest(code) for code in besides])


def solution_open(db: Session, account: Account | None, exercise_id: str) -> bool:
    """May this account read the solution? After success, when a teacher has opened it, and always for a teacher."""
    if repository.opening(db, exercise_id) is not None:
        return True
    return account is not None and (account.is_teacher or repository.has_succeeded(db, account.id, exercise_id))


def open_solution(db: Session, exercise_id: str, by: Account) -> None:
    if repository.opening(db, exercise_id) is None:
        db.add(SolutionOpening(exercise=exercise_id, opened_by=by.id))


def close_solution(db: Session, exercise_id: str) -> None:
    repository.delete_opening(db, exercise_id)


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Gives a guest's submissions and draws to the account that the same person has just opened."""
    repository.move(db, guest_id, account_id)
    draws.adopt(db, guest_id, account_id)
