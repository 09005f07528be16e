"""Regrade attempts with the current version of an exercise. Every function works inside the caller's transaction.

Attempts of a regrade are graded one after the other, each as a job of its own: the result of one enqueues the next. So
a regrade takes one worker at most, classes take turns, and no student waits for more than the job that is running.

An attempt is regraded with its own seed: the same random draws give the same inputs, so that marks differ by the
version alone, and each account keeps its variant. A version that draws otherwise gives other
inputs, and the verdicts say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.assignments import counting, rules, sitting_repository
from server.assignments import repository as assignments
from server.assignments.counting import ScoredAttempt
from server.assignments.models import Assignment, AttemptSelection, Mode
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import team_rules_in_force
from server.base.errors import Conflict, Invalid, NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.models import ClassRole, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import require_not_archived
from server.course import Course
from server.database import utc_now
from server.gradebook import repository as gradings
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.queue.interfaces import Queue, Sender
from server.regrades import repository
from server.regrades.differences import FAILED, VerdictDifference, compare_verdicts
from server.regrades.models import Regrade, RegradePolicy, RegradeScope
from server.regrades.preview import CountedMark, Marker, compute_mark_changes, mark_by_best_attempt
from server.regrades.schemas import (
    AppliedRegrade,
    MarkChange,
    OutdatedExercise,
    RegradedAttempt,
    RegradeInput,
    RegradePreview,
    RegradeProgress,
    RegradeState,
)
from server.submissions.service import worker_version_requirement

#: The kind of the job that grades the next attempt of a regrade; the job's key is the regrade's id.
REGRADE_JOB = "regrade"
#: Below every submission that somebody waits for: see `server.submissions.queue_senders`.
REGRADE_RANK = 9
MAX_ATTEMPTS = 5000
HISTORY = 50

UNKNOWN = "Cette recorrection n’existe pas."
NO_EXERCISE = "Cet exercice n’est pas du module de la classe."
NO_ASSIGNMENT = "Ce devoir n’est pas de cette classe."
NOT_IN_ASSIGNMENT = "Cet exercice n’est pas dans ce devoir."
NO_STUDENT = "Cet élève n’est pas dans la classe."
ONE_SCOPE = "Choisissez un devoir ou un élève, pas les deux."
NOTHING = "Il n’y a rien à recorriger : aucun essai corrigé à cet exercice."
TOO_MANY = "C’est trop d’essais à la fois : {most} au plus. Recorrigez devoir par devoir, ou élève par élève."
ALREADY = "Une recorrection de cet exercice est déjà en cours dans cette classe : attendez sa fin, ou arrêtez-la."


@dataclass(frozen=True)
class RegradeService:
    """Starts regrades, and lists the exercises that call for one."""

    course: Course
    queue: Queue

    def start_regrade(self, db: Session, school_class: SchoolClass, by: UUID, fields: RegradeInput) -> Regrade:
        """Create a regrade and enqueue its first attempt. Raises NotFound, Invalid or Conflict."""
        require_not_archived(school_class)
        if fields.exercise not in self.load_exercise_titles(db, school_class):
            raise NotFound(NO_EXERCISE)
        classes.lock_class(db, school_class.id)
        if any(
            running.exercise == fields.exercise for running in repository.load_running_regrades(db, school_class.id)
        ):
            raise Conflict(ALREADY)
        regrade = _build_regrade(db, school_class, by, fields)
        items = _load_items_to_regrade(db, regrade)
        db.add(regrade)
        db.flush()
        repository.add_regrade_items(db, regrade.id, items)
        version = worker_version_requirement(regrade.exercise, self.course.required_worker_version(regrade.exercise))
        enqueue_next_attempt(db, self.queue, regrade.id, regrade.class_id, version)
        return regrade

    def load_exercise_titles(self, db: Session, school_class: SchoolClass) -> Mapping[str, str]:
        """Return the titles of the exercises of the class's module, by id, and of those that its assignments ask."""
        module = self.course.modules.get(school_class.module)
        if module is None:
            return {}
        titles = {exercise.id: exercise.title for exercise in module.exercises}
        asked = assignments.load_class_exercises(db, school_class.id)
        return titles | {name: self.course.title_of_exercise(name) for name in asked if name in self.course.exercises}

    def load_outdated_exercises(self, db: Session, school_class: SchoolClass) -> Sequence[OutdatedExercise]:
        """Return the exercises that have changed since attempts were graded, in the course's order."""
        versions = {name: self.course.version_of_exercise(name) for name in self.load_exercise_titles(db, school_class)}
        return repository.load_outdated_exercises(db, school_class.id, versions)


