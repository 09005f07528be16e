"""Sending a file, and finding it again. Every function works inside the caller's transaction."""

import hashlib
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4, uuid5

from sqlalchemy.orm import Session

from graders.core.answers import canonical_json
from server.assignments import sittings
from server.base.errors import Invalid, RateLimited
from server.base.settings import Settings
from server.base.validation import encode_bounded, parse_uuid
from server.classes import service as classes
from server.course.models import SEED_BITS, Exercise
from server.database import utc_now
from server.identity.models import Account
from server.limits import service as limits
from server.queue.interfaces import BacklogLimits, Queue, QueueFullError
from server.rights import service as rights
from server.submissions import repository, variants
from server.submissions.models import Submission, SubmissionState
from server.submissions.queue_senders import queue_sender

#: The kind of the job that grades a submission; its key is `key_of` the submission.
GRADE = "grade"
UNKNOWN_SUBMISSION = "Cette soumission n’existe pas."
OTHER_SENDING = "Cette clé (Idempotency-Key) a déjà servi à un autre envoi : choisissez-en une nouvelle."
TOO_FAST = (
    "Vous avez envoyé beaucoup de propositions en peu de temps : la prochaine est possible dans {seconds} s. "
    "Profitez-en pour relire le dernier verdict."
)
TOO_MANY_SAVES = "Vous enregistrez très souvent : le prochain enregistrement est possible dans {seconds} s."
FULL = {
    "sender": "Vos {each} dernières propositions attendent encore leur correction : la suivante sera possible dès que "
    "l’une d’elles sera corrigée.",
    "address": "Beaucoup de propositions envoyées depuis votre adresse attendent encore leur correction : réessayez "
    "dans quelques instants.",
}
FULL_FOR_GUESTS = " Ceux qui ont un compte passent avant les invités, et les classes avant tous."
FULL_SECONDS = 10
OUTDATED_NOTICE = (
    "En attente : cet exercice vient de changer, et votre envoi attend un correcteur de la même version. Il est gardé, "
    "et sera corrigé dans quelques minutes au plus tard."
)
STALLED_NOTICE = (
    "En attente : plus rien n’est corrigé depuis un moment. Votre envoi est gardé, et sera corrigé dès que la "
    "correction reprendra. Si cela dure, prévenez votre enseignant."
)


@dataclass(frozen=True)
class GradingProgress:
    """Where a submission is on its way; `position` is 1 for the next to be graded, None once it no longer waits.

    Newcomers may come before it, so that its position may go up. `unattended`: nobody grades at present. `outdated`:
    those who do have another version of the exercise.
    """

    state: SubmissionState
    position: int | None = None
    stalled: bool = False
    outdated: bool = False

    @property
    def notice(self) -> str | None:
        """What to say of it besides its place."""
        return OUTDATED_NOTICE if self.outdated else STALLED_NOTICE if self.stalled else None


