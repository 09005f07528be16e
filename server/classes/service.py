"""Making a class, joining and leaving it, who is in it as what.

Functions that take `db` work inside the caller's transaction, on a class that the caller may change (`server.rights`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from datetime import timedelta
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from server.base.errors import Conflict, Invalid, NotFound
from server.base.settings import Settings
from server.classes import importing, repository
from server.classes.codes import new_code, parse_code
from server.classes.importing import ImportPlan
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.roster import parse_groups, read_roster
from server.classes.schemas import (
    DEFAULT_CODE_LIFETIME,
    GuestName,
    JoinedClass,
    Member,
    code_expiry,
    validate_class_name,
)
from server.classes.sheets import to_csv
from server.database import Database, utc_now
from server.identity import links
from server.identity import service as identity
from server.identity.models import Account, Role
from server.limits import service as limits

PRESENCE_INTERVAL = timedelta(minutes=5)
UNKNOWN_CLASS = "Cette classe n’existe pas."
NO_SUCH_CODE = "Aucune classe n’a ce code, ou il n’est plus valable : demandez le code du jour à votre enseignant."
TOO_MANY_CODES = "Trop d’essais de codes : réessayez dans {seconds} s."
ARCHIVED = "Cette classe est archivée : elle ne change plus. Rouvrez-la d’abord dans ses réglages."
LAST_TEACHER = "Une classe garde au moins un enseignant : nommez-en un autre d’abord."
NOT_A_MEMBER = "Cette personne n’est pas dans la classe."
NO_PASSWORD_HERE = (
    "Le mot de passe de {name} ne se remet pas d’ici : son compte n’a pas été créé par la liste de cette classe. "
    "L’administrateur peut lui donner un lien."
)
WENT = "Cette personne a quitté la classe d’elle-même : elle y revient avec le code."
CHANGED = "Quelqu’un a créé un compte du même identifiant en ce moment même : recommencez."


def create_class(db: Session, by: Account, name: str, module: str) -> SchoolClass:
    """A class whose only member teaches in it, and which one may join for a while. Raises Invalid."""
    now = utc_now()
    made = SchoolClass(name=validate_class_name(name), module=module, created_by=by.id)
    made.join_code, made.join_code_until = _free_code(db), code_expiry(DEFAULT_CODE_LIFETIME, now)
    db.add(made)
    db.flush()
    db.add(Membership(class_id=made.id, account_id=by.id, role=ClassRole.teacher, joined_at=now))
    db.flush()
    return made


def _free_code(db: Session) -> str:
    while repository.code_is_taken(db, code := new_code()):
        pass
    return code


def require_open(school_class: SchoolClass) -> None:
    """Raises Conflict for an archived class."""
    if school_class.archived_at is not None:
        raise Conflict(ARCHIVED)


def renew_code(db: Session, school_class: SchoolClass, lasting: str) -> None:
    """Another code; the old one opens nothing any more. Raises Conflict or Invalid."""
    require_open(school_class)
    until = code_expiry(lasting, utc_now())
    school_class.join_code, school_class.join_code_until = _free_code(db), until


def close_code(school_class: SchoolClass) -> None:
    school_class.join_code = school_class.join_code_until = None


def valid_code(school_class: SchoolClass) -> str | None:
    """The code by which one may join now."""
    until = school_class.join_code_until
    return school_class.join_code if until is not None and until > utc_now() else None


def archive(school_class: SchoolClass) -> None:
    """The class stays as it is: nobody joins it, and its teachers see nothing that is sent afterwards."""
    if school_class.archived_at is None:
        school_class.archived_at = utc_now()
        close_code(school_class)


def reopen(school_class: SchoolClass) -> None:
    school_class.archived_at = None


def change_students(
    db: Session, school_class: SchoolClass, accounts: Collection[UUID], action: str, group: str = ""
) -> int:
    """Does something to students: how many it changed. Raises Conflict, NotFound or Invalid.

    `action` is `accept` or `refuse` of who asks to join, `remove`, `take_back`, `group` or `ungroup`.
    """
    require_open(school_class)
    labels = parse_groups(group)
    if action in {"group", "ungroup"} and not labels:
        raise Invalid("Indiquez un groupe.")
    changed = 0
    for account_id in accounts:
        membership = repository.find_membership(db, school_class.id, account_id)
        if membership is None or membership.role != ClassRole.student:
            raise NotFound(NOT_A_MEMBER)
        changed += _settled(membership, action, labels)
    return changed


FROM = {"accept": Status.pending, "refuse": Status.pending, "remove": Status.active, "take_back": Status.left}


def _settled(membership: Membership, action: str, labels: Sequence[str]) -> bool:
    if action in FROM:
        if membership.status != FROM[action]:
            return False
        if action == "take_back" and membership.left_voluntarily:
            raise Conflict(WENT)
        if action in {"accept", "take_back"}:
            membership.status, membership.left_at = Status.active, None
        else:
            membership.status = Status.left
            membership.left_at = utc_now() if action == "remove" else None  # who was refused was never in the class
        return True
    kept = [label for label in membership.groups if label not in labels]
    groups = parse_groups("|".join([*membership.groups, *labels])) if action == "group" else tuple(kept)
    changed = list(groups) != membership.groups
    membership.groups = list(groups)
    return changed


def _leave(membership: Membership) -> None:
    membership.status, membership.left_at = Status.left, utc_now()


def leave_class(db: Session, school_class: SchoolClass, account_id: UUID) -> None:
    """Raises NotFound, or Conflict for the last who teaches in the class."""
    membership = repository.find_membership(db, school_class.id, account_id)
    if membership is None or membership.status == Status.left:
        raise NotFound(UNKNOWN_CLASS)
    if membership.role == ClassRole.teacher and not repository.count_other_teachers(db, school_class.id, account_id):
        raise Conflict(LAST_TEACHER)
    _leave(membership)
    membership.left_voluntarily = not membership.created_by_list


def add_staff(db: Session, school_class: SchoolClass, login: str, seat: ClassRole) -> Account:
    """Has the account of this login teach or help in the class. Raises NotFound, Conflict."""
    require_open(school_class)
    account = links.find_account_by_login(db, login)
    membership = repository.find_membership(db, school_class.id, account.id)
    if membership is None:
        db.add(Membership(class_id=school_class.id, account_id=account.id, role=seat))
        return account
    if membership.role == ClassRole.teacher and seat is not ClassRole.teacher:
        _require_another_teacher(db, school_class, account.id)
    membership.role, membership.status, membership.left_at = seat, Status.active, None
    return account


def remove_staff(db: Session, school_class: SchoolClass, account_id: UUID) -> None:
    """Takes somebody off those who teach or help. Raises NotFound or Conflict."""
    membership = repository.find_membership(db, school_class.id, account_id)
    if membership is None or not membership.is_staff or membership.status == Status.left:
        raise NotFound(NOT_A_MEMBER)
    if membership.role == ClassRole.teacher:
        _require_another_teacher(db, school_class, account_id)
    _leave(membership)


def _require_another_teacher(db: Session, school_class: SchoolClass, account_id: UUID) -> None:
    if not repository.count_other_teachers(db, school_class.id, account_id):
        raise Conflict(LAST_TEACHER)


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """A guest's classes are those of the account that the same person has opened."""
    repository.move_memberships(db, guest_id, account_id)


