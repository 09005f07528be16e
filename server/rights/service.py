"""Authorisation checks. Every function works inside the caller's transaction.

A resource that does not concern an account does not exist for it (NotFound); an account that is concerned but lacks a
right gets Forbidden, which names the right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement
from sqlalchemy.orm import Session

from server.base.errors import Forbidden, NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import UNKNOWN_CLASS
from server.identity.models import Account
from server.rights import repository
from server.rights.models import MEMBER_ONLY_RIGHTS, PENDING_RIGHTS, ROLES_BY_RIGHT, Right

MISSING = "Il vous manque le droit de {right}."
ONLY = {
    Right.create_class: " Les enseignants l’ont : l’administrateur de ce serveur peut vous le donner.",
    Right.write_exercises: " Les enseignants l’ont : l’administrateur de ce serveur peut vous le donner.",
    Right.open_solutions_to_all: (
        " L’administrateur de ce serveur l’a ; un enseignant ouvre les corrigés à ses classes."
    ),
}
OF_CLASS = " Dans la classe « {name} », {who}."
WHO = {
    frozenset({ClassRole.student}): "les élèves l’ont",
    frozenset({ClassRole.teacher}): "les enseignants l’ont",
    frozenset({ClassRole.assistant, ClassRole.teacher}): "les enseignants et les assistants l’ont",
    frozenset(ClassRole): "ses membres l’ont, une fois admis",
}


@dataclass(frozen=True)
class ClassAccess:
    """A class with an account's membership and rights in it."""

    school_class: SchoolClass
    membership: Membership | None
    rights: frozenset[Right]

    def has(self, right: Right) -> bool:
        return right in self.rights


def load_class_access(db: Session, account: Account, class_id: UUID | str) -> ClassAccess:
    """Return an account's access to a class. Raises NotFound where the class does not exist or concern it."""
    identity = parse_uuid(class_id, UNKNOWN_CLASS)
    row = classes.load_class_and_membership(db, identity, account.id)
    if row is None:
        raise NotFound(UNKNOWN_CLASS)
    school_class, membership = row
    if membership is not None and membership.status == Status.left:
        membership = None
    if membership is None and not account.is_administrator:
        raise NotFound(UNKNOWN_CLASS)
    return build_class_access(account, school_class, membership)


def build_class_access(account: Account, school_class: SchoolClass, membership: Membership | None) -> ClassAccess:
    """Return an account's access from its membership, None for an administrator alone."""
    return ClassAccess(school_class, membership, _compute_rights(account, membership))


def require_right(db: Session, account: Account, right: Right, class_id: UUID | str) -> ClassAccess:
    """Return the access to a class where it includes this right. Raises NotFound or Forbidden."""
    access = load_class_access(db, account, class_id)
    if not access.has(right):
        raise Forbidden(_refusal_message(right, access.school_class))
    return access


def has_right(db: Session, account: Account, right: Right, class_id: UUID | str) -> bool:
    try:
        return load_class_access(db, account, class_id).has(right)
    except NotFound:
        return False


def require_server_right(account: Account, right: Right) -> None:
    """Raise Forbidden without this right on the server."""
    if right not in server_rights(account):
        raise Forbidden(_refusal_message(right))


def server_rights(account: Account) -> frozenset[Right]:
    teacher = frozenset({Right.create_class, Right.write_exercises}) if account.is_teacher else frozenset()
    return teacher | (frozenset({Right.open_solutions_to_all}) if account.is_administrator else frozenset())


def may_read_work(db: Session, account: Account | None, author: UUID, exercise: str, sent_at: datetime) -> bool:
    """Whether an account may read a submission: its own; one of a student of a class that it teaches or assists, in the
    class's module, sent before the student left or the class was archived; for an administrator, any."""
    if account is None:
        return False
    if account.id == author or account.is_administrator:
        return True
    return repository.may_read_work(db, account.id, author, module_of_exercise(exercise), sent_at)


def find_member_for_reader(db: Session, account: Account, author: UUID, exercise: str) -> Member | None:
    """Return the author as a member of a class through which the account may read their work, or None."""
    reader = None if account.is_administrator else account.id
    return repository.find_member_for_reader(db, reader, author, module_of_exercise(exercise))


def has_staff_readers(db: Session, author: UUID, module: str) -> bool:
    """Whether any staff read what this account submits now to the exercises of a module."""
    return repository.has_staff_readers(db, author, module)


def teaches_clause(account_id: UUID, module: str) -> ColumnElement[bool]:
    """Return the condition that an account is staff in a class of this module, which opens hints and solutions."""
    return repository.teaches_clause(account_id, module)


def is_student(db: Session, account: Account | None, module: str) -> bool:
    """Whether an account is a student of a class of this module, whose teachers may hold feedback back."""
    return account is not None and repository.is_student(db, account.id, module)


def load_classes_to_open_solution_to(db: Session, account: Account | None, exercise: str) -> Sequence[SchoolClass]:
    """Return the classes to which an account may open the solution of an exercise."""
    if account is None:
        return []
    if account.is_administrator:
        return repository.load_classes_of_module(db, module_of_exercise(exercise))
    return repository.load_classes_of_teacher(db, account.id, module_of_exercise(exercise))


def module_of_exercise(exercise: str) -> str:
    return exercise.partition("/")[0]


def _compute_rights(account: Account, membership: Membership | None) -> frozenset[Right]:
    if account.is_administrator:
        own_rights = _member_rights(membership) & MEMBER_ONLY_RIGHTS if membership is not None else frozenset()
        return (frozenset(ROLES_BY_RIGHT) - MEMBER_ONLY_RIGHTS) | own_rights
    assert membership is not None
    return _member_rights(membership)


def _member_rights(membership: Membership) -> frozenset[Right]:
    if membership.status == Status.pending:
        return PENDING_RIGHTS
    return frozenset(right for right, seats in ROLES_BY_RIGHT.items() if membership.role in seats)


def _refusal_message(right: Right, school_class: SchoolClass | None = None) -> str:
    sentence = MISSING.format(right=right.value)
    if school_class is None:
        return sentence + ONLY[right]
    return sentence + OF_CLASS.format(name=school_class.name, who=WHO[ROLES_BY_RIGHT[right]])