class Submissions:
    """Takes submissions in, within the settings' limits, and has them graded."""

    def __init__(
        self,
        settings: Settings,
        queue: Queue,
        is_stalled: Callable[[], bool] = lambda: False,
        version_of: Callable[[str], str] | None = None,
        reused_exercises: Callable[[str], Sequence[Exercise]] = lambda _: (),
    ) -> None:
        """`version_of` the exercises, as they are shown here: a submission is for graders of the same. `reused`: the
        exercises whose functions the programs of one may import."""
        self._settings, self._queue, self._is_stalled, self._version_of = settings, queue, is_stalled, version_of
        self._reused = reused_exercises

    def submit(
        self, db: Session, account: Account, exercise_id: str, code: str, *, address: str, key: str | None = None
    ) -> Submission:
        """Stores the submission and queues it. Raises TooLarge, TooMany, NotNow or Invalid, in French.

        Sent again under the same `key`, which is the account's own, it is the one that is there.
        """
        return self._submit(db, account, address, exercise_id, self.encode_code(code), key, answers=False)

    def submit_answers(
        self,
        db: Session,
        account: Account,
        exercise_id: str,
        answers: Mapping[str, Any],
        *,
        address: str,
        key: str | None = None,
    ) -> Submission:
        """Stores answers given without code, to this account's deal, as canonical JSON. Otherwise as `submit` does."""
        return self._submit(db, account, address, exercise_id, self.encode_answers(answers), key, answers=True)

    def submit_saved(
        self, db: Session, account: Account, exercise_id: str, source: bytes, sent_at: datetime, *, answers: bool
    ) -> Submission:
        """Stores what a student had saved when their test ended, as if they had sent it then. No limit holds it up."""
        return self._store(db, account, "", exercise_id, source, sent_at, uuid4(), answers=answers)

    def save_work(self, db: Session, account: Account, exercise_id: str, source: bytes) -> datetime:
        """Keeps what is written in a test, to be sent at its end; when. Raises NotNow or TooMany."""
        now = utc_now()
        sittings.save_work(db, account.id, exercise_id, source, now)
        limits.take_token(db, f"save:{account.id}", self._settings.save_bucket, TOO_MANY_SAVES)
        return now

    def encode_code(self, code: str) -> bytes:
        """The file as it is stored. Raises TooLarge or Invalid."""
        return encode_bounded(code, self._settings.code_bytes)

    def encode_answers(self, answers: Mapping[str, Any]) -> bytes:
        """Raises TooLarge or Invalid."""
        try:
            text = canonical_json(answers)
        except RecursionError as error:
            raise Invalid("Ces réponses sont trop imbriquées.") from error
        return encode_bounded(text, self._settings.code_bytes, "Le texte des réponses")

    def _submit(
        self,
        db: Session,
        account: Account,
        address: str,
        exercise_id: str,
        source: bytes,
        key: str | None,
        *,
        answers: bool,
    ) -> Submission:
        now, bucket, name = utc_now(), limits.submission_key(account.id), _name(account, key)
        if key is not None and (before := _sent_as(db, account, name, exercise_id, source)):
            return before
        if not sittings.require_may_submit(db, account.id, exercise_id, now).tests:
            sittings.require_no_tested_imports(db, account.id, source, [one.id for one in self._reused(exercise_id)])
        limits.take_token(db, bucket, self._settings.submission_bucket, TOO_FAST)
        if key is not None and (before := _sent_as(db, account, name, exercise_id, source)):
            limits.give_back_token(db, bucket)  # another process was first: it held the bucket until it had committed
            return before
        most = BacklogLimits(self._settings.waiting_each, self._settings.waiting_from_address)
        try:
            return self._store(db, account, address, exercise_id, source, now, name, answers=answers, most=most)
        except QueueFullError as error:
            raise RateLimited(_full(error, account, most), retry_after=FULL_SECONDS) from error

    def _store(
        self,
        db: Session,
        account: Account,
        address: str,
        exercise_id: str,
        source: bytes,
        sent_at: datetime,
        name: UUID,
        *,
        answers: bool,
        most: BacklogLimits | None = None,
    ) -> Submission:
        seed = variants.get_or_create_seed(db, account, exercise_id) if answers else secrets.randbits(SEED_BITS)
        values = {"source": source, "digest": code_digest(source.decode()), "seed": seed, "created_at": sent_at}
        submission = repository.add(db, id=name, account_id=account.id, exercise=exercise_id, **values)
        sender = queue_sender(account, address, member=classes.is_member(db, account.id, seen=True))
        needs = None if self._version_of is None else version_requirement(exercise_id, self._version_of(exercise_id))
        self._queue.enqueue(db, GRADE, job_key(submission.id), sender=sender, limits=most, required_version=needs)
        return submission

    def requeue(self, db: Session, submission: Submission, account: Account) -> bool:
        """Has it graded (again); False where a job does that already."""
        if self._queue.position(db, GRADE, job_key(submission.id)) is not None:
            return False
        sender = queue_sender(account, "", member=classes.is_member(db, account.id))
        self._queue.enqueue(db, GRADE, job_key(submission.id), sender=sender)
        return True

    def progress(self, db: Session, submission: Submission) -> GradingProgress:
        if submission.grading_id is not None:
            return GradingProgress(SubmissionState.done)
        return self.progress_while_waiting(db, submission.id) or GradingProgress(
            SubmissionState.queued, None, self._is_stalled()
        )

    def progress_while_waiting(self, db: Session, submission_id: UUID) -> GradingProgress | None:
        """By one question, of a submission that is known not to be graded yet; None where its job is there no more."""
        found = self._queue.status(db, GRADE, job_key(submission_id))
        if found is None:
            return None
        if found.position == 0:
            return GradingProgress(SubmissionState.running)
        return GradingProgress(SubmissionState.queued, found.position, self._is_stalled(), found.refused)


def _full(error: QueueFullError, account: Account, most: BacklogLimits) -> str:
    hint = FULL_FOR_GUESTS if error.scope == "address" and account.is_guest else ""
    return FULL[error.scope].format(each=most.per_sender) + hint


def _name(account: Account, key: str | None) -> UUID:
    """Under its sender's key, the same each time; and nobody else's."""
    return uuid4() if key is None else uuid5(account.id, key)


def _sent_as(db: Session, account: Account, name: UUID, exercise_id: str, source: bytes) -> Submission | None:
    """What was sent under this name. Raises Invalid where that was something else."""
    found = repository.by_id(db, name)
    if found is not None and (found.account_id, found.exercise, found.source) != (account.id, exercise_id, source):
        raise Invalid(OTHER_SENDING)
    return found


def version_requirement(exercise_id: str, version: str) -> str:
    """What a worker must have to grade it: that exercise, in that version."""
    return f"{exercise_id}@{version}"


def job_key(submission_id: UUID) -> str:
    """By which its job is known, and whoever waits for it."""
    return str(submission_id)


def code_digest(code: str) -> str:
    """What identifies a changed attempt: blank lines, whole-line comments and trailing spaces do not count."""
    lines = (line.rstrip() for line in code.removeprefix("\ufeff").splitlines())
    code_lines = "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))
    return hashlib.sha256(code_lines.encode("utf-8", errors="replace")).hexdigest()


def parse_submission_id(text: UUID | str) -> UUID:
    """Raises NotFound."""
    return parse_uuid(text, UNKNOWN_SUBMISSION)


def may_view(db: Session, account: Account | None, submission: Submission) -> bool:
    return rights.may_read_work(db, account, submission.account_id, submission.exercise, submission.created_at)
