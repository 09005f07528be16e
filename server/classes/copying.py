"""Copy a class, for other students or into another edition of its module."""

from __future__ import annotations

from sqlalchemy.orm import Session

from server.classes import repository
from server.classes.models import Membership, SchoolClass, Status
from server.classes.service import create_class
from server.identity.models import Account


def copy_class(
    db: Session, original: SchoolClass, by: Account, name: str, *, module: str, with_students: bool = False
) -> SchoolClass:
    """Copy a class with its rules and staff, its active students on request, and a new join code. Raises Invalid."""
    copy = create_class(db, by, name, module)
    copy.approval = original.approval
    for member in repository.load_members(db, original.id):
        is_copied = member.membership.is_staff or with_students
        if is_copied and member.status is Status.active and member.id != by.id:
            db.add(_copy_membership(copy, member.membership))
    db.flush()
    return copy


def _copy_membership(target: SchoolClass, original: Membership) -> Membership:
    """Copy a membership into another class; of staff, the role alone."""
    copy = Membership(class_id=target.id, account_id=original.account_id, role=original.role)
    if not original.is_staff:
        copy.family_name, copy.given_name, copy.email = original.family_name, original.given_name, original.email
        copy.groups = list(original.groups)
        copy.is_confirmed = original.is_confirmed
    return copy
