"""What teachers decide beside points: a student's state at an assignment, and how states count in the means.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

from dataclasses import asdict
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.assignments.models import Assignment
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, Invalid, NotFound
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.service import require_not_archived
from server.database import utc_now
from server.identity.models import Account
from server.marks import repository
from server.marks.models import MarkingPolicy, StateDecision
from server.marks.service import (
    NO_SUCH_ASSIGNMENT,
    lock_student_marks,
    parse_override_reason,
    require_assignment_concerns,
)
from server.marks.states import ClassMarking, DecidedState, MarkingRules

NO_SUCH_STATE = "Choisissez : absent, dispensé, ou compter 0."
RULES_CHANGED = (
    "Entre-temps, un autre enseignant a changé ces règles : les voici comme elles sont maintenant. Choisissez de "
    "nouveau si besoin."
)


def set_state_decision(
    db: Session, school_class: SchoolClass, by: Account, student: UUID, assignment_id: UUID, state: str, reason: str
) -> None:
    """Set a student's state at an assignment, in place of an earlier decision. Raise NotFound, Conflict or Invalid."""
    if state not in set(DecidedState):
        raise Invalid(NO_SUCH_STATE)
    reason = parse_override_reason(reason) if reason.strip() else ""
    assignment, earlier = _lock_decision(db, school_class, student, assignment_id)
    now = utc_now()
    if earlier is not None:
        earlier.withdrawn_at = now
        db.flush()
    db.add(StateDecision(assignment_id=assignment.id, account_id=student, state=state, reason=reason, by=by.id, at=now))
    audit.record_event(
        db,
        school_class.id,
        by.id,
        AuditAction.state_decided,
        student=student,
        about=assignment.title,
        before={"state": None if earlier is None else earlier.state},
        after={"state": state},
        reason=reason,
    )
    db.flush()


def withdraw_state_decision(
    db: Session, school_class: SchoolClass, by: Account, student: UUID, assignment_id: UUID
) -> None:
    """Withdraw the decision in force, if there is one. Raise NotFound or Conflict."""
    assignment, decision = _lock_decision(db, school_class, student, assignment_id)
    if decision is None:
        return
    decision.withdrawn_at = utc_now()
    audit.record_event(
        db,
        school_class.id,
        by.id,
        AuditAction.decision_withdrawn,
        student=student,
        about=assignment.title,
        before={"state": decision.state},
        after={"state": None},
    )
    db.flush()


def _lock_decision(
    db: Session, school_class: SchoolClass, student: UUID, assignment_id: UUID
) -> tuple[Assignment, StateDecision | None]:
    membership = lock_student_marks(db, school_class, student)
    assignment = assignments.find_assignment(db, school_class.id, assignment_id)
    if assignment is None:
        raise NotFound(NO_SUCH_ASSIGNMENT)
    require_assignment_concerns(db, assignment, membership)
    return assignment, repository.find_active_decision(db, assignment_id, student)


def set_marking_rules(
    db: Session, school_class: SchoolClass, by: Account, rules: MarkingRules, version: int | None = None
) -> ClassMarking:
    """Choose how states count in the means of a class. Raise Conflict.

    `version`: that of the rules which the teacher has seen; None changes them whatever they are.
    """
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    earlier = repository.load_marking_rules(db, school_class.id)
    if version is not None and version != earlier.version:
        raise Conflict(RULES_CHANGED)
    policy = repository.find_marking_policy(db, school_class.id) or MarkingPolicy(class_id=school_class.id, version=0)
    for name, counting in asdict(rules).items():
        setattr(policy, name, counting.value)
    policy.chosen_at, policy.version = utc_now(), policy.version + 1
    db.add(policy)
    if rules != earlier.rules or not earlier.is_chosen:
        audit.record_event(
            db,
            school_class.id,
            by.id,
            AuditAction.marking_changed,
            before=asdict(earlier.rules),
            after=asdict(rules),
        )
    db.flush()
    return ClassMarking(rules, True, policy.version)


def copy_marking_rules(db: Session, old: SchoolClass, new: SchoolClass) -> None:
    """Give a copied class the rules that were chosen in the old one; one never chosen leaves the defaults."""
    policy = repository.find_marking_policy(db, old.id)
    if policy is not None and policy.chosen_at is not None:
        rules = asdict(repository.load_marking_rules(db, old.id).rules)
        db.add(MarkingPolicy(class_id=new.id, chosen_at=policy.chosen_at, version=1, **rules))
