"""Creating and finding submissions. Every function works inside the caller's transaction."""

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
from server.base.arrival import arrival_time
from server.base.errors import Invalid, RateLimited, StorageFull
from server.base.files import MIN_FREE_BYTES, free_bytes
from server.base.settings import BucketSettings, Settings
from server.base.validation import encode_bounded, parse_uuid
from server.classes import presence
from server.course.models import SEED_BITS, Exercise
from server.identity.models import Account
from server.limits import service as limits
from server.queue.interfaces import BacklogLimits, Queue, QueueFullError
from server.rights import service as rights
from server.submissions import repository, variants
from server.submissions.models import Submission, SubmissionState
from server.submissions.queue_senders import sender_of_account

#: Kind of the job that grades a submission; its key is `job_key(submission.id)`.
GRADE = "grade"
UNKNOWN_SUBMISSION = "Cette soumission n’existe pas."
KEY_REUSED = "Cette clé (Idempotency-Key) a déjà servi à un autre envoi : choisissez-en une nouvelle."
TOO_FAST = (
    "Vous avez envoyé beaucoup de propositions en peu de temps : la prochaine est possible dans {seconds} s. "
    "Profitez-en pour relire le dernier verdict."
)
STORAGE_USED = {
    "account": "Vous avez envoyé énormément ces derniers jours : la place réservée à vos propositions est pleine, et "
    "se libère peu à peu. Celle-ci sera acceptée dans {seconds} s ; plus courte, plus tôt.",
    "address": "La place réservée, à votre adresse, aux personnes qui ne sont dans aucune classe est pleine, et se "
    "libère peu à peu. Cette proposition sera acceptée dans {seconds} s ; d’un élève d’une classe, tout de suite.",
}
DISK_NEARLY_FULL = (
    "Le disque du serveur est presque plein : ce qui reste est gardé aux élèves des classes. Votre proposition "
    "n’est pas enregistrée. Gardez-la, et renvoyez-la plus tard, ou rejoignez votre classe."
)
#: Room on the disk below which only members of classes may store, and seconds after which others may try again.
MIN_FREE_FOR_STRANGERS, DISK_RETRY_SECONDS = 2 * MIN_FREE_BYTES, 3600
#: KiB that a submission takes besides its source: its verdict, figures and films.
VERDICT_KIB = 16
#: Accounts' shares of storage that all strangers of an address have together: anybody becomes any number of guests.
STRANGERS_SHARES = 32
TOO_MANY_SAVES = "Vous enregistrez très souvent : le prochain enregistrement est possible dans {seconds} s."
QUEUE_FULL = {
    "sender": "Vos {each} dernières propositions attendent encore leur correction : la suivante sera possible dès que "
    "l’une d’elles sera corrigée.",
    "address": "Beaucoup de propositions envoyées depuis votre adresse attendent encore leur correction : réessayez "
    "dans quelques instants.",
}
QUEUE_FULL_FOR_GUESTS = " Ceux qui ont un compte passent avant les invités, et les classes avant tous."
QUEUE_FULL_RETRY_SECONDS = 10
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
    """Progress of a submission; `position` is 1 for the next to be graded, None once it no longer waits.

    Newcomers may go first, so that the position may grow. `stalled`: no worker grades now. `outdated`: the workers
    have another version of it.
    """

    state: SubmissionState
    position: int | None = None
    stalled: bool = False
    outdated: bool = False

    @property
    def notice(self) -> str | None:
        """What to tell the student besides the position."""
        return OUTDATED_NOTICE if self.outdated else STALLED_NOTICE if self.stalled else None


