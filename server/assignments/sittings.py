"""Sitting a test: beginning it, saving, whether one may send. Every function works inside the caller's transaction.

Whoever sends, saves or ends takes the sitting's row first, so that the end finds what came before it, and nothing
comes after.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback, repository, sitting_repository
from server.assignments.feedback import OVER, FeedbackHolds, HoldingTest, SittingStage, sitting_stage
from server.assignments.models import Assignment, EndedBy, Mode, SavedWork, Sitting
from server.assignments.rules import Rules, rules_in_force
from server.base.errors import NotFound, WrongMoment
from server.base.validation import parse_uuid
from server.sandbox.values import LIBRARY_MENTION

NO_TEST = "Ce contrôle n’existe pas."
NOT_SITTING = "Vous ne composez pas en ce moment dans cet exercice : il n’y a rien à enregistrer."
NO_HELP = (
    "Pendant le contrôle « {title} », rien d’autre ne peut importer de mes_fonctions ce qu’il demande d’écrire : cela "
    "redevient possible à sa fin."
)
CANNOT_BEGIN = {
    SittingStage.before: "Ce contrôle n’est pas encore ouvert.",
    SittingStage.missed: "Ce contrôle est fermé : on ne le commence plus.",
    SittingStage.shown: "Les résultats de ce contrôle sont publiés : on ne le commence plus.",
}


@dataclass(frozen=True)
class StudentTest:
    """A test as it stands to one student."""

    assignment: Assignment
    rules: Rules
    sitting: Sitting | None
    stage: SittingStage

    @property
    def ends_at(self) -> datetime | None:
        return None if self.sitting is None else feedback.sitting_end(self.rules, self.sitting)

    @property
    def is_to_collect(self) -> bool:
        """Whether its time is over, and nobody has ended it yet."""
        ended = self.sitting is not None and self.stage is not SittingStage.running
        return ended and self.sitting is not None and self.sitting.handed_in_at is None


def find_test(db: Session, class_id: UUID, assignment_id: str) -> Assignment:
    """Raises NotFound, also for an assignment that is no test."""
    found = repository.find_assignment(db, class_id, parse_uuid(assignment_id, NO_TEST))
    if found is None or found.mode != Mode.test:
        raise NotFound(NO_TEST)
    return found


def load_student_test(
    db: Session, assignment: Assignment, account_id: UUID, groups: Collection[str], now: datetime
) -> StudentTest:
    differences = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    rules = rules_in_force(assignment, differences, account_id, groups)
    sitting = sitting_repository.load_sitting(db, assignment.id, account_id)
    return StudentTest(assignment, rules, sitting, sitting_stage(assignment, rules, sitting, now))


def begin_sitting(
    db: Session, assignment: Assignment, account_id: UUID, groups: Collection[str], now: datetime
) -> None:
    """Begins it; who has begun already goes on. Raises NotNow."""
    refusal = CANNOT_BEGIN.get(load_student_test(db, assignment, account_id, groups, now).stage)
    if refusal:
        raise WrongMoment(refusal)
    sitting_repository.insert_sitting(db, assignment.id, account_id, now)


def require_may_submit(db: Session, account_id: UUID, exercise: str, now: datetime) -> FeedbackHolds:
    """What is held back of what is sent now. Raises NotNow before a test is begun, and once it has ended, until its
    release."""
    found = feedback.load_holds(db, account_id, exercise)
    if found.refusal:
        raise WrongMoment(found.refusal)
    if found.running_tests and not _kept_running(db, found.running_tests, account_id):
        raise WrongMoment(OVER.format(title=found.running_tests[0].title))
    return found


def require_no_tested_imports(db: Session, account_id: UUID, source: bytes, reused: Collection[str]) -> None:
    """Raises NotNow for a program that imports what a running test asks to write, and whose verdict no test holds: the
    course's own functions would be there to compare with."""
    if LIBRARY_MENTION not in source:
        return
    for exercise in reused:
        if running := feedback.load_holds(db, account_id, exercise).running_tests:
            raise WrongMoment(NO_HELP.format(title=running[0].title))


def save_work(db: Session, account_id: UUID, exercise: str, source: bytes, now: datetime) -> None:
    """Keeps what a student has written in the tests that they sit. Raises NotNow where they sit none."""
    found = feedback.load_holds(db, account_id, exercise)
    kept = _kept_running(db, found.running_tests, account_id)
    if not kept:
        raise WrongMoment(found.refusal or (OVER.format(title=found.tests[0].title) if found.tests else NOT_SITTING))
    sitting_repository.upsert_saved_work(db, kept, account_id, exercise, source, now)


def _kept_running(db: Session, tests: Collection[HoldingTest], account_id: UUID) -> list[UUID]:
    """Locks these sittings; those that are not handed in. One that time had ended, and that has more now, goes on."""
    kept = []
    for test in sorted(tests, key=lambda test: test.assignment_id):
        sitting = sitting_repository.lock_sitting(db, test.assignment_id, account_id)
        if sitting is not None and sitting.ended_by != EndedBy.student:
            sitting.handed_in_at = sitting.ended_by = None
            kept.append(test.assignment_id)
    return kept


def load_last_saved_work(db: Session, account_id: UUID, exercise: str) -> SavedWork | None:
    """What stands in the tests that this account sits at present."""
    running = [test.assignment_id for test in feedback.load_holds(db, account_id, exercise).running_tests]
    return sitting_repository.load_last_saved_work(db, running, account_id, exercise) if running else None


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    sitting_repository.move_sittings(db, guest_id, account_id)
