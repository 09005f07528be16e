"""Create, join, leave and archive classes; change their students and staff.

Functions that take `db` work inside the caller's transaction, on a class that the caller may change (`server.rights`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from server.base.errors import Conflict, Invalid, NotFound
from server.base.settings import Settings
from server.classes import importing, repository
from server.classes.codes import draw_join_code, parse_join_code
from server.classes.importing import ImportPlan
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.remembered_columns import apply_remembered_columns, remember_columns
from server.classes.roster import AS_WRITTEN, ReadingChoice, parse_roster, read_roster
from server.classes.roster_line import parse_group_labels
from server.classes.schemas import (
    DEFAULT_CODE_LIFETIME,
    GuestName,
    JoinedClass,
    code_expiry,
    validate_class_name,
)
from server.classes.sheets import read_rows, to_csv
from server.database import Database, utc_now
from server.identity import administration, identities, links
from server.identity.models import Account, Role
from server.limits import service as limits

UNKNOWN_CLASS = "Cette classe n’existe pas."
NO_SUCH_CODE = "Aucune classe n’a ce code, ou il n’est plus valable : demandez le code du jour à votre enseignant."
TOO_MANY_CODES = "Trop d’essais de codes : réessayez dans {seconds} s."
ARCHIVED = "Cette classe est archivée : elle ne change plus. Rouvrez-la d’abord dans ses réglages."
LAST_TEACHER = "Une classe garde au moins un enseignant : nommez-en un autre d’abord."
LEARNS_HERE = (
    "{name} ({login}) est élève de cette classe : on n’enseigne pas dans la classe où l’on apprend. Si c’est une "
    "erreur de liste, retirez d’abord cette personne des élèves."
)
NOT_A_MEMBER = "Cette personne n’est pas dans la classe."
LEFT_VOLUNTARILY = "Cette personne a quitté la classe d’elle-même : elle y revient avec le code."
CHANGED = "Quelqu’un a créé un compte du même identifiant en ce moment même : recommencez."


def create_class(db: Session, by: Account, name: str, module: str) -> SchoolClass:
    """Create a class with its teacher and a join code. Raises Invalid."""
    now = utc_now()
    school_class = SchoolClass(name=validate_class_name(name), module=module, created_by=by.id)
    school_class.join_code, school_class.join_code_until = (
        _draw_unused_code(db),
        code_expiry(DEFAULT_CODE_LIFETIME, now),
    )
    db.add(school_class)
    db.flush()
    db.add(Membership(class_id=school_class.id, account_id=by.id, role=ClassRole.teacher, joined_at=now))
    db.flush()
    return school_class


def _draw_unused_code(db: Session) -> str:
    while repository.is_code_taken(db, code := draw_join_code()):
        pass
    return code


def require_not_archived(school_class: SchoolClass) -> None:
    """Raise Conflict for an archived class."""
    if school_class.archived_at is not None:
        raise Conflict(ARCHIVED)


def renew_join_code(db: Session, school_class: SchoolClass, lifetime: str) -> None:
    """Replace the join code; the old one stops working. Raises Conflict or Invalid."""
    require_not_archived(school_class)
    until = code_expiry(lifetime, utc_now())
    school_class.join_code, school_class.join_code_until = _draw_unused_code(db), until


def remove_join_code(school_class: SchoolClass) -> None:
    school_class.join_code = school_class.join_code_until = None


def unexpired_join_code(school_class: SchoolClass) -> str | None:
    """Return the join code unless it has expired."""
    until = school_class.join_code_until
    return school_class.join_code if until is not None and until > utc_now() else None


def archive_class(school_class: SchoolClass) -> None:
    """Archive a class: nobody joins it, and its teachers see no later submissions."""
    if school_class.archived_at is None:
        school_class.archived_at = utc_now()
        remove_join_code(school_class)


def reopen_class(school_class: SchoolClass) -> None:
    school_class.archived_at = None


def apply_action_to_students(
    db: Session, school_class: SchoolClass, accounts: Collection[UUID], action: str, group: str = ""
) -> int:
    """Apply an action to students, and return how many it changed. Raises Conflict, NotFound or Invalid.

    `action` is `accept` or `refuse` for pending students, `remove`, `take_back`, `confirm` that they are who they say,
    `group` or `ungroup`.
    """
    require_not_archived(school_class)
    labels = parse_group_labels(group)
    if action in {"group", "ungroup"} and not labels:
        raise Invalid("Indiquez un groupe.")
    changed = 0
    for account_id in accounts:
        membership = repository.find_membership(db, school_class.id, account_id)
        if membership is None or membership.role != ClassRole.student:
            raise NotFound(NOT_A_MEMBER)
        changed += _apply_action(membership, action, labels)
    return changed


STATUS_BEFORE = {"accept": Status.pending, "refuse": Status.pending, "remove": Status.active, "take_back": Status.left}


def _apply_action(membership: Membership, action: str, labels: Sequence[str]) -> bool:
    if action in STATUS_BEFORE:
        if membership.status != STATUS_BEFORE[action]:
            return False
        if action == "take_back" and membership.left_voluntarily:
            raise Conflict(LEFT_VOLUNTARILY)
        if action in {"accept", "take_back"}:
            membership.status, membership.left_at = Status.active, None
        else:
            membership.status = Status.left
            membership.left_at = utc_now() if action == "remove" else None  # a refused student never was in the class
        return True
    if action == "confirm":
        was_confirmed, membership.is_confirmed = membership.is_confirmed, True
        return not was_confirmed
    remaining = [label for label in membership.groups if label not in labels]
    groups = parse_group_labels("|".join([*membership.groups, *labels])) if action == "group" else tuple(remaining)
    changed = list(groups) != membership.groups
    membership.groups = list(groups)
    return changed


def _mark_left(membership: Membership) -> None:
    membership.status, membership.left_at = Status.left, utc_now()


def leave_class(db: Session, school_class: SchoolClass, account_id: UUID) -> None:
    """Leave a class voluntarily. Raises NotFound, or Conflict for its last teacher."""
    membership = repository.find_membership(db, school_class.id, account_id)
    if membership is None or membership.status == Status.left:
        raise NotFound(UNKNOWN_CLASS)
    if membership.role == ClassRole.teacher and not repository.count_other_teachers(db, school_class.id, account_id):
        raise Conflict(LAST_TEACHER)
    _mark_left(membership)
    membership.left_voluntarily = not membership.created_by_list


def find_account_for_staff(db: Session, school_class: SchoolClass, login: str) -> Account:
    """Return the account of this login, which may teach in the class.

    Raises NotFound, and Conflict for an archived class or for one of its students.
    """
    require_not_archived(school_class)
    account = links.find_account_by_login_or_id(db, login)
    membership = repository.find_membership(db, school_class.id, account.id)
    if membership is not None and not membership.is_staff and membership.status != Status.left:
        raise Conflict(LEARNS_HERE.format(name=account.name, login=account.handle))
    return account


def add_staff(db: Session, school_class: SchoolClass, login: str, role: ClassRole) -> Account:
    """Make the account of this login a teacher or an assistant of the class. Raises NotFound or Conflict."""
    account = find_account_for_staff(db, school_class, login)
    membership = repository.find_membership(db, school_class.id, account.id)
    if account.role == Role.student and (membership is None or not membership.is_staff):
        administration.revoke_role_credentials(db, account)
    if membership is None:
        db.add(Membership(class_id=school_class.id, account_id=account.id, role=role))
        return account
    if membership.role == ClassRole.teacher and role is not ClassRole.teacher:
        _require_another_teacher(db, school_class, account.id)
    membership.role, membership.status, membership.left_at = role, Status.active, None
    return account


def remove_staff(db: Session, school_class: SchoolClass, account_id: UUID) -> None:
    """Remove a teacher or an assistant from the class. Raises NotFound or Conflict."""
    membership = repository.find_membership(db, school_class.id, account_id)
    if membership is None or not membership.is_staff or membership.status == Status.left:
        raise NotFound(NOT_A_MEMBER)
    if membership.role == ClassRole.teacher:
        _require_another_teacher(db, school_class, account_id)
    _mark_left(membership)


def _require_another_teacher(db: Session, school_class: SchoolClass, account_id: UUID) -> None:
    if not repository.count_other_teachers(db, school_class.id, account_id):
        raise Conflict(LAST_TEACHER)


def move_guest_memberships(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's memberships to the account that the same person has opened."""
    repository.move_memberships(db, guest_id, account_id)