class SubmissionService:
    """Stores submissions within the settings' limits, and has them graded."""

    def __init__(
        self,
        settings: Settings,
        queue: Queue,
        is_stalled: Callable[[], bool] = lambda: False,
        needed_version: Callable[[str], str | None] = lambda _: None,
        reused_exercises: Callable[[str], Sequence[Exercise]] = lambda _: (),
    ) -> None:
        """`needed_version` returns the version of an exercise as shown here, where the graders must have it.

        `reused_exercises` returns the exercises whose functions the programs of one may import.
        """
        self._settings, self._queue, self._is_stalled = settings, queue, is_stalled
        self._needed_version, self._reused_exercises = needed_version, reused_exercises

    def submit(
        self, db: Session, account: Account, exercise_id: str, code: str, *, address: str, key: str | None = None
    ) -> Submission:
        """Store a submission and enqueue it. Raises TooLarge, RateLimited, WrongMoment or Invalid, in French.

        Submitted again under the same idempotency `key` of this account, return the stored one.
        """
        return self._submit_source(db, account, address, exercise_id, self.encode_code(code), key, answers=False)

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
        """Store answers without code to this account's variant, as canonical JSON. Otherwise as `submit`."""
        return self._submit_source(db, account, address, exercise_id, self.encode_answers(answers), key, answers=True)

    def submit_saved_work(
        self, db: Session, account: Account, exercise_id: str, source: bytes, sent_at: datetime, *, answers: bool
    ) -> Submission:
        """Store what a student had saved as their test ended, as if submitted then; no limit applies."""
        is_member = presence.record_presence_and_check_membership(db, account.id)
        return self._store_and_enqueue(
            db, account, "", exercise_id, source, sent_at, uuid4(), answers=answers, is_member=is_member
        )

    def save_work(
        self, db: Session, account: Account, exercise_id: str, source: bytes, base_version: str | None = None
    ) -> datetime:
        """Save work in progress of a test, to be submitted at its end; return when.

        Raises WrongMoment, RateLimited, or StaleWorkError where other work was saved since `base_version`.
        """
        now = arrival_time()
        sittings.save_work(db, account.id, exercise_id, source, now, base_version=base_version)
        limits.take_token(db, f"save:{account.id}", self._settings.save_bucket, TOO_MANY_SAVES)
        return now

    def encode_code(self, code: str) -> bytes:
        """Return the file as stored. Raises TooLarge or Invalid."""
        return encode_bounded(code, self._settings.code_bytes)

    def encode_answers(self, answers: Mapping[str, Any]) -> bytes:
        """Return the answers as stored. Raises TooLarge or Invalid."""
        try:
            text = canonical_json(answers)
        except RecursionError as error:
            raise Invalid("Ces réponses sont trop imbriquées.") from error
        return encode_bounded(text, self._settings.code_bytes, "Le texte des réponses")

    def _submit_source(
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
        now, submission_id = arrival_time(), _derive_submission_id(account, key)
        if key is not None and (stored := _find_resubmission(db, account, submission_id, exercise_id, source)):
            return stored
        if not sittings.require_may_submit(db, account.id, exercise_id, now).tests:
            sittings.require_no_tested_imports(
                db, account.id, source, [exercise.id for exercise in self._reused_exercises(exercise_id)]
            )
        is_member = presence.record_presence_and_check_membership(db, account.id)
        if not is_member and free_bytes(self._settings.data_dir) < MIN_FREE_FOR_STRANGERS:
            raise StorageFull(DISK_NEARLY_FULL, retry_after=DISK_RETRY_SECONDS)
        draws = self._rate_limit_draws(account, len(source), None if is_member else address)
        limits.take_tokens(db, *draws)
        if key is not None and (stored := _find_resubmission(db, account, submission_id, exercise_id, source)):
            for draw in draws:  # another process was first, and held the buckets until its commit
                limits.give_back_token(db, draw.key, draw.count)
            return stored
        backlog_limits = BacklogLimits(self._settings.waiting_each, self._settings.waiting_from_address)
        try:
            return self._store_and_enqueue(
                db,
                account,
                address,
                exercise_id,
                source,
                now,
                submission_id,
                answers=answers,
                is_member=is_member,
                backlog_limits=backlog_limits,
            )
        except QueueFullError as error:
            raise RateLimited(
                _queue_full_message(error, account, backlog_limits), retry_after=QUEUE_FULL_RETRY_SECONDS
            ) from error

    def _store_and_enqueue(
        self,
        db: Session,
        account: Account,
        address: str,
        exercise_id: str,
        source: bytes,
        sent_at: datetime,
        submission_id: UUID,
        *,
        answers: bool,
        is_member: bool,
        backlog_limits: BacklogLimits | None = None,
    ) -> Submission:
        seed = variants.get_or_create_seed(db, account, exercise_id) if answers else secrets.randbits(SEED_BITS)
        values = {"source": source, "digest": digest_code(source.decode()), "seed": seed, "created_at": sent_at}
        submission = repository.insert_submission(
            db, id=submission_id, account_id=account.id, exercise=exercise_id, **values
        )
        sender = sender_of_account(account, address, member=is_member)
        needs = worker_version_requirement(exercise_id, self._needed_version(exercise_id))
        self._queue.enqueue(
            db, GRADE, job_key(submission.id), sender=sender, limits=backlog_limits, required_version=needs
        )
        return submission

    def _rate_limit_draws(self, account: Account, size: int, stranger_address: str | None) -> list[limits.TokenDraw]:
        """Return what a submission of `size` bytes takes: of its account and, unless in a class, of its address."""
        kib, bucket = VERDICT_KIB + -(-size // 1024), self._settings.storage_bucket
        draws = [
            limits.TokenDraw(limits.submission_bucket_key(account.id), self._settings.submission_bucket, TOO_FAST),
            limits.TokenDraw(f"storage:{account.id}", bucket, STORAGE_USED["account"], kib),
        ]
        if stranger_address is not None:
            shared = BucketSettings(STRANGERS_SHARES * bucket.burst, bucket.refill_seconds / STRANGERS_SHARES)
            draws.append(limits.TokenDraw(f"storage-from:{stranger_address}", shared, STORAGE_USED["address"], kib))
        return draws

    def requeue(self, db: Session, submission: Submission, account: Account) -> bool:
        """Enqueue a submission (again); False where it is queued already."""
        if self._queue.position(db, GRADE, job_key(submission.id)) is not None:
            return False
        sender = sender_of_account(account, "", member=presence.is_active_member(db, account.id))
        self._queue.enqueue(db, GRADE, job_key(submission.id), sender=sender)
        return True

    def progress(self, db: Session, submission: Submission) -> GradingProgress:
        if submission.grading_id is not None:
            return GradingProgress(SubmissionState.done)
        return self.progress_while_waiting(db, submission.id) or GradingProgress(
            SubmissionState.queued, None, self._is_stalled()
        )

    def progress_while_waiting(self, db: Session, submission_id: UUID) -> GradingProgress | None:
        """Return the progress of an ungraded submission with one query; None where its job is gone."""
        status = self._queue.status(db, GRADE, job_key(submission_id))
        if status is None:
            return None
        if status.position == 0:
            return GradingProgress(SubmissionState.running)
        return GradingProgress(SubmissionState.queued, status.position, self._is_stalled(), status.refused)


def _queue_full_message(error: QueueFullError, account: Account, backlog_limits: BacklogLimits) -> str:
    hint = QUEUE_FULL_FOR_GUESTS if error.scope == "address" and account.is_guest else ""
    return QUEUE_FULL[error.scope].format(each=backlog_limits.per_sender) + hint


def _derive_submission_id(account: Account, key: str | None) -> UUID:
    """Return the submission's id: derived from the account and its idempotency key, or random."""
    return uuid4() if key is None else uuid5(account.id, key)


def _find_resubmission(
    db: Session, account: Account, submission_id: UUID, exercise_id: str, source: bytes
) -> Submission | None:
    """Return the submission stored under this id. Raises Invalid where its content differs."""
    stored = repository.find_submission(db, submission_id)
    if stored is not None and (stored.account_id, stored.exercise, stored.source) != (account.id, exercise_id, source):
        raise Invalid(KEY_REUSED)
    return stored


def worker_version_requirement(exercise_id: str, version: str | None) -> str | None:
    """Return the requirement on a worker: this exercise in this version; None where any worker can grade it."""
    return None if version is None else f"{exercise_id}@{version}"


def job_key(submission_id: UUID) -> str:
    """Return the key of its job, for the queue and its watchers."""
    return str(submission_id)


def digest_code(code: str) -> str:
    """Hash the code without blank lines, whole-line comments and trailing spaces: equal for an unchanged attempt."""
    lines = (line.rstrip() for line in code.removeprefix("\ufeff").splitlines())
    code_lines = "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))
    return hashlib.sha256(code_lines.encode("utf-8", errors="replace")).hexdigest()


def parse_submission_id(text: UUID | str) -> UUID:
    """Parse an id. Raises NotFound."""
    return parse_uuid(text, UNKNOWN_SUBMISSION)


def may_view_submission(db: Session, account: Account | None, submission: Submission) -> bool:
    return rights.may_read_work(db, account, submission.account_id, submission.exercise, submission.created_at)