def enqueue_next_attempt(db: Session, queue: Queue, regrade_id: UUID, class_id: UUID, version: str | None) -> None:
    """Enqueue the next attempt in the class's flow, for a worker of this version (see `worker_version_requirement`)."""
    flow = f"class {class_id}"
    sender = Sender(flow, flow=flow, rank=REGRADE_RANK)
    queue.enqueue(db, REGRADE_JOB, str(regrade_id), sender=sender, required_version=version)


def _build_regrade(db: Session, school_class: SchoolClass, by: UUID, fields: RegradeInput) -> Regrade:
    """Return a regrade that is not stored yet. Raises NotFound or Invalid."""
    regrade = Regrade(
        class_id=school_class.id,
        exercise=fields.exercise,
        policy=fields.policy,
        scope=RegradeScope.school_class,
        created_by=by,
        created_at=utc_now(),
    )
    if fields.assignment is not None and fields.student is not None:
        raise Invalid(ONE_SCOPE)
    if fields.assignment is not None:
        if assignments.find_assignment(db, school_class.id, fields.assignment) is None:
            raise NotFound(NO_ASSIGNMENT)
        exercises = assignments.load_exercises(db, [fields.assignment]).get(fields.assignment, [])
        if fields.exercise not in {exercise for exercise, _ in exercises}:
            raise Invalid(NOT_IN_ASSIGNMENT)
        regrade.scope, regrade.assignment_id = RegradeScope.assignment, fields.assignment
    elif fields.student is not None:
        if fields.student not in {student.id for student in _load_active_students(db, school_class.id)}:
            raise NotFound(NO_STUDENT)
        regrade.scope, regrade.student_id = RegradeScope.student, fields.student
    return regrade


def _load_active_students(db: Session, class_id: UUID) -> Sequence[Member]:
    members = classes.load_members(db, class_id)
    return [member for member in members if member.role is ClassRole.student and member.status is Status.active]


def _load_items_to_regrade(db: Session, regrade: Regrade) -> Sequence[tuple[UUID, UUID, bool]]:
    """Return submission, grading and whether it makes a mark or a standing; those that do first. Raises Invalid."""
    student_ids = [
        student.id
        for student in _load_active_students(db, regrade.class_id)
        if regrade.student_id in (None, student.id)
    ]
    rows = repository.load_graded_attempts(db, student_ids, regrade.exercise, MAX_ATTEMPTS + 1)
    if len(rows) > MAX_ATTEMPTS:
        raise Invalid(TOO_MANY.format(most=MAX_ATTEMPTS))
    by_student: dict[UUID, list[ScoredAttempt]] = {student: [] for student in student_ids}
    for submission, student, sent_at, _, score in rows:
        by_student[student].append(ScoredAttempt(submission, sent_at, score or 0.0))
    marker = _choose_marker(db, regrade)
    in_scope = {
        attempt.id
        for student, attempts in by_student.items()
        for attempt in attempts
        # An attempt outside the dates makes no mark of the assignment, whatever its score.
        if regrade.scope != RegradeScope.assignment or marker(student, [attempt]) is not None
    }
    counted = {attempts[-1].id for attempts in by_student.values() if attempts}
    counted |= {mark[0] for student, attempts in by_student.items() if (mark := marker(student, attempts)) is not None}
    items = [
        (submission, grading, submission in counted) for submission, _, _, grading, _ in rows if submission in in_scope
    ]
    if not items:
        raise Invalid(NOTHING)
    return sorted(items, key=lambda item: not item[2])


def _choose_marker(db: Session, regrade: Regrade) -> Marker:
    """Return the function that marks a student's attempts: an assignment's rules, else the best attempt."""
    if regrade.assignment_id is None:
        return mark_by_best_attempt
    assignment = assignments.find_assignment(db, regrade.class_id, regrade.assignment_id)
    return mark_by_best_attempt if assignment is None else _build_assignment_marker(db, assignment)


def _build_assignment_marker(db: Session, assignment: Assignment) -> Marker:
    """Return a marker by the rules of the gradebook: attempts at a test count within the sitting."""
    exemptions = assignments.load_exemptions(db, [assignment.id]).get(assignment.id, [])
    places = load_places_of_team_assignments(db, [assignment]).get(assignment.id, ())
    labels = {member.id: member.groups for member in classes.load_members(db, assignment.class_id)}
    sittings = sitting_repository.load_sittings(db, [assignment.id]) if assignment.mode == Mode.test else {}

    def mark(student: UUID, attempts: Sequence[ScoredAttempt]) -> CountedMark:
        own_rules = team_rules_in_force(assignment, exemptions, student, labels.get(student, ()), places)
        windows = rules.SendingWindow(own_rules, sittings.get((assignment.id, student)))
        counted = counting.mark_attempts(windows, AttemptSelection(assignment.counts), attempts).counted
        return None if counted is None else (counted.attempt, counted.points)

    return mark


