"""Apply a regrade, or undo it: all of it in the caller's transaction, or nothing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from uuid import UUID

from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict
from server.course import Course
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook import standings
from server.regrades import repository
from server.regrades.models import Regrade, RegradePolicy
from server.regrades.preview import does_new_grading_count
from server.regrades.schemas import MarkChange, RegradedAttempt, RegradeState
from server.regrades.service import load_mark_changes, load_regrade_progress, lock_regrade

RUNNING = "La recorrection n’est pas finie : encore {left} à faire."
STOPPED = "Cette recorrection a été arrêtée : préparez-en une autre."
MIXED = "L’exercice a changé pendant la recorrection, et deux versions s’y mêlent : préparez-en une autre."
OVERTAKEN = (
    "Une autre recorrection, appliquée entre-temps, a changé une partie de ces essais. Annulez-la d’abord, ou préparez "
    "une nouvelle recorrection, qui partira des notes d’aujourd’hui."
)
OVERTAKEN_UNDO = (
    "Une autre recorrection, appliquée depuis, a changé une partie de ces essais : annulez-la d’abord, puis celle-ci."
)
ACCOUNT_CHANGED = "Un élève vient de changer de compte : recommencez."


def apply_regrade(db: Session, course: Course, regrade_id: UUID, by: UUID) -> None:
    """Make the new gradings count by the policy; nothing where it is done already. Raises Conflict."""
    regrade = lock_regrade(db, regrade_id)
    if regrade.is_applied:
        return
    _require_ready_to_apply(db, regrade)
    attempts = _lock_attempts(db, regrade)
    _require_single_exercise_version(attempts)
    if any(attempt.current_id != attempt.before_id for attempt in attempts):
        raise Conflict(OVERTAKEN)
    policy = RegradePolicy(regrade.policy)
    chosen = [attempt for attempt in attempts if does_new_grading_count(policy, attempt)]
    _set_counting_gradings(db, regrade, chosen, [attempt.after_id for attempt in chosen])
    repository.set_items_applied(db, [attempt.item_id for attempt in chosen], is_applied=True)
    regrade.applied_at, regrade.undone_at = utc_now(), None
    _record_audit_events(db, course, regrade, by, AuditAction.regrade_applied, load_mark_changes(db, regrade, attempts))


def undo_regrade(db: Session, course: Course, regrade_id: UUID, by: UUID) -> None:
    """Make the old gradings count again; nothing where it is done already. Raises Conflict."""
    regrade = lock_regrade(db, regrade_id)
    if not regrade.is_applied:
        return
    attempts = _lock_attempts(db, regrade)
    applied = [attempt for attempt in attempts if attempt.is_applied]
    if any(attempt.current_id != attempt.after_id for attempt in applied):
        raise Conflict(OVERTAKEN_UNDO)
    _set_counting_gradings(db, regrade, applied, [attempt.before_id for attempt in applied])
    repository.set_items_applied(db, [attempt.item_id for attempt in applied], is_applied=False)
    regrade.undone_at = utc_now()
    reverted = [
        replace(change, before=change.after, after=change.before) for change in load_mark_changes(db, regrade, attempts)
    ]
    _record_audit_events(db, course, regrade, by, AuditAction.regrade_undone, reverted)


def _record_audit_events(
    db: Session, course: Course, regrade: Regrade, by: UUID, action: AuditAction, mark_changes: Collection[MarkChange]
) -> None:
    """Record an event for each student whose mark changes; one for the class where none does."""
    exercise = course.exercises.get(regrade.exercise)
    about = exercise.title if exercise else regrade.exercise
    changed = [change for change in mark_changes if change.before != change.after]
    for change in changed:
        before, after = {"points": change.before}, {"points": change.after}
        audit.record_event(
            db, regrade.class_id, by, action, student=change.student, about=about, before=before, after=after
        )
    if not changed:
        audit.record_event(db, regrade.class_id, by, action, about=about)


def _require_ready_to_apply(db: Session, regrade: Regrade) -> None:
    """Raise Conflict for a regrade that is running or stopped."""
    progress = load_regrade_progress(db, regrade)
    if progress.state is RegradeState.stopped:
        raise Conflict(STOPPED)
    if progress.state is RegradeState.running:
        raise Conflict(RUNNING.format(left=progress.total - progress.graded))


def _require_single_exercise_version(attempts: Sequence[RegradedAttempt]) -> None:
    """Raise Conflict where several versions of the exercise graded the attempts."""
    if len({attempt.version for attempt in attempts if attempt.after is not None}) > 1:
        raise Conflict(MIXED)


def _lock_attempts(db: Session, regrade: Regrade) -> Sequence[RegradedAttempt]:
    """Lock the accounts, then the attempts, until the commit; return the attempts.

    Raises Conflict where a guest's work has moved to an account in between.
    """
    accounts = repository.load_ids_of_authors(db, regrade.id)
    standings.lock_accounts(db, accounts)
    attempts = repository.load_regraded_attempts(db, regrade.id, lock=True)
    if not {attempt.account_id for attempt in attempts} <= accounts:
        raise Conflict(ACCOUNT_CHANGED)
    return attempts


def _set_counting_gradings(
    db: Session, regrade: Regrade, attempts: Sequence[RegradedAttempt], gradings: Sequence[UUID | None]
) -> None:
    """Make these gradings of the attempts count."""
    pairs = zip(attempts, gradings, strict=True)
    chosen = {attempt.submission_id: grading for attempt, grading in pairs if grading is not None}
    gradebook.set_counting_gradings(db, regrade.exercise, {attempt.account_id for attempt in attempts}, chosen)
