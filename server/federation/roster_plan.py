"""The seats that the list of a course would give in its class: planned and shown, then given. Nobody leaves by a list.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy.orm import Session

from server.assignments.members import recording_member_changes
from server.classes import repository as classes
from server.classes.models import SchoolClass, Status
from server.federation import contexts, repository
from server.federation.arrivals import external_person
from server.federation.models import IdentityProvider
from server.federation.schemas import SignedPerson
from server.identity import identities
from server.identity.models import Account


@dataclass(frozen=True)
class RosterPlan:
    """`entering` have no seat in the class, or left it by themselves; `present` have one; `missing` are students of the
    class whom the platform does not list, and who stay."""

    entering: Sequence[SignedPerson]
    present: int
    missing: Sequence[str]

    @property
    def digest(self) -> str:
        """A hash of the changes: equal plans have equal digests."""
        rows = sorted(f"{person.subject}\n{person.role}\n{person.name}" for person in self.entering)
        return hashlib.sha256("\n\n".join(rows).encode()).hexdigest()


def plan_roster(
    db: Session, provider: IdentityProvider, school_class: SchoolClass, people: Sequence[SignedPerson]
) -> RosterPlan:
    """Compare the people of a course with the members of its class."""
    members = {member.id: member for member in classes.load_members(db, school_class.id)}
    known = repository.load_accounts_by_subject(db, provider.issuer, {person.subject for person in people})
    entering, present = [], set()
    for person in people:
        account = known.get(person.subject)
        member = None if account is None else members.get(account.id)
        if member is None or (member.membership.status == Status.left and member.membership.left_voluntarily):
            entering.append(person)
        else:
            present.add(member.id)
    identified = repository.load_identified_members(db, provider.issuer, set(members))
    missing = [
        member.name
        for member in members.values()
        if member.id in identified
        and member.id not in present
        and member.membership.status == Status.active
        and not member.membership.is_staff
    ]
    return RosterPlan(entering, len(present), missing)


def enrol_planned_people(
    db: Session, provider: IdentityProvider, school_class: SchoolClass, plan: RosterPlan, by: Account
) -> int:
    """Give the planned seats, with an account for each person who has none; return how many.

    An account that is made here opens when its person comes from the platform.
    """
    seated = 0
    with recording_member_changes(db, school_class.id, by.id):
        for person in plan.entering:
            _, account = identities.find_or_create_identity(db, external_person(provider, person))
            if account.disabled_at is None and not account.is_administrator:
                contexts.enrol_account(db, provider, school_class, account, person)
                seated += 1
    return seated