def find_regrade(db: Session, class_id: UUID, regrade_id: UUID | str) -> Regrade:
    """Return a regrade of this class. Raises NotFound."""
    regrade = repository.find_regrade(db, class_id, parse_uuid(regrade_id, UNKNOWN))
    if regrade is None:
        raise NotFound(UNKNOWN)
    return regrade


def load_regrade_history(db: Session, class_id: UUID) -> Sequence[tuple[Regrade, RegradeProgress]]:
    """Load the class's last regrades with their progress, newest first."""
    regrades = repository.load_class_regrades(db, class_id, HISTORY)
    counts = repository.count_regraded_and_all_attempts(db, [regrade.id for regrade in regrades])
    return [(regrade, _build_regrade_progress(regrade, *counts[regrade.id])) for regrade in regrades]


def load_regrade_progress(db: Session, regrade: Regrade) -> RegradeProgress:
    return _build_regrade_progress(regrade, *repository.count_regraded_and_all_attempts(db, [regrade.id])[regrade.id])


def _build_regrade_progress(regrade: Regrade, graded: int, total: int) -> RegradeProgress:
    if regrade.stopped_at is not None:
        state = RegradeState.stopped
    elif graded < total:
        state = RegradeState.running
    elif regrade.applied_at is None:
        state = RegradeState.ready
    else:
        state = RegradeState.applied if regrade.is_applied else RegradeState.undone
    return RegradeProgress(state, graded, total)


def preview_regrade(db: Session, regrade: Regrade) -> RegradePreview:
    """Return a regrade's effect on each student, sorted by name."""
    changes = {
        change.student: change
        for change in load_mark_changes(db, regrade, repository.load_regraded_attempts(db, regrade.id))
    }
    sent_since = repository.count_attempts_sent_since(db, list(changes), regrade.exercise, regrade.created_at)
    members = [member.id for member in classes.load_members(db, regrade.class_id) if member.id in changes]
    students = dict.fromkeys([*members, *changes])
    ordered = tuple(replace(changes[student], sent_since=sent_since.get(student, 0)) for student in students)
    return RegradePreview(regrade, load_regrade_progress(db, regrade), ordered)


def load_mark_changes(db: Session, regrade: Regrade, attempts: Sequence[RegradedAttempt]) -> Sequence[MarkChange]:
    """Return the change of each student's mark."""
    return compute_mark_changes(RegradePolicy(regrade.policy), attempts, _choose_marker(db, regrade))


def record_grading(
    db: Session, queue: Queue, regrade_id: UUID, item_id: UUID, graded: GradingResult, version: str | None = None
) -> None:
    """Store a new grading, which does not count yet, and enqueue the next attempt for a worker of the same version.

    Nothing is stored for an attempt that was erased with its author.
    """
    item = repository.load_ids_of_item(db, item_id)
    if item is not None and item[2] is None and gradings.lock_submission(db, item[0]) is not None:
        grading = gradebook.add_uncounted_grading(db, item[0], graded)
        differences: tuple[VerdictDifference, ...] = (FAILED,)
        if graded.verdict.outcome.counts:
            differences = compare_verdicts(Verdict.from_json(gradings.load_verdict(db, item[1])), graded.verdict)
        repository.store_new_grading(db, item_id, grading, differences)
    next_item = repository.load_next_item_to_grade(db, regrade_id)
    if next_item is not None:
        enqueue_next_attempt(db, queue, next_item[0].regrade_id, next_item[2], version)


def stop_regrade(db: Session, regrade_id: UUID) -> None:
    """Stop a regrade that is running, so that it is never applied; nothing where it is over."""
    regrade = lock_regrade(db, regrade_id)
    if load_regrade_progress(db, regrade).state is RegradeState.running:
        regrade.stopped_at = utc_now()


def find_applied_regrade(db: Session, grading_id: UUID) -> AppliedRegrade | None:
    """Return the applied regrade by which this grading counts, as its author sees it."""
    return repository.find_applied_regrade(db, grading_id)


def lock_regrade(db: Session, regrade_id: UUID) -> Regrade:
    """Lock a regrade until the commit, and return it. Raises NotFound."""
    regrade = repository.lock_regrade(db, regrade_id)
    if regrade is None:
        raise NotFound(UNKNOWN)
    return regrade
