"""Paper slips with a link to a first password, for the accounts that the list of a class has created.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.classes import repository, service
from server.classes.models import SchoolClass
from server.classes.schemas import Member
from server.database import utc_now
from server.identity import links
from server.identity import repository as identity
from server.identity.models import Role

NO_PASSWORD_HERE = (
    "Le mot de passe de {name} ne se remet pas d’ici : son compte n’a pas été créé par la liste de cette classe. "
    "L’administrateur peut lui donner un lien."
)


@dataclass(frozen=True)
class PasswordSlip:
    """The data of a paper slip: name, login, and the code of a one-time link to a first password, until it ends."""

    name: str
    login: str
    token: str
    expires_at: datetime


def create_password_slips(
    db: Session,
    school_class: SchoolClass,
    accounts: Collection[UUID] | None,
    settings: Settings,
    *,
    made_by: UUID,
    renew: bool = False,
) -> tuple[list[PasswordSlip], list[str]]:
    """Return slips with one-time links to a first password, sorted by name; also why chosen accounts get none.

    A slip that this class has given out and that is not used yet stays the same, and lasts anew; with `renew` all are
    made anew, and the old ones stop working. `accounts` None: every account without a password.

    Only accounts created by this class's list whose owner is nothing
    but a student anywhere get a link: members who joined with their own account keep control of it.
    """
    service.require_not_archived(school_class)
    students = [member for member in repository.load_members(db, school_class.id) if member.is_active_student]
    staff = repository.filter_staff_accounts(db, {member.id for member in students})
    earlier = (
        {}
        if renew
        else identity.load_unexpired_slip_links(db, {member.id for member in students}, school_class.id, utc_now())
    )
    lifetime = timedelta(days=settings.first_password_days)
    slips, refused = [], []
    for member in students:
        if accounts is not None and member.id not in accounts:
            continue
        if not _may_receive_slip(member, staff):
            if accounts is not None:
                refused.append(NO_PASSWORD_HERE.format(name=member.name))
        elif accounts is not None or member.account.password_hash is None:
            link = earlier.get(member.id)
            if link is not None and link.code and link.role == member.account.role:
                code = link.code
                link.made_by, link.expires_at = made_by, utc_now() + lifetime
            else:
                code = links.create_password_link(
                    db, member.account, lifetime, class_id=school_class.id, made_by=made_by
                )
            slips.append(PasswordSlip(member.name, str(member.account.login), code, utc_now() + lifetime))
    return slips, refused


def _may_receive_slip(member: Member, staff: Collection[UUID]) -> bool:
    is_only_student = member.account.role == Role.student and member.id not in staff
    return member.membership.created_by_list and member.account.login is not None and is_only_student


def may_student_receive_password_link(db: Session, class_id: UUID, account_id: UUID) -> bool:
    """Whether a teacher of this class may hand a link to a password to this account now."""
    school_class = repository.find_class(db, class_id)
    if school_class is None or school_class.archived_at is not None:
        return False
    staff = repository.filter_staff_accounts(db, {account_id})
    members = repository.load_members(db, class_id, [account_id])
    return any(member.is_active_student and _may_receive_slip(member, staff) for member in members)
