"""Release the results of a test, take the release back, and reopen a copy that was handed in by mistake.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, sitting_repository
from server.assignments.feedback import SittingStage, clear_holds_memo, sitting_stage
from server.assignments.models import Assignment, EndedBy
from server.assignments.rules import is_sitting_running, rules_in_force
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, WrongMoment
from server.classes import repository as classes
from server.classes.schemas import ActiveStudent

ALREADY_RELEASED = "Les résultats de ce contrôle sont déjà publiés."
NOT_RELEASED = "Les résultats de ce contrôle ne sont pas publiés : il n’y a rien à reprendre."
TOO_LATE_TO_WITHDRAW = "Cette publication date de plus d’un jour : elle ne se reprend plus."
NO_COPY = "Cet élève n’a pas de copie dans ce contrôle."
NOT_HANDED_IN = "Cette copie n’a pas été rendue par l’élève : il n’y a rien à rouvrir."
RELEASED_COPY = "Les résultats sont publiés : la copie ne se rouvre plus. Reprenez d’abord la publication."
TIME_IS_OVER = "Le temps de cet élève est écoulé : accordez-lui d’abord un aménagement, puis rouvrez sa copie."
#: How long a release can be taken back.
WITHDRAWAL_TIME = timedelta(days=1)


@dataclass(frozen=True)
class ReleaseEffects:
    """The students whom a release would touch: `shut_out` could still begin, `running` sit the test now."""

    shut_out: Sequence[ActiveStudent]
    running: Sequence[ActiveStudent]


def load_release_effects(db: Session, test: Assignment, now: datetime) -> ReleaseEffects:
    """Return whom a release now would shut out, and who would go on to their own end."""
    students = classes.load_active_students(db, test.class_id)
    exemptions = repository.load_exemptions(db, [test.id]).get(test.id, ())
    sittings = sitting_repository.load_sittings(db, [test.id])

    def at_stage(stage: SittingStage) -> Sequence[ActiveStudent]:
        return [student for student in students if stage_of(student) is stage]

    def stage_of(student: ActiveStudent) -> SittingStage | None:
        rules = rules_in_force(test, exemptions, student.id, student.groups)
        sitting = sittings.get((test.id, student.id))
        return None if rules.is_exempt and sitting is None else sitting_stage(test, rules, sitting, now)

    return ReleaseEffects(at_stage(SittingStage.may_begin), at_stage(SittingStage.running))


def release_feedback(db: Session, test: Assignment, by: UUID, now: datetime) -> None:
    """Release the results of a test. Raises Conflict where they are released already."""
    _lock_test(db, test)
    if test.released_at is not None and test.released_at <= now:
        raise Conflict(ALREADY_RELEASED)
    _set_release(db, test, by, now, AuditAction.feedback_released)


def can_still_withdraw_release(test: Assignment, now: datetime) -> bool:
    return test.released_at is not None and now - test.released_at < WITHDRAWAL_TIME


def withdraw_release(db: Session, test: Assignment, by: UUID, now: datetime) -> None:
    """Withhold the results again: whoever had not begun may begin. Raises Conflict, WrongMoment after a day."""
    _lock_test(db, test)
    if test.released_at is None:
        raise Conflict(NOT_RELEASED)
    if not can_still_withdraw_release(test, now):
        raise WrongMoment(TOO_LATE_TO_WITHDRAW)
    _set_release(db, test, by, None, AuditAction.release_withdrawn)


def _lock_test(db: Session, test: Assignment) -> None:
    classes.lock_class(db, test.class_id)
    db.refresh(test)


def _set_release(db: Session, test: Assignment, by: UUID, at: datetime | None, action: AuditAction) -> None:
    before, test.released_at = test.released_at, at
    values = {"released_at": before}, {"released_at": at}
    audit.record_event(db, test.class_id, by, action, about=test.title, before=values[0], after=values[1])
    clear_holds_memo(db)


def load_students_handed_in(db: Session, test: Assignment) -> Collection[UUID]:
    """Return the students who handed in themselves."""
    sittings = sitting_repository.load_sittings(db, [test.id])
    return [account_id for (_, account_id), sitting in sittings.items() if sitting.ended_by == EndedBy.student]


def reopen_sitting(db: Session, test: Assignment, by: UUID, student: ActiveStudent, now: datetime) -> None:
    """Let a student who handed in by mistake go on to their own end; the clock has not stopped meanwhile.

    Raises WrongMoment without a sitting, once released, or where their time is over.
    """
    _lock_test(db, test)
    sitting = sitting_repository.lock_sitting(db, test.id, student.id)
    if sitting is None:
        raise WrongMoment(NO_COPY)
    if sitting.ended_by != EndedBy.student:
        raise WrongMoment(NOT_HANDED_IN)
    if test.released_at is not None and test.released_at <= now:
        raise WrongMoment(RELEASED_COPY)
    exemptions = repository.load_exemptions(db, [test.id]).get(test.id, ())
    rules = rules_in_force(test, exemptions, student.id, student.groups)
    handed_in_at = sitting.handed_in_at
    sitting.handed_in_at = sitting.ended_by = None
    if not is_sitting_running(rules, sitting, now):
        raise WrongMoment(TIME_IS_OVER)
    audit.record_event(
        db,
        test.class_id,
        by,
        AuditAction.copy_reopened,
        student=student.id,
        about=test.title,
        before={"handed_in_at": handed_in_at},
        after={"handed_in_at": None},
    )
    clear_holds_memo(db)
