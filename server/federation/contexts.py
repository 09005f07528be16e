"""Courses of a provider, the classes that teachers tie to them, and the seats of those who arrive.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.members import recording_member_changes
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, NotFound
from server.classes import repository as classes
from server.classes import service as class_service
from server.classes.folding import normalise_name
from server.classes.models import NAME_LENGTH, ClassRole, Membership, SchoolClass, Status
from server.database import utc_now
from server.federation import repository, waiting
from server.federation.models import ADDRESS_LENGTH, IdentityProvider, ProviderContext
from server.federation.schemas import ArrivedContext, CourseRole, SignedPerson
from server.identity.identities import clean_name_or_empty
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right

UNKNOWN = "Ce cours n’existe pas, ou n’est pas le vôtre."
TIED = "Ce cours est déjà lié à la classe « {name} » : déliez-le d’abord, dans les réglages de cette classe."
SEATS = {
    CourseRole.student: ClassRole.student,
    CourseRole.assistant: ClassRole.assistant,
    CourseRole.teacher: ClassRole.teacher,
}


def store_context_and_enrol(
    db: Session, provider: IdentityProvider, arrived: ArrivedContext, account: Account, person: SignedPerson
) -> ProviderContext:
    """Store what an arrival tells of its course, and seat the account in the class that is tied to it."""
    now, title = utc_now(), clean_name_or_empty(arrived.title[:NAME_LENGTH])
    values: Mapping[str, Any] = {
        "seen_at": now,
        **({"title": title} if title else {}),
        **({"roster_url": arrived.roster_url[:ADDRESS_LENGTH]} if arrived.roster_url else {}),
        **(
            {"line_items_url": arrived.line_items_url[:ADDRESS_LENGTH], "scopes": list(arrived.scopes)}
            if arrived.line_items_url
            else {}
        ),
    }
    context = repository.upsert_context(db, provider.id, arrived.deployment, arrived.context, values)
    if person.role is CourseRole.teacher:
        repository.remember_context_teacher(db, context.id, account.id, now)
    else:
        repository.forget_context_teacher(db, context.id, account.id)
    school_class = None if context.class_id is None else classes.find_class(db, context.class_id)
    if school_class is not None and school_class.archived_at is None:
        _enrol_unless_removed(db, provider, school_class, account, person)
    elif person.role is CourseRole.student:
        waiting.store_waiting_student(db, context.id, account.id, person, now)
    return context


def _enrol_unless_removed(
    db: Session, provider: IdentityProvider, school_class: SchoolClass, account: Account, person: SignedPerson
) -> None:
    """Let an account into a class. No role there changes; who was removed by a teacher asks to be admitted."""
    membership = classes.find_membership(db, school_class.id, account.id)
    if person.role not in SEATS or (membership is not None and not _may_join_again(membership)):
        return
    with recording_member_changes(db, school_class.id, account.id):
        enrol_account(db, provider, school_class, account, person)


def enrol_account(
    db: Session, provider: IdentityProvider, school_class: SchoolClass, account: Account, person: SignedPerson
) -> None:
    """Give an account its seat in a class, within `changing_members`, as `_enrol_unless_removed` says."""
    role = SEATS.get(person.role)
    membership = classes.find_membership(db, school_class.id, account.id)
    if membership is None and role is not None:
        db.add(_new_membership(db, provider, school_class, account, person, role))
    elif role is None or membership is None or not _may_join_again(membership):
        return
    elif membership.left_voluntarily or membership.status == Status.pending:
        membership.status, membership.left_at, membership.left_voluntarily = Status.active, None, False
    elif not membership.is_staff:
        membership.status = Status.pending
    db.flush()


def _may_join_again(membership: Membership) -> bool:
    """Whether a seat is neither taken, nor asked for anew by somebody whom a teacher has removed."""
    removed = membership.status == Status.pending and membership.left_at is not None
    return membership.status != Status.active and not removed


def _new_membership(
    db: Session,
    provider: IdentityProvider,
    school_class: SchoolClass,
    account: Account,
    person: SignedPerson,
    role: ClassRole,
) -> Membership:
    """Return a seat; it is unconfirmed where a member of the same name may be the same person."""
    given, family = clean_name_or_empty(person.given_name), clean_name_or_empty(person.family_name)
    name = f"{given} {family}".strip() or account.name
    return Membership(
        class_id=school_class.id,
        account_id=account.id,
        role=role,
        given_name=given if family else "",
        family_name=family if given else "",
        is_confirmed=role is not ClassRole.student
        or not _unidentified_namesakes(db, provider.issuer, school_class.id, name),
        joined_at=utc_now(),
    )


def _unidentified_namesakes(db: Session, issuer: str, class_id: UUID, name: str) -> Sequence[UUID]:
    """Return the members of this name who have no identity at this issuer: each may be the person who arrives."""
    folded = normalise_name(name)
    found = [member.id for member in classes.load_members(db, class_id) if normalise_name(member.plain_name) == folded]
    known = repository.load_identified_members(db, issuer, found)
    return [member for member in found if member not in known]


def may_duplicate_listed_member(db: Session, class_id: UUID, account_id: UUID) -> bool:
    """Whether a member who has just arrived may be one whom the class's list has already."""
    seat = classes.find_membership(db, class_id, account_id)
    return seat is not None and not seat.is_confirmed


def find_taught_context(db: Session, context_id: UUID, account: Account) -> ProviderContext:
    """Return a course that this account teaches. Raises NotFound."""
    context = repository.find_context(db, context_id)
    if context is None or not repository.teaches_context(db, context_id, account.id):
        raise NotFound(UNKNOWN)
    return context


def link_class(db: Session, context: ProviderContext, account: Account, class_id: UUID) -> SchoolClass:
    """Tie a course to a class, both of which the account teaches. Raises NotFound, Forbidden or Conflict."""
    access = rights.require_right(db, account, Right.configure_class, class_id)
    class_service.require_not_archived(access.school_class)
    current = None if context.class_id is None else classes.find_class(db, context.class_id)
    if current is not None and current.id != class_id:
        raise Conflict(TIED.format(name=current.name))
    if current is None:
        context.class_id, context.linked_by = class_id, account.id
        audit.record_event(db, class_id, account.id, AuditAction.course_tied, about=context.title)
        _enrol_waiting_students(db, context, access.school_class)
    return access.school_class


def _enrol_waiting_students(db: Session, context: ProviderContext, school_class: SchoolClass) -> None:
    """Let the students into a class who have come from its course before it was tied."""
    provider = repository.find_provider(db, context.provider_id)
    if provider is None:
        return
    for student, account in waiting.load_waiting_students(db, context.id):
        person = SignedPerson("", "", student.given_name, student.family_name, CourseRole.student)
        _enrol_unless_removed(db, provider, school_class, account, person)
    waiting.delete_waiting_students(db, context.id)


def link_new_class(db: Session, context: ProviderContext, account: Account, name: str, module: str) -> SchoolClass:
    """Make a class for a course. Raises Forbidden, Invalid or Conflict."""
    rights.require_server_right(account, Right.create_class)
    school_class = class_service.create_class(db, account, name, module)
    return link_class(db, context, account, school_class.id)


def unlink_class(db: Session, context: ProviderContext, school_class: SchoolClass, by: UUID) -> None:
    """Untie a course from its class: nobody enters by it any more, and no mark is sent."""
    context.class_id = context.linked_by = None
    audit.record_event(db, school_class.id, by, AuditAction.course_untied, about=context.title)
