"""Sending a file, and finding it again. Every function works inside the caller's transaction."""

import hashlib
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.answers import canonical
from server.base.encoding import encoded
from server.base.errors import Invalid, NotFound, TooMany
from server.base.settings import Settings
from server.classes import service as classes
from server.identity.models import Account
from server.limits import service as limits
from server.queue.port import HeapError, Most, Queue
from server.rights import service as rights
from server.submissions import deals
from server.submissions.deals import SEED_BITS
from server.submissions.models import State, Submission
from server.submissions.senders import sender_of

#: The kind of the job that grades a submission; its key is `key_of` the submission.
GRADE = "grade"
UNKNOWN = "Cette soumission n’existe pas."
TOO_FAST = (
    "Vous avez envoyé beaucoup de propositions en peu de temps : la prochaine est possible dans {seconds} s. "
    "Profitez-en pour relire le dernier verdict."
)
FULL = {
    "sender": "Vos {each} dernières propositions attendent encore leur correction : la suivante sera possible dès que "
    "l’une d’elles sera corrigée.",
    "address": "Beaucoup de propositions envoyées depuis votre adresse attendent encore leur correction : réessayez "
    "dans quelques instants.",
}
FULL_FOR_GUESTS = " Ceux qui ont un compte passent avant les invités, et les classes avant tous."
FULL_SECONDS = 10
UNATTENDED = (
    "En attente : plus rien n’est corrigé depuis un moment. Votre envoi est gardé, et sera corrigé dès que la "
    "correction reprendra. Si cela dure, prévenez votre enseignant."
)


@dataclass(frozen=True)
class Place:
    """Where a submission is on its way; `position` is 1 for the next to be graded, None once it no longer waits.

    Newcomers may come before it, so that its position may go up. `unattended`: nobody grades at present.
    """

    state: State
    position: int | None = None
    unattended: bool = False


class Submissions:
    """Takes submissions in, within the settings' limits, and has them graded."""

    def __init__(self, settings: Settings, queue: Queue, unattended: Callable[[], bool] = lambda: False) -> None:
        self._settings, self._queue, self._unattended = settings, queue, unattended

    def submit(self, db: Session, account: Account, exercise_id: str, code: str, *, address: str) -> Submission:
        """Stores the submission and queues it. Raises TooLarge, TooMany or Invalid, with a sentence in French."""
        source = encoded(code, self._settings.code_bytes)
        return self._store(db, account, address, exercise_id, source, digest(code), secrets.randbits(SEED_BITS))

    def submit_answers(
        self, db: Session, account: Account, exercise_id: str, answers: Mapping[str, Any], *, address: str
    ) -> Submission:
        """Stores answers given without code, to this account's deal, as canonical JSON. Raises as `submit` does."""
        try:
            text = canonical(answers)
        except RecursionError as error:
            raise Invalid("Ces réponses sont trop imbriquées.") from error
        source = encoded(text, self._settings.code_bytes, "Le texte des réponses")
        seed = deals.seed_of(db, account, exercise_id)
        return self._store(db, account, address, exercise_id, source, digest(text), seed)

    def _store(
        self, db: Session, account: Account, address: str, exercise_id: str, source: bytes, digest: str, seed: int
    ) -> Submission:
        limits.take(db, limits.of_submissions(account.id), self._settings.submission_bucket, TOO_FAST)
        submission = Submission(account_id=account.id, exercise=exercise_id, source=source, digest=digest, seed=seed)
        db.add(submission)
        db.flush()
        classes.note_seen(db, account.id)
        most = Most(self._settings.waiting_each, self._settings.waiting_from_address)
        sender = sender_of(account, address, member=classes.is_member(db, account.id))
        try:
            self._queue.put(db, GRADE, key_of(submission.id), sender=sender, most=most)
        except HeapError as error:
            raise TooMany(_full(error, account, most), retry_after=FULL_SECONDS) from error
        return submission

    def place(self, db: Session, submission: Submission) -> Place:
        if submission.grading_id is not None:
            return Place(State.done)
        position = self._queue.position(db, GRADE, key_of(submission.id))
        return Place(State.running) if position == 0 else Place(State.queued, position, self._unattended())


def _full(error: HeapError, account: Account, most: Most) -> str:
    hint = FULL_FOR_GUESTS if error.whose == "address" and account.is_guest else ""
    return FULL[error.whose].format(each=most.each) + hint


def key_of(submission_id: UUID) -> str:
    """By which its job is known, and whoever waits for it."""
    return str(submission_id)


def digest(code: str) -> str:
    """What identifies a changed attempt: blank lines, whole-line comments and trailing spaces do not count."""
    lines = (line.rstrip() for line in code.removeprefix("\ufeff").splitlines())
    code_lines = "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))
    return hashlib.sha256(code_lines.encode("utf-8", errors="replace")).hexdigest()


def parse_id(text: UUID | str) -> UUID:
    """Raises NotFound."""
    try:
        return text if isinstance(text, UUID) else UUID(text)
    except ValueError as error:
        raise NotFound(UNKNOWN) from error


def may_see(db: Session, account: Account | None, submission: Submission) -> bool:
    return rights.may_read_work(db, account, submission.account_id, submission.exercise, submission.created_at)
