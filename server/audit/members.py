"""Record changes of memberships in the audit log, whichever page or list makes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from uuid import UUID

from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.classes import repository
from server.classes.models import ClassRole, Status

#: Role, status, whether confirmed, groups.
MembershipValues = tuple[str, str, bool, tuple[str, ...]]
NO_MEMBERSHIP: MembershipValues = (ClassRole.student, Status.left, False, ())


@contextmanager
def recording_membership_changes(db: Session, class_id: UUID, by: UUID) -> Iterator[None]:
    """Record the changes of memberships within the block as events, in the same transaction."""
    before = _load_membership_values(db, class_id)
    yield
    db.flush()
    after = _load_membership_values(db, class_id)
    for account_id, current in after.items():
        _record_membership_change(db, class_id, by, account_id, before.get(account_id, NO_MEMBERSHIP), current)


def _load_membership_values(db: Session, class_id: UUID) -> Mapping[UUID, MembershipValues]:
    members = repository.load_members(db, class_id)
    rows = ((member.id, member.membership) for member in members)
    return {account_id: (row.role, row.status, row.is_confirmed, tuple(row.groups)) for account_id, row in rows}


def _record_membership_change(
    db: Session, class_id: UUID, by: UUID, account_id: UUID, old: MembershipValues, new: MembershipValues
) -> None:
    (old_role, old_status, was_confirmed, old_groups), (new_role, new_status, is_confirmed, new_groups) = old, new
    if is_confirmed and not was_confirmed and old_status == new_status != Status.left:
        audit.record_event(db, class_id, by, AuditAction.student_confirmed, student=account_id)
    if old_groups != new_groups and old_status == new_status == Status.active:
        audit.record_event(
            db,
            class_id,
            by,
            AuditAction.groups_changed,
            student=account_id,
            before={"groups": list(old_groups)},
            after={"groups": list(new_groups)},
        )
    if old[:2] == new[:2]:
        return
    if {old_role, new_role} != {ClassRole.student}:
        before = {"role": old_role if old_status == Status.active else None}
        after = {"role": new_role if new_status == Status.active else None}
        audit.record_event(db, class_id, by, AuditAction.staff_changed, student=account_id, before=before, after=after)
    elif new_status != Status.pending:
        action = AuditAction.student_admitted if new_status == Status.active else AuditAction.student_removed
        before, after = {"status": old_status}, {"status": new_status}
        audit.record_event(db, class_id, by, action, student=account_id, before=before, after=after)
