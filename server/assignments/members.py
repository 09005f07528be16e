"""Change the members and labels of a class without cutting short a sitting that was told its end.

A label may carry an exemption: without it, a student who sits a test would have less time than the page says.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, sitting_repository
from server.assignments.rules import is_sitting_running, rules_in_force
from server.assignments.sitting_repository import UnfinishedSitting
from server.audit.members import recording_membership_changes
from server.base.errors import WrongMoment
from server.classes.repository import load_members
from server.database import utc_now

CUTS_SHORT = (
    "{name} compose en ce moment, avec le temps que donne son groupe : attendez la fin de sa copie pour changer ses "
    "groupes. Rien n’a été changé."
)


@contextmanager
def recording_member_changes(db: Session, class_id: UUID, by: UUID) -> Iterator[None]:
    """Record the changes of memberships within the block, as `recording_membership_changes`.

    Raises WrongMoment where they would bring forward the end of a running sitting.
    """
    before = _load_unfinished_sittings(db, class_id)
    with recording_membership_changes(db, class_id, by):
        yield
    db.flush()
    for key, sitting in _load_unfinished_sittings(db, class_id).items() if before else ():
        if key in before and _is_sitting_cut_short(db, before[key], sitting):
            (member,) = load_members(db, class_id, [sitting.sitting.account_id])
            raise WrongMoment(CUTS_SHORT.format(name=member.name))


def _load_unfinished_sittings(db: Session, class_id: UUID) -> dict[tuple[UUID, UUID], UnfinishedSitting]:
    unfinished = sitting_repository.load_unfinished_sittings(db)
    return {
        (work.assignment.id, work.sitting.account_id): work
        for work in unfinished
        if work.assignment.class_id == class_id
    }


def _is_sitting_cut_short(db: Session, before: UnfinishedSitting, after: UnfinishedSitting) -> bool:
    if set(before.groups) <= set(after.groups):
        return False
    exemptions = repository.load_active_exemptions(db, after.assignment.id)
    old, new = (
        rules_in_force(work.assignment, exemptions, work.sitting.account_id, work.groups) for work in (before, after)
    )
    if not is_sitting_running(old, before.sitting, utc_now()):
        return False
    old_end, new_end = (rules.latest_sitting_end(before.sitting.began_at) for rules in (old, new))
    return new_end is not None and (old_end is None or new_end < old_end)
