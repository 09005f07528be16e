"""Whether a link to a password that a teacher has handed out on a slip is still in force."""

from sqlalchemy.orm import Session

from server.classes import slips
from server.identity import repository as identity
from server.identity.models import PasswordLink
from server.rights import service as rights
from server.rights.models import Right


def is_password_link_in_force(db: Session, link: PasswordLink) -> bool:
    """Whether the maker of a slip could make it now: they may still hand out passwords in its class, which is open, and
    its account is still there as a student, and teaches or assists nowhere. A link of an administrator has no class."""
    if link.class_id is None:
        return True
    maker = None if link.made_by is None else identity.find_account(db, link.made_by)
    if maker is None or maker.disabled_at is not None:
        return False
    may_make = rights.has_right(db, maker, Right.hand_out_passwords, link.class_id)
    return may_make and slips.may_student_receive_password_link(db, link.class_id, link.account_id)