def record_presence(db: Session, account_id: UUID) -> None:
    """That a member was there now; written every few minutes only."""
    now = utc_now()
    repository.update_last_seen(db, account_id, now, now - PRESENCE_INTERVAL)


def is_member(db: Session, account_id: UUID, *, seen: bool = False) -> bool:
    """Whether somebody has let this account into a class that goes on: its work comes first.

    With `seen`, it is there now, which is noted as `note_seen` does.
    """
    places = repository.load_presence(db, account_id)
    since = utc_now() - PRESENCE_INTERVAL
    if seen and any(last_seen is None or last_seen < since for last_seen, _ in places):
        record_presence(db, account_id)
    return any(archived_at is None for _, archived_at in places)


@dataclass(frozen=True)
class PasswordSlip:
    """What a student is handed over on paper."""

    name: str
    login: str
    token: str


def create_password_slips(
    db: Session, school_class: SchoolClass, accounts: Collection[UUID] | None, settings: Settings
) -> tuple[list[PasswordSlip], list[str]]:
    """One-time links to a password, in the order of the class's list; why some get none.

    Of all whose account has no password yet, or of those chosen: where this class's list has made the account, and
    its owner is nothing but a student anywhere. Who joined with an account of their own has not given it away.
    """
    require_open(school_class)
    students = [
        member
        for member in repository.load_members(db, school_class.id)
        if member.role is ClassRole.student and member.status is Status.active
    ]
    staff = repository.filter_staff(db, {member.id for member in students})
    given, refused = [], []
    for member in students:
        if accounts is not None and member.id not in accounts:
            continue
        if not _may_be_handed(member, staff):
            if accounts is not None:
                refused.append(NO_PASSWORD_HERE.format(name=member.name))
        elif accounts is not None or member.account.password_hash is None:
            token = links.create_password_link(db, member.account, timedelta(days=settings.first_password_days))
            given.append(PasswordSlip(member.name, str(member.account.login), token))
    return given, refused


