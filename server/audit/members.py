"""Who came, went, teaches or helps: noted in the class's log, whichever page or list has changed it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from uuid import UUID

from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.classes import repository
from server.classes.models import ClassRole, Status

Place = tuple[str, str]
NOWHERE: Place = (ClassRole.student, Status.left)


@contextmanager
def recording_membership_changes(db: Session, class_id: UUID, by: UUID) -> Iterator[None]:
    """What changes within the block of anybody's place in the class becomes events, in the same transaction."""
    before = _places(db, class_id)
    yield
    db.flush()
    after = _places(db, class_id)
    for account_id, place in after.items():
        _note(db, class_id, by, account_id, before.get(account_id, NOWHERE), place)


def _places(db: Session, class_id: UUID) -> Mapping[UUID, Place]:
    return {one.id: (one.membership.role, one.membership.status) for one in repository.load_members(db, class_id)}


def _note(db: Session, class_id: UUID, by: UUID, account_id: UUID, old: Place, new: Place) -> None:
    (was, stood), (role, stands) = old, new
    if old == new:
        return
    if {was, role} != {ClassRole.student}:
        seat = {"role": was if stood == Status.active else None}
        now = {"role": role if stands == Status.active else None}
        audit.record_event(db, class_id, by, AuditAction.staff_changed, student=account_id, before=seat, after=now)
    elif stands != Status.pending:
        what = AuditAction.student_admitted if stands == Status.active else AuditAction.student_removed
        before, after = {"status": stood}, {"status": stands}
        audit.record_event(db, class_id, by, what, student=account_id, before=before, after=after)
