"""Having a regrade count, or no more: all of it in the caller's transaction, or nothing."""

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
from server.regrades.preview import counts_when_applied
from server.regrades.schemas import MarkChange, RegradedAttempt, RegradeState
from server.regrades.service import load_progress, lock_regrade, mark_changes

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
MOVED_HOUSE = "Un élève vient de changer de compte : recommencez."


def apply_regrade(db: Session, course: Course, regrade_id: UUID, by: UUID) -> None:
    """Has the new gradings count, as the policy says; nothing where it is done already. Raises Conflict."""
    regrade = lock_regrade(db, regrade_id)
    if regrade.is_applied:
        return
    _require_over(db, regrade)
    copies = _held(db, regrade)
    _require_one_version(copies)
    if any(copy.current_id != copy.before_id for copy in copies):
        raise Conflict(OVERTAKEN)
    moving = [copy for copy in copies if counts_when_applied(RegradePolicy(regrade.policy), copy)]
    _repoint(db, regrade, moving, [copy.after_id for copy in moving])
    repository.set_applied(db, [copy.item_id for copy in moving], moved=True)
    regrade.applied_at, regrade.undone_at = utc_now(), None
    _note(db, course, regrade, by, AuditAction.regrade_applied, mark_changes(db, regrade, copies))


def undo_regrade(db: Session, course: Course, regrade_id: UUID, by: UUID) -> None:
    """Has what counted before count again; nothing where it is done already. Raises Conflict."""
    regrade = lock_regrade(db, regrade_id)
    if not regrade.is_applied:
        return
    copies = _held(db, regrade)
    moved = [copy for copy in copies if copy.is_applied]
    if any(copy.current_id != copy.after_id for copy in moved):
        raise Conflict(OVERTAKEN_UNDO)
    _repoint(db, regrade, moved, [copy.before_id for copy in moved])
    repository.set_applied(db, [copy.item_id for copy in moved], moved=False)
    regrade.undone_at = utc_now()
    back = [replace(one, before=one.after, after=one.before) for one in mark_changes(db, regrade, copies)]
    _note(db, course, regrade, by, AuditAction.regrade_undone, back)


def _note(
    db: Session, course: Course, regrade: Regrade, by: UUID, what: AuditAction, found: Collection[MarkChange]
) -> None:
    """One event for each student whose mark changes; one for the class where none does."""
    exercise = course.exercises.get(regrade.exercise)
    about = exercise.title if exercise else regrade.exercise
    changed = [one for one in found if one.before != one.after]
    for one in changed:
        was, now = {"points": one.before}, {"points": one.after}
        audit.record_event(db, regrade.class_id, by, what, student=one.student, about=about, before=was, after=now)
    if not changed:
        audit.record_event(db, regrade.class_id, by, what, about=about)


def _require_over(db: Session, regrade: Regrade) -> None:
    """Raises Conflict."""
    found = load_progress(db, regrade)
    if found.state is RegradeState.stopped:
        raise Conflict(STOPPED)
    if found.state is RegradeState.running:
        raise Conflict(RUNNING.format(left=found.total - found.graded))


def _require_one_version(copies: Sequence[RegradedAttempt]) -> None:
    """Raises Conflict."""
    if len({copy.version for copy in copies if copy.after is not None}) > 1:
        raise Conflict(MIXED)


def _held(db: Session, regrade: Regrade) -> Sequence[RegradedAttempt]:
    """The attempts, of which nobody else changes what counts until the commit: accounts first, as everywhere.

    Raises Conflict where a guest's work has gone to an account at this very moment.
    """
    accounts = repository.load_author_ids(db, regrade.id)
    standings.lock_accounts(db, accounts)
    copies = repository.load_attempts(db, regrade.id, lock=True)
    if not {copy.account_id for copy in copies} <= accounts:
        raise Conflict(MOVED_HOUSE)
    return copies


def _repoint(db: Session, regrade: Regrade, copies: Sequence[RegradedAttempt], chosen: Sequence[UUID | None]) -> None:
    pairs = zip(copies, chosen, strict=True)
    pointers = {copy.submission_id: grading for copy, grading in pairs if grading is not None}
    gradebook.set_counting_gradings(db, regrade.exercise, {copy.account_id for copy in copies}, pointers)
