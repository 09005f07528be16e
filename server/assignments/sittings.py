"""Sittings of tests: begin one, save work, check that a student may submit.

Every function works inside the caller's transaction. Submitting, saving and ending lock the sitting's row first, so
that the end of a sitting sees everything before it, and nothing comes after.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback, repository, sitting_repository
from server.assignments.feedback import OVER, FeedbackHolds, SittingStage, WithholdingTest, sitting_stage
from server.assignments.models import Assignment, EndedBy, Mode, SavedWork, Sitting
from server.assignments.rules import Rules, rules_in_force, sitting_end
from server.base.errors import Conflict, NotFound, WrongMoment
from server.base.validation import parse_uuid
from server.sandbox.values import LIBRARY_MENTION

NO_TEST = "Ce contrôle n’existe pas."
NOT_SITTING = "Vous ne composez pas en ce moment dans cet exercice : il n’y a rien à enregistrer."
OTHER_VERSION = (
    "Une autre version a été enregistrée depuis un autre onglet ou un autre appareil : choisissez celle à garder. Rien "
    "n’est perdu."
)
NO_HELP = (
    "Pendant le contrôle « {title} », rien d’autre ne peut importer de mes_fonctions ce qu’il demande d’écrire : cela "
    "redevient possible à sa fin."
)
CANNOT_BEGIN = {
    SittingStage.before: "Ce contrôle n’est pas encore ouvert.",
    SittingStage.missed: "Ce contrôle est fermé : on ne le commence plus.",
    SittingStage.shown: "Les résultats de ce contrôle sont publiés : on ne le commence plus.",
}


class StaleWorkError(Conflict):
    """Other work was saved, from another tab or machine, since the page was opened: `saved`."""

    slug = "autre-version"
    title = "Modifié ailleurs"

    def __init__(self, saved: SavedWork) -> None:
        super().__init__(OTHER_VERSION)
        self.saved = saved


@dataclass(frozen=True)
class StudentTest:
    """A test with one student's rules, sitting and stage."""

    assignment: Assignment
    rules: Rules
    sitting: Sitting | None
    stage: SittingStage

    @property
    def ends_at(self) -> datetime | None:
        return None if self.sitting is None else sitting_end(self.rules, self.sitting)

    @property
    def is_over_but_not_ended(self) -> bool:
        """Whether the time of the sitting is over, and its row does not say so yet."""
        sitting = self.sitting
        return sitting is not None and self.stage is not SittingStage.running and sitting.handed_in_at is None


def find_test(db: Session, class_id: UUID, assignment_id: str) -> Assignment:
    """Return a test. Raises NotFound, also for an assignment that is no test."""
    assignment = repository.find_assignment(db, class_id, parse_uuid(assignment_id, NO_TEST))
    if assignment is None or assignment.mode != Mode.test:
        raise NotFound(NO_TEST)
    return assignment


def load_student_test(
    db: Session, assignment: Assignment, account_id: UUID, groups: Collection[str], now: datetime
) -> StudentTest:
    """Load a test for a student. Raises NotFound where it is for other groups."""
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    rules = rules_in_force(assignment, exemptions, account_id, groups)
    sitting = sitting_repository.load_sitting(db, assignment.id, account_id)
    if not rules.is_concerned and sitting is None:
        raise NotFound(NO_TEST)
    return StudentTest(assignment, rules, sitting, sitting_stage(assignment, rules, sitting, now))


def begin_sitting(
    db: Session, assignment: Assignment, account_id: UUID, groups: Collection[str], now: datetime
) -> None:
    """Begin a sitting; one that has begun goes on. Raises WrongMoment, or NotFound for a test of other groups."""
    test = load_student_test(db, assignment, account_id, groups, now)
    refusal = CANNOT_BEGIN.get(test.stage)
    if refusal:
        raise WrongMoment(refusal)
    sitting_repository.insert_sitting_once(db, assignment.id, account_id, now)


def require_may_submit(db: Session, account_id: UUID, exercise: str, now: datetime) -> FeedbackHolds:
    """Return the holds on an attempt submitted now.

    Raises WrongMoment before a test is begun, and from its end to its release.
    """
    holds = feedback.load_holds_at(db, account_id, exercise, now)
    if holds.submission_refusal:
        raise WrongMoment(holds.submission_refusal)
    if holds.running_tests and not _lock_running_sittings(db, holds.running_tests, account_id):
        raise WrongMoment(OVER.format(title=holds.running_tests[0].title))
    return holds


def require_no_tested_imports(db: Session, account_id: UUID, source: bytes, reused: Collection[str]) -> None:
    """Raise WrongMoment for a program that imports functions which a running test asks for.

    Its verdict is not held, so it could compare an answer with the course's own functions.
    """
    if LIBRARY_MENTION not in source:
        return
    for exercise in reused:
        if running := feedback.load_holds(db, account_id, exercise).running_tests:
            raise WrongMoment(NO_HELP.format(title=running[0].title))


def load_exercises_in_sat_tests(db: Session, account_id: UUID, at: datetime) -> frozenset[str]:
    """Return the exercises that the tests asked for which an account sat at a time: no program of theirs gets the
    course's functions of these, whatever its text says."""
    return sitting_repository.load_exercises_in_sat_tests(db, account_id, at)


def saved_work_version(saved: SavedWork | None) -> str:
    """Return the version of saved work, as forms carry it; empty where nothing is saved."""
    return "" if saved is None else saved.saved_at.isoformat()


def save_work(
    db: Session, account_id: UUID, exercise: str, source: bytes, now: datetime, *, base_version: str | None = None
) -> None:
    """Save a student's work in the running tests of an exercise.

    `base_version` is the version that the page had read; None saves over any. Raises WrongMoment where no test is
    running, and StaleWorkError where other work was saved since `base_version`.
    """
    holds = feedback.load_holds_at(db, account_id, exercise, now)
    running = _lock_running_sittings(db, holds.running_tests, account_id)
    if not running:
        raise WrongMoment(
            holds.submission_refusal or (OVER.format(title=holds.tests[0].title) if holds.tests else NOT_SITTING)
        )
    saved = sitting_repository.load_last_saved_work(db, running, account_id, exercise)
    if (
        base_version is not None
        and saved is not None
        and base_version != saved_work_version(saved)
        and saved.source != source
    ):
        raise StaleWorkError(saved)
    sitting_repository.upsert_saved_work(db, running, account_id, exercise, source, now)


def _lock_running_sittings(db: Session, tests: Collection[WithholdingTest], account_id: UUID) -> list[UUID]:
    """Lock the sittings of these tests; return the tests not handed in. A sitting that was given more time resumes."""
    running = []
    for test in sorted(tests, key=lambda test: test.assignment_id):
        sitting = sitting_repository.lock_sitting(db, test.assignment_id, account_id)
        if sitting is not None and sitting.ended_by != EndedBy.student:
            sitting.handed_in_at = sitting.ended_by = None
            running.append(test.assignment_id)
    return running


def load_last_saved_work(db: Session, account_id: UUID, exercise: str) -> SavedWork | None:
    """Return the work saved last in the tests that this account sits now."""
    running = [test.assignment_id for test in feedback.load_holds(db, account_id, exercise).running_tests]
    return sitting_repository.load_last_saved_work(db, running, account_id, exercise) if running else None


def move_guest_sittings(db: Session, guest_id: UUID, account_id: UUID) -> None:
    sitting_repository.move_sittings(db, guest_id, account_id)