def _may_be_handed(member: Member, staff: Collection[UUID]) -> bool:
    return member.membership.created_by_list and member.account.role == Role.student and member.id not in staff


Around = Callable[[Session], AbstractContextManager[None]]


def _alone(_db: Session) -> AbstractContextManager[None]:
    return nullcontext()


@dataclass(frozen=True)
class ClassService:
    """What needs a transaction of its own: a try that fails is counted all the same."""

    database: Database
    settings: Settings

    def find_by_code(self, code: str, *, by: Account | None, address: str) -> SchoolClass:
        """The class of a code that somebody has typed or scanned. Raises NotFound or TooMany."""
        with self.database.write() as db:
            limits.take_token(db, f"join-from:{address}", self.settings.guest_bucket, TOO_MANY_CODES)
            if by is not None:
                limits.take_token(db, f"join:{by.id}", self.settings.join_bucket, TOO_MANY_CODES)
        read = parse_code(code)
        with self.database.read() as db:
            found = None if read is None else repository.find_class_by_code(db, read, utc_now())
        if found is None:
            raise NotFound(NO_SUCH_CODE)
        with self.database.write() as db:  # it was no guess: a thousand pupils join from one address
            limits.give_back_token(db, f"join-from:{address}")
        return found

    def join_class(self, code: str, account: Account, *, address: str, named: GuestName | None = None) -> JoinedClass:
        """Makes the account a student of the class, or has it ask; who is one already stays. Guests give their name.

        Raises NotFound, TooMany or Invalid.
        """
        found = self.find_by_code(code, by=account, address=address)
        with self.database.write() as db:
            repository.lock_class(db, found.id)
            school_class = repository.find_class(db, found.id)
            if school_class is None or valid_code(school_class) != found.join_code:
                raise NotFound(NO_SUCH_CODE)
            if account.is_guest and named is None:
                raise Invalid("Un invité dit d’abord son nom : rejoignez la classe depuis la page « Rejoindre ».")
            return JoinedClass(school_class, _seated(db, school_class, account, named))

    def preview_import(self, school_class: SchoolClass, by: Account, content: bytes) -> tuple[ImportPlan, str]:
        """What a list would change, and the list as text. Raises Invalid, Conflict or Crowded."""
        require_open(school_class)
        roster = read_roster(content)
        with self.database.read() as db:
            return importing.plan_import(db, school_class, roster, by), to_csv(roster.rows)

    def import_list(
        self, class_id: UUID, by: Account, content: bytes, expected: str | None = None, around: Around = _alone
    ) -> tuple[ImportPlan, bool]:
        """Plans and writes it; with `expected`, only where the plan is still the one of that digest.

        `around` is what the caller does before and after, in the same transaction.

        Raises Invalid, Conflict or Crowded.
        """
        roster = read_roster(content)  # before the transaction: a spreadsheet takes its time
        try:
            with self.database.write() as db:
                repository.lock_class(db, class_id)
                school_class = repository.find_class(db, class_id)
                if school_class is None:
                    raise NotFound(UNKNOWN_CLASS)
                require_open(school_class)
                planned = importing.plan_import(db, school_class, roster, by)
                written = expected is None or expected == planned.digest
                if written:
                    with around(db):
                        importing.apply_import(db, school_class, planned, utc_now())
                return planned, written
        except IntegrityError as error:
            raise Conflict(CHANGED) from error


def _seated(db: Session, school_class: SchoolClass, account: Account, named: GuestName | None) -> Membership:
    status = Status.pending if school_class.approval else Status.active
    membership = repository.find_membership(db, school_class.id, account.id)
    if membership is None:
        membership = Membership(class_id=school_class.id, account_id=account.id, status=status, joined_at=utc_now())
        db.add(membership)
    elif membership.status == Status.left:
        membership.role, membership.status, membership.left_at = ClassRole.student, status, None
        membership.left_voluntarily = False
    if named is not None and account.is_guest:
        membership.given_name, membership.family_name = named.given, named.family
        identity.rename_guest(db, account, f"{named.given} {named.family}")
    db.flush()
    return membership
