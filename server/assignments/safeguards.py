"""Refuse changes to a test that would leak held feedback, or cut short a running sitting.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Collection
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, sitting_repository
from server.assignments.models import Assignment, Exemption, Mode
from server.assignments.rule_sources import CommonRules
from server.assignments.rules import is_sitting_running, rules_in_force
from server.assignments.schemas import AssignmentInput
from server.base.errors import InvalidFields, WrongMoment

HOLDS = (
    "Ce contrôle retient ce que des élèves ont envoyé : publiez d’abord ses résultats, puis {then}. Le supprimer ou le "
    "changer ainsi les publierait sans le dire."
)
SITS = "Des élèves composent encore : attendez qu’ils aient rendu, ou que leur temps soit écoulé."
CUTS = (
    "Des élèves composent en ce moment, et leur temps finirait dans le passé : ce qu’ils viennent d’envoyer ne "
    "compterait plus. Donnez une fin qui soit encore à venir."
)
DELETE, CHANGE, REMOVE = "supprimez-le", "changez-en le mode", "retirez l’exercice"


def lock_test(db: Session, assignment: Assignment) -> None:
    """Lock a test: until the commit, nobody begins to sit it nor releases it."""
    db.refresh(assignment, with_for_update=True)


def require_no_withheld_feedback(db: Session, assignment: Assignment) -> None:
    """Raise WrongMoment where deleting a test would release held feedback."""
    refusal = _explain_unreleased_refusal(db, assignment, DELETE)
    if refusal:
        raise WrongMoment(refusal)


def _explain_unreleased_refusal(db: Session, assignment: Assignment, then: str) -> str:
    """Return why a test must be released first; empty where it holds nothing."""
    if assignment.mode != Mode.test:
        return ""
    begun, ended = sitting_repository.count_begun_and_ended_sittings(db, assignment.id)
    if begun and assignment.released_at is None:
        return HOLDS.format(then=then)
    return SITS if begun > ended else ""


def require_safe_test_change(
    db: Session, assignment: Assignment, before: AssignmentInput, after: AssignmentInput, now: datetime
) -> None:
    """Raise InvalidFields where a change of a test would release held feedback or cut short a running sitting."""
    if before.mode is not Mode.test:
        return
    problems = {}
    if after.mode is not Mode.test and (refusal := _explain_unreleased_refusal(db, assignment, CHANGE)):
        problems["mode"] = refusal
    removed = {exercise for exercise, _ in before.exercises} - {exercise for exercise, _ in after.exercises}
    if removed and (refusal := _explain_unreleased_refusal(db, assignment, REMOVE)):
        problems["exercises"] = refusal
    if not problems and after.mode is Mode.test:
        exemptions = repository.load_active_exemptions(db, assignment.id)
        if _cuts_sitting_short(db, assignment.id, (before, exemptions), (after, exemptions), now):
            shorter = after.duration_minutes != before.duration_minutes
            problems["duration_minutes" if shorter else "closes_at"] = CUTS
    if problems:
        raise InvalidFields(problems)


def require_no_sitting_cut_short(
    db: Session, assignment: Assignment, before: Collection[Exemption], after: Collection[Exemption], now: datetime
) -> None:
    """Raise WrongMoment where replacing the exemptions of a test would cut short a running sitting."""
    if assignment.mode == Mode.test and _cuts_sitting_short(
        db, assignment.id, (assignment, before), (assignment, after), now
    ):
        raise WrongMoment(CUTS)


def _cuts_sitting_short(
    db: Session,
    assignment_id: UUID,
    before: tuple[CommonRules, Collection[Exemption]],
    after: tuple[CommonRules, Collection[Exemption]],
    now: datetime,
) -> bool:
    """Whether a sitting that runs by the rules `before` would be over by the rules `after`, whatever it was told."""
    for unfinished in sitting_repository.load_unfinished_sittings(db, assignment_id):
        sitting = unfinished.sitting
        old_rules, new_rules = (
            rules_in_force(common, exemptions, sitting.account_id, unfinished.groups).without_earlier_rules
            for common, exemptions in (before, after)
        )
        if is_sitting_running(old_rules, sitting, now) and not is_sitting_running(new_rules, sitting, now):
            return True
    return False