Hook = Callable[[Session, UUID], AbstractContextManager[None]]


def _no_hook_around_import(_db: Session, _class_id: UUID) -> AbstractContextManager[None]:
    return nullcontext()


@dataclass(frozen=True)
class ClassService:
    """Operations with transactions of their own: failed tries count towards rate limits."""

    database: Database
    settings: Settings

    def find_by_code(self, code: str, *, by: Account | None, address: str) -> SchoolClass:
        """Return the class of a typed or scanned code. Raises NotFound or RateLimited."""
        with self.database.write() as db:
            limits.take_token(db, f"join-from:{address}", self.settings.guest_bucket, TOO_MANY_CODES)
            if by is not None:
                limits.take_token(db, f"join:{by.id}", self.settings.join_bucket, TOO_MANY_CODES)
        parsed = parse_join_code(code)
        with self.database.read() as db:
            school_class = None if parsed is None else repository.find_class_by_code(db, parsed, utc_now())
        if school_class is None:
            raise NotFound(NO_SUCH_CODE)
        with self.database.write() as db:  # not a guess: a thousand students may join from one address
            limits.give_back_token(db, f"join-from:{address}")
        return school_class

    def join_class(self, code: str, account: Account, *, address: str, named: GuestName | None = None) -> JoinedClass:
        """Make the account a student of the class, pending where it asks for approval. Guests give their name.

        Raises NotFound, RateLimited or Invalid.
        """
        target = self.find_by_code(code, by=account, address=address)
        with self.database.write() as db:
            repository.lock_class(db, target.id)
            school_class = repository.find_class(db, target.id)
            if school_class is None or unexpired_join_code(school_class) != target.join_code:
                raise NotFound(NO_SUCH_CODE)
            if account.is_guest and named is None:
                raise Invalid("Un invité dit d’abord son nom : rejoignez la classe depuis la page « Rejoindre ».")
            return JoinedClass(school_class, _add_student(db, school_class, account, named))

    def preview_import(
        self,
        school_class: SchoolClass,
        by: Account,
        content: bytes,
        choice: ReadingChoice = AS_WRITTEN,
        *,
        replace: bool = False,
        recall: bool = False,
    ) -> tuple[ImportPlan, str]:
        """Return the planned changes of a list, and the list as CSV. `recall`: read as its teacher said before.

        Raises Invalid, Conflict or Overloaded.
        """
        require_not_archived(school_class)
        source = read_rows(content, choice.encoding or None)
        with self.database.read() as db:
            used = apply_remembered_columns(db, by.id, source, choice) if recall else choice
            roster = parse_roster(source, used)
            planned = importing.plan_import(db, school_class, roster, by, used, replace=replace)
            return planned, to_csv(roster.rows)

    def import_list(
        self,
        class_id: UUID,
        by: Account,
        content: bytes,
        expected: str | None = None,
        around: Hook = _no_hook_around_import,
        choice: ReadingChoice = AS_WRITTEN,
        *,
        replace: bool = False,
    ) -> tuple[ImportPlan, bool]:
        """Plan and apply a list; with `expected`, only where the plan's digest is still this one.

        `replace`: who is not in the list leaves the class. `around` wraps the changes of each class in the same
        transaction. Raises Invalid, Conflict or Overloaded.
        """
        roster = read_roster(content, choice)  # before the transaction: reading a spreadsheet is slow
        try:
            with self.database.write() as db:
                others = [] if choice.only_here else repository.load_taught_classes(db, by.id)
                for locked in sorted({class_id, *(other.id for other in others)}):  # in one order: no deadlock
                    repository.lock_class(db, locked)
                school_class = repository.find_class(db, class_id)
                if school_class is None:
                    raise NotFound(UNKNOWN_CLASS)
                require_not_archived(school_class)
                planned = importing.plan_import(db, school_class, roster, by, choice, replace=replace)
                applied = expected is None or expected == planned.digest
                if applied:
                    remember_columns(db, by.id, roster, choice)
                    for plan in (planned, *planned.others):
                        with around(db, plan.school_class.id):
                            importing.apply_import(db, plan, utc_now())
                return planned, applied
        except IntegrityError as error:
            raise Conflict(CHANGED) from error


def _add_student(db: Session, school_class: SchoolClass, account: Account, named: GuestName | None) -> Membership:
    status = Status.pending if school_class.approval else Status.active
    membership = repository.find_membership(db, school_class.id, account.id)
    if membership is None:
        membership = Membership(
            class_id=school_class.id, account_id=account.id, status=status, joined_at=utc_now(), is_confirmed=False
        )
        db.add(membership)
    elif membership.status == Status.left:
        membership.role, membership.status, membership.left_at = ClassRole.student, status, None
        membership.left_voluntarily = False
    if named is not None and account.is_guest:
        membership.given_name, membership.family_name = named.given, named.family
        identities.rename_guest(db, account, f"{named.given} {named.family}")
    db.flush()
    return membership
