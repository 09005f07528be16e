"""A class made after another: for other students, or for the same in another edition of its module."""

from __future__ import annotations

from sqlalchemy.orm import Session

from server.classes import repository
from server.classes.models import Membership, SchoolClass, Status
from server.classes.service import create_class
from server.identity.models import Account


def copy_class(
    db: Session, original: SchoolClass, by: Account, name: str, *, module: str, with_students: bool = False
) -> SchoolClass:
    """The same in this edition of its module: rules, who teaches; a code of its own. Raises Invalid.

    Of the students only those who are in the class now, where they are wanted: they know who has taken them along.
    """
    made = create_class(db, by, name, module)
    made.approval = original.approval
    for member in repository.load_members(db, original.id):
        taken = member.membership.is_staff or with_students
        if taken and member.status is Status.active and member.id != by.id:
            db.add(_seat_in(made, member.membership))
    db.flush()
    return made


def _seat_in(made: SchoolClass, there: Membership) -> Membership:
    """What somebody is in a class, for another one; of staff, the seat alone."""
    seat = Membership(class_id=made.id, account_id=there.account_id, role=there.role)
    if not there.is_staff:
        seat.family_name, seat.given_name, seat.email = there.family_name, there.given_name, there.email
        seat.groups = list(there.groups)
    return seat
