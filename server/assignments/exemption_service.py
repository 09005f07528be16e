"""Exemptions: granting one to a student, to several at once or to a group, revoking it; each is noted in the log.

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
from server.assignments.rules import Field, Origin, Rules
from server.assignments.schemas import ExemptionInput, ExemptionTarget, validate_exemption
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import InvalidFields, NotFound
from server.base.validation import parse_uuid
from server.classes.models import ClassRole, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import require_open
from server.database import utc_now

UNKNOWN = "Cet aménagement n’existe pas."
NO_STUDENT = "Cette personne n’est pas un élève de la classe."


def active_students(members: Collection[Member]) -> Sequence[Member]:
    """Those who learn in the class now."""
    return [one for one in members if one.role is ClassRole.student and one.status is Status.active]


def student_labels(members: Collection[Member]) -> Sequence[str]:
    """Those that some student has."""
    return sorted({label for one in active_students(members) for label in one.groups}, key=str.casefold)


def grant_exemptions(
    db: Session,
    school_class: SchoolClass,
    by: UUID,
    assignment: Assignment,
    members: Collection[Member],
    whom: ExemptionTarget,
    wanted: ExemptionInput,
    *,
    replacing: bool = False,
) -> Sequence[Exemption]:
    """One for the label, or one for each student; `replacing` revokes those that each had for this assignment.

    Raises Conflict for an archived class, or where it would cut short who sits a test; FieldsRefused.
    """
    require_open(school_class)
    known = {one.id for one in active_students(members)}
    if set(whom.students) - known:
        raise InvalidFields({"student": NO_STUDENT})
    validate_exemption(wanted, assignment.opens_at, student_labels(members), whom)
    targets: list[dict[str, Any]] = [{"account_id": one} for one in dict.fromkeys(whom.students)]
    if whom.label:
        targets = [{"label": whom.label}]
    made = [Exemption(assignment_id=assignment.id, created_by=by, **target, **wanted.columns()) for target in targets]
    before = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    replaced = [
        one
        for one in before
        if replacing and ({"account_id": one.account_id} in targets or {"label": one.label} in targets)
    ]
    kept = [one for one in before if one not in replaced]
    safeguards.require_exempted_go_on(db, assignment, before, [*kept, *made], utc_now())
    for one in replaced:
        _revoke(db, school_class, by, assignment, one)
    db.add_all(made)
    db.flush()
    for one in made:
        _note(db, school_class, by, AuditAction.exemption_made, assignment, one)
    return made


def _note(
    db: Session, school_class: SchoolClass, by: UUID, what: AuditAction, assignment: Assignment, one: Exemption
) -> None:
    told: dict[str, Any] = {} if one.label is None else {"label": one.label}
    told |= exemption_effects(one)
    before, after = ({}, told) if what is AuditAction.exemption_made else (told, {})
    audit.record_event(
        db,
        school_class.id,
        by,
        what,
        student=one.account_id,
        about=assignment.title,
        before=before,
        after=after,
        reason=one.reason,
    )


def exemption_effects(one: Exemption) -> dict[str, Any]:
    """What it says, without why."""
    named = ExemptionInput(one.opens_at, one.due_at, one.closes_at, one.time_factor, one.excused)
    return named.effects


def find_exemption(db: Session, assignment: Assignment, exemption_id: UUID | str) -> Exemption:
    """Raises NotFound."""
    found = repository.find_exemption(db, assignment.id, parse_uuid(exemption_id, UNKNOWN))
    if found is None:
        raise NotFound(UNKNOWN)
    return found


def revoke_exemption(db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, one: Exemption) -> None:
    """From now on it says nothing; one that was revoked stays so. Raises Conflict."""
    require_open(school_class)
    if one.revoked_at is not None:
        return
    before = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    after = [each for each in before if each.id != one.id]
    safeguards.require_exempted_go_on(db, assignment, before, after, utc_now())
    _revoke(db, school_class, by, assignment, one)


def _revoke(db: Session, school_class: SchoolClass, by: UUID, assignment: Assignment, one: Exemption) -> None:
    one.revoked_at = utc_now()
    db.flush()
    _note(db, school_class, by, AuditAction.exemption_revoked, assignment, one)


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """A guest's exemptions are those of the account that the same person has opened."""
    repository.move_exemptions(db, guest_id, account_id)


@dataclass(frozen=True)
class ExplainedValue:
    """What was said of a field: by whom, when, and why where an exemption did. The reason is for the staff alone."""

    origin: Origin
    value: Any
    label: str = ""
    reason: str = ""
    by: UUID | None = None
    at: datetime | None = None


def explain_rules(
    rules: Rules, exemptions: Collection[Exemption], student: UUID
) -> Mapping[Field, tuple[ExplainedValue, ...]]:
    """The rules' own account of themselves, with the exemption that each value comes from."""
    return {
        name: tuple(_told(name, one.origin, one.value, one.label, exemptions, student) for one in said)
        for name, said in rules.sources.items()
    }


def _told(
    name: Field, origin: Origin, value: Any, label: str, exemptions: Collection[Exemption], student: UUID
) -> ExplainedValue:
    for one in exemptions:
        mine = one.account_id == student if origin == "student" else origin == "label" and one.label == label
        if mine and one.revoked_at is None and getattr(one, name) == value:
            return ExplainedValue(origin, value, label, one.reason, one.created_by, one.created_at)
    return ExplainedValue(origin, value, label)
