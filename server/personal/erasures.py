"""Erasure on request: by the person, by a teacher for their class, by an administrator.

Somebody who sits or has sat a test that is not published is erased when it is: else the same login, made again, would
have a new clock. The request stands meanwhile, and can be cancelled; it is carried out after `erasure_days` at the
latest. Functions that take `db` work inside the caller's transaction.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, Forbidden, NotFound
from server.base.settings import Settings
from server.classes.models import ClassRole, Membership
from server.identity import administration
from server.identity import repository as identity
from server.identity.models import Account, Role
from server.personal import erasure_repository as repository
from server.personal.models import ErasureRequest
from server.personal.team_copies import give_team_attempts_to_partners

NO_ACCOUNT = "Ce compte n’existe pas, ou plus."
NOT_A_STUDENT = (
    "{name} enseigne, assiste dans une classe ou administre ce serveur : un compte d’enseignant ne s’efface que par "
    "son titulaire, sur la page « Mon compte »."
)
NO_REQUEST = "Il n’y a plus d’effacement à annuler : rechargez la page."
OWN_REQUEST = "{name} a demandé cet effacement : elle ou lui seul peut l’annuler, sur la page « Mon compte »."
BEGUN = "L’effacement a commencé : il ne s’annule plus."


@dataclass(frozen=True)
class ErasurePreview:
    """What an erasure takes away: all of an account, or with `class_only` what it has in one class.

    `elsewhere` counts the classes for which the account stays; `tests` are those that put the erasure off.
    """

    account_id: UUID
    name: str
    class_only: bool
    elsewhere: int
    attempts: int
    marks: int
    messages: int
    sittings: int
    classes: int
    tests: tuple[str, ...]

    @property
    def digest(self) -> str:
        """A hash of what is shown: an erasure that would take something else is shown again."""
        return hashlib.sha256(repr(asdict(self)).encode()).hexdigest()


@dataclass(frozen=True)
class PendingErasure:
    """A request that stands: the tests it waits for, and when it is carried out at the latest."""

    requested_at: datetime
    by_staff: bool
    tests: tuple[str, ...]
    latest_at: datetime


def require_erasable_student(db: Session, account: Account) -> None:
    """Raise Forbidden for an account that teaches, assists or administers: nobody erases it but its owner."""
    if account.role not in {Role.student, Role.guest} or repository.has_been_staff(db, account.id):
        raise Forbidden(NOT_A_STUDENT.format(name=account.name))


def find_present_or_former_student(db: Session, class_id: UUID, account_id: UUID) -> Account:
    """Return a student of a class, a former one too. Raises NotFound or Forbidden."""
    membership = db.get(Membership, (class_id, account_id))
    account = identity.find_account(db, account_id)
    if membership is None or account is None:
        raise NotFound(NO_ACCOUNT)
    if membership.role != ClassRole.student:
        raise Forbidden(NOT_A_STUDENT.format(name=account.name))
    require_erasable_student(db, account)
    return account


def preview_erasure_by_staff(
    db: Session, by: Account, class_id: UUID, account: Account, now: datetime
) -> ErasurePreview:
    """Preview what this teacher or administrator erases from the page of a class.

    A teacher erases an account whose classes are all theirs; of another one, what it has in this class.
    """
    elsewhere = 0 if by.is_administrator else repository.count_classes_not_taught(db, account.id, by.id)
    return preview_erasure(db, account, class_id if elsewhere else None, now, elsewhere)


def preview_erasure(
    db: Session, account: Account, class_id: UUID | None, now: datetime, elsewhere: int = 0
) -> ErasurePreview:
    whole = class_id is None
    return ErasurePreview(
        account_id=account.id,
        name=account.name,
        class_only=not whole,
        elsewhere=elsewhere,
        attempts=repository.count_attempts(db, account.id),
        marks=repository.count_teacher_marks(db, account.id, class_id),
        messages=repository.count_messages_by_or_about(db, account.id),
        sittings=repository.count_sittings(db, account.id, class_id),
        classes=len(repository.load_class_ids_of_account(db, account.id)) if whole else 1,
        tests=tuple(repository.load_titles_of_withholding_tests(db, account.id, class_id, now)),
    )


def find_pending_erasure(
    db: Session, account_id: UUID, class_id: UUID | None, settings: Settings, now: datetime
) -> PendingErasure | None:
    """Return the request that stands for an account, or for what it has in a class."""
    request = repository.find_erasure_request(db, account_id, class_id)
    if request is None:
        return None
    tests = tuple(repository.load_titles_of_withholding_tests(db, account_id, class_id, now))
    latest = request.requested_at + timedelta(days=settings.erasure_days)
    return PendingErasure(request.requested_at, request.by_staff, tests, latest)


def request_erasure(db: Session, account_id: UUID, class_id: UUID | None, by: UUID, now: datetime) -> None:
    """Record a request, once, with a line in the log of each class. Raises NotFound."""
    if identity.lock_account(db, account_id) is None:
        raise NotFound(NO_ACCOUNT)
    if repository.find_erasure_request(db, account_id, class_id) is not None:
        return
    db.add(
        ErasureRequest(
            account_id=account_id, class_id=class_id, requested_by=by, by_staff=by != account_id, requested_at=now
        )
    )
    db.flush()
    _record_erasure_event(db, AuditAction.erasure_requested, account_id, class_id, by)


def cancel_erasure(db: Session, account: Account, class_id: UUID | None, by: Account) -> None:
    """Cancel a request that stands; the person's own is cancelled by themselves alone. Raises NotFound, Forbidden or
    Conflict."""
    identity.lock_account(db, account.id)
    request = repository.find_erasure_request(db, account.id, class_id)
    if request is None:
        raise NotFound(NO_REQUEST)
    if request.begun_at is not None:
        raise Conflict(BEGUN)
    if by.id != account.id and not request.by_staff:
        raise Forbidden(OWN_REQUEST.format(name=account.name))
    db.delete(request)
    _record_erasure_event(db, AuditAction.erasure_cancelled, account.id, class_id, by.id)


def begin_erasure_if_allowed(
    db: Session, account_id: UUID, class_id: UUID | None, settings: Settings, now: datetime
) -> bool:
    """Begin to carry out a request where nothing puts it off; return whether it has begun.

    What an account has in one class goes at once. A whole account is closed first, so that nobody begins a test with it
    meanwhile: the account stays locked until the commit, as it is by who begins one. Raises Conflict for the last
    administrator.
    """
    account = identity.lock_account(db, account_id)
    request = repository.find_erasure_request(db, account_id, class_id) if account is not None else None
    if account is None or request is None:
        return False
    tests = repository.load_titles_of_withholding_tests(db, account_id, class_id, now)
    is_late = now >= request.requested_at + timedelta(days=settings.erasure_days)
    if tests and request.begun_at is None and not is_late:
        return False
    by, reached = request.requested_by or account_id, ", ".join(tests)
    if class_id is not None:
        values = {"marks": repository.count_teacher_marks(db, account_id, class_id)}
        give_team_attempts_to_partners(db, account_id, class_id)
        repository.delete_class_data(db, account_id, class_id)
        db.delete(request)
        audit.record_event(
            db, class_id, by, AuditAction.student_erased, student=account_id, about=reached, before=values
        )
    elif request.begun_at is None:
        values = {"attempts": repository.count_attempts(db, account_id)}
        administration.disable_account(db, account)
        request.begun_at = now
        for own_class in repository.load_class_ids_of_account(db, account_id):
            audit.record_event(
                db, own_class, by, AuditAction.student_erased, student=account_id, about=reached, before=values
            )
    return True


def load_pending_erasure_ids(db: Session) -> Sequence[tuple[UUID, UUID | None]]:
    """Load account and class of each request that stands."""
    return [(request.account_id, request.class_id) for request in repository.load_erasure_requests(db)]


def _record_erasure_event(db: Session, action: AuditAction, account_id: UUID, class_id: UUID | None, by: UUID) -> None:
    for own_class in repository.load_class_ids_of_account(db, account_id) if class_id is None else [class_id]:
        audit.record_event(db, own_class, by, action, student=account_id)
