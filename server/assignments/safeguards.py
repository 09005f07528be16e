"""What may not be changed of a test: what it holds back is released, never let out; who sits it keeps their time.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Collection
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback, repository, sitting_repository
from server.assignments.models import Assignment, Exemption, Mode
from server.assignments.rules import CommonRules, rules_in_force
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
    """Nobody begins to sit it, nor releases it, until the commit."""
    db.refresh(assignment, with_for_update=True)


def require_nothing_held(db: Session, assignment: Assignment) -> None:
    """That a test may go. Raises NotNow."""
    refusal = _refusal(db, assignment, DELETE)
    if refusal:
        raise WrongMoment(refusal)


def _refusal(db: Session, assignment: Assignment, then: str) -> str:
    """Why what a test holds back cannot be let go of; empty where it holds nothing of anybody."""
    if assignment.mode != Mode.test:
        return ""
    begun, ended = sitting_repository.count_sittings(db, assignment.id)
    if begun and assignment.released_at is None:
        return HOLDS.format(then=then)
    return SITS if begun > ended else ""


def require_coherent(
    db: Session, assignment: Assignment, before: AssignmentInput, after: AssignmentInput, now: datetime
) -> None:
    """That a test may be changed so. Raises FieldsRefused."""
    if before.mode is not Mode.test:
        return
    problems = {}
    if after.mode is not Mode.test and (refusal := _refusal(db, assignment, CHANGE)):
        problems["mode"] = refusal
    gone = {one.exercise for one in before.exercises} - {one.exercise for one in after.exercises}
    if gone and (refusal := _refusal(db, assignment, REMOVE)):
        problems["exercises"] = refusal
    if not problems and after.mode is Mode.test:
        told = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
        if _cut_off(db, assignment.id, (before, told), (after, told), now):
            shorter = after.duration_minutes != before.duration_minutes
            problems["duration_minutes" if shorter else "closes_at"] = CUTS
    if problems:
        raise InvalidFields(problems)


def require_exempted_go_on(
    db: Session, assignment: Assignment, before: Collection[Exemption], after: Collection[Exemption], now: datetime
) -> None:
    """That the exemptions of a test may become these. Raises NotNow."""
    if assignment.mode == Mode.test and _cut_off(db, assignment.id, (assignment, before), (assignment, after), now):
        raise WrongMoment(CUTS)


def _cut_off(
    db: Session,
    assignment_id: UUID,
    before: tuple[CommonRules, Collection[Exemption]],
    after: tuple[CommonRules, Collection[Exemption]],
    now: datetime,
) -> bool:
    """Whether somebody sits it now by the one, whose time would be over by the other."""
    for one in sitting_repository.load_unfinished_sittings(db, assignment_id):
        was, becomes = (
            rules_in_force(frame, told, one.sitting.account_id, one.groups) for frame, told in (before, after)
        )
        if feedback.is_sitting_running(was, one.sitting, now) and not feedback.is_sitting_running(
            becomes, one.sitting, now
        ):
            return True
    return False
