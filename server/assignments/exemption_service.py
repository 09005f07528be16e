"""Grant exemptions to students or to a label, and revoke them; each is recorded in the audit log.

Every function works inside the caller's transaction, on a class that the caller may change (`server.rights`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, safeguards
from server.assignments.models import Assignment, Exemption
from server.assignments.rule_sources import CommonRules, Field, Origin, SourcedValue
from server.assignments.rules import Rules
from server.assignments.schemas import ExemptionInput, ExemptionTarget, validate_exemption
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import InvalidFields, NotFound
from server.base.validation import parse_uuid
from server.classes.models import ClassRole, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import require_not_archived
from server.database import utc_now

UNKNOWN = "Cet aménagement n’existe pas."
NO_STUDENT = "Cette personne n’est pas un élève de la classe."


def filter_active_students(members: Collection[Member]) -> Sequence[Member]:
    """Return the active students among the members of a class."""
    return [member for member in members if member.role is ClassRole.student and member.status is Status.active]


def list_student_labels(members: Collection[Member]) -> Sequence[str]:
    """Return the labels of the active students."""
    return sorted({label for student in filter_active_students(members) for label in student.groups}, key=str.casefold)


def grant_exemptions(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    assignment: Assignment,
    members: Collection[Member],
    target: ExemptionTarget,
    fields: ExemptionInput,
    *,
    replacing: bool = False,
) -> Sequence[Exemption]:
    """Create one exemption for the label or for each student; `replacing` revokes their earlier ones.

    Raises InvalidFields, Conflict for an archived class, or WrongMoment where it would cut short a running sitting.
    """
    require_not_archived(school_class)
    if set(target.students) - {student.id for student in filter_active_students(members)}:
        raise InvalidFields({"student": NO_STUDENT})
    validate_exemption(fields, assignment.opens_at, list_student_labels(members), target)
    beneficiaries: list[dict[str, Any]] = [{"account_id": student} for student in dict.fromkeys(target.students)]
    if target.label:
        beneficiaries = [{"label": target.label}]
    now = utc_now()
    granted = [
        Exemption(
            assignment_id=assignment.id,
            created_by=by,
            created_at=now,
            extends=never_moves_dates_earlier(fields, assignment),
            **beneficiary,
            **fields.row_columns(),
        )
        for beneficiary in beneficiaries
    ]
    before = repository.load_active_exemptions(db, assignment.id)
    replaced = [
        exemption
        for exemption in before
        if replacing
        and ({"account_id": exemption.account_id} in beneficiaries or {"label": exemption.label} in beneficiaries)
    ]
    remaining = [exemption for exemption in before if exemption not in replaced]
    safeguards.require_no_sitting_cut_short(db, assignment, before, [*remaining, *granted], now)
    for exemption in replaced:
        _revoke_and_record(db, school_class, by, assignment, exemption, now)
    db.add_all(granted)
    db.flush()
    for exemption in granted:
        _record_exemption_event(db, school_class, by, AuditAction.exemption_made, assignment, exemption)
    return granted


def never_moves_dates_earlier(fields: ExemptionInput, common: CommonRules) -> bool:
    """Return whether no date of an exemption is earlier than that of the others. Pure."""
    return not any(
        date is not None and (others is None or date < others)
        for date, others in ((fields.due_at, common.due_at), (fields.closes_at, common.closes_at))
    )


def _record_exemption_event(
    db: Session, school_class: SchoolClass, by: UUID, action: AuditAction, assignment: Assignment, exemption: Exemption
) -> None:
    values: dict[str, Any] = {} if exemption.label is None else {"label": exemption.label}
    values |= changed_fields(exemption)
    before, after = ({}, values) if action is AuditAction.exemption_made else (values, {})
    audit.record_event(
        db,
        school_class.id,
        by,
        action,
        student=exemption.account_id,
        about=assignment.title,
        before=before,
        after=after,
        reason=exemption.reason,
    )


def changed_fields(exemption: Exemption) -> dict[str, Any]:
    """Return the fields that an exemption changes, without its reason."""
    dates = (exemption.opens_at, exemption.due_at, exemption.closes_at)
    return ExemptionInput(*dates, exemption.time_factor, exemption.excused).changed_fields


def find_exemption(db: Session, assignment: Assignment, exemption_id: UUID | str) -> Exemption:
    """Return an exemption of an assignment. Raises NotFound."""
    exemption = repository.find_exemption(db, assignment.id, parse_uuid(exemption_id, UNKNOWN))
    if exemption is None:
        raise NotFound(UNKNOWN)
    return exemption


def revoke_exemption(
    db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, exemption: Exemption
) -> None:
    """Revoke an exemption; nothing where it is revoked already. Raises Conflict or WrongMoment."""
    require_not_archived(school_class)
    if exemption.revoked_at is not None:
        return
    before = repository.load_active_exemptions(db, assignment.id)
    after = [each for each in before if each.id != exemption.id]
    now = utc_now()
    safeguards.require_no_sitting_cut_short(db, assignment, before, after, now)
    _revoke_and_record(db, school_class, by, assignment, exemption, now)


def _revoke_and_record(
    db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, exemption: Exemption, now: datetime
) -> None:
    exemption.revoked_at = now
    db.flush()
    _record_exemption_event(db, school_class, by, AuditAction.exemption_revoked, assignment, exemption)


def move_guest_exemptions(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's exemptions to the account that the same person has opened."""
    repository.move_exemptions(db, guest_id, account_id)


@dataclass(frozen=True)
class ExplainedValue:
    """A value of a field, its origin, and the author, time and reason of its exemption. Reasons are for the staff."""

    origin: Origin
    value: Any
    label: str = ""
    reason: str = ""
    by: UUID | None = None
    at: datetime | None = None


def explain_rules(
    rules: Rules, exemptions: Collection[Exemption], student: UUID
) -> Mapping[Field, tuple[ExplainedValue, ...]]:
    """Return the values of each field, the one in force first, with the exemptions that they come from."""
    return {
        name: tuple(_explain_value(name, value, exemptions, student) for value in values)
        for name, values in rules.sources.items()
    }


def _explain_value(
    name: Field, value: SourcedValue, exemptions: Collection[Exemption], student: UUID
) -> ExplainedValue:
    for exemption in exemptions:
        if value.origin == "student":
            is_source = exemption.account_id == student
        else:
            is_source = value.origin == "label" and exemption.label == value.label
        if is_source and exemption.revoked_at is None and getattr(exemption, name) == value.value:
            author = (exemption.reason, exemption.created_by, exemption.created_at)
            return ExplainedValue(value.origin, value.value, value.label, *author)
    return ExplainedValue(value.origin, value.value, value.label)
