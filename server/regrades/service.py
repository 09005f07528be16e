"""Grading anew what was sent, and what it would do. Every function works inside the caller's transaction.

Attempts of a regrade are graded one after the other, each as a job of its own: the next is put with the result of the
one before. So a regrade takes one worker at most, its class's turns come round with those of other classes, and no
student waits for more than the one job that is being done.

An attempt is graded with the seed that it had: what the new version draws in the same way is the same, so that marks
differ by the version alone; numbers that were dealt to an account are its own. A version that draws otherwise gives
everybody other inputs, and the verdicts tell.
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
from server.base.errors import Conflict, Invalid, NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.models import ClassRole, SchoolClass, Status
from server.classes.schemas import Member
from server.classes.service import require_open
from server.course import Course
from server.database import utc_now
from server.gradebook import repository as gradings
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.queue.interfaces import Queue, Sender
from server.regrades import repository
from server.regrades.differences import FAILED, VerdictDifference, compare_verdicts
from server.regrades.models import Regrade, RegradePolicy, RegradeScope
from server.regrades.preview import CountedMark, Marker, best_mark, compute_changes
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
from server.submissions.service import version_requirement

#: The kind of the job that grades the next attempt of a regrade; its key is the regrade's id.
REGRADE_JOB = "regrade"
#: After all that anybody waits for: see `server.submissions.queue_senders`.
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
    """What begins regrades, and says which are called for."""

    course: Course
    queue: Queue

    def start(self, db: Session, school_class: SchoolClass, by: UUID, wanted: RegradeInput) -> Regrade:
        """Raises NotFound, Invalid or Conflict."""
        require_open(school_class)
        if wanted.exercise not in self.exercises(school_class):
            raise NotFound(NO_EXERCISE)
        classes.lock_class(db, school_class.id)
        if any(one.exercise == wanted.exercise for one in repository.load_running_regrades(db, school_class.id)):
            raise Conflict(ALREADY)
        made = _made(db, school_class, by, wanted)
        rows = _attempts(db, made)
        db.add(made)
        db.flush()
        repository.add_items(db, made.id, rows)
        needs = version_requirement(made.exercise, self.course.version_of(made.exercise))
        enqueue_next(db, self.queue, made.id, made.class_id, needs)
        return made

    def exercises(self, school_class: SchoolClass) -> Mapping[str, str]:
        """The exercises of the class's module, with their titles."""
        module = self.course.modules.get(school_class.module)
        return {} if module is None else {one.id: one.title for one in module.exercises}

    def outdated(self, db: Session, school_class: SchoolClass) -> Sequence[OutdatedExercise]:
        """Exercises that have changed since some attempts were graded, in the course's order."""
        versions = {name: self.course.version_of(name) for name in self.exercises(school_class)}
        return repository.load_outdated_exercises(db, school_class.id, versions)


def enqueue_next(db: Session, queue: Queue, regrade_id: UUID, class_id: UUID, needs: str | None) -> None:
    """Has the next attempt graded, in the class's turn, by a worker that `needs` fits (see `needs_of`)."""
    whose = f"class {class_id}"
    queue.enqueue(
        db, REGRADE_JOB, str(regrade_id), sender=Sender(whose, flow=whose, rank=REGRADE_RANK), required_version=needs
    )


def _made(db: Session, school_class: SchoolClass, by: UUID, wanted: RegradeInput) -> Regrade:
    """Not stored yet. Raises NotFound or Invalid."""
    made = Regrade(
        class_id=school_class.id,
        exercise=wanted.exercise,
        policy=wanted.policy,
        scope=RegradeScope.school_class,
        created_by=by,
        created_at=utc_now(),
    )
    if wanted.assignment is not None and wanted.student is not None:
        raise Invalid(ONE_SCOPE)
    if wanted.assignment is not None:
        if assignments.find_assignment(db, school_class.id, wanted.assignment) is None:
            raise NotFound(NO_ASSIGNMENT)
        parts = assignments.load_exercises(db, [wanted.assignment]).get(wanted.assignment, [])
        if wanted.exercise not in {part.exercise for part in parts}:
            raise Invalid(NOT_IN_ASSIGNMENT)
        made.scope, made.assignment_id = RegradeScope.assignment, wanted.assignment
    elif wanted.student is not None:
        if wanted.student not in {one.id for one in _students(db, school_class.id)}:
            raise NotFound(NO_STUDENT)
        made.scope, made.student_id = RegradeScope.student, wanted.student
    return made


def _students(db: Session, class_id: UUID) -> Sequence[Member]:
    everyone = classes.load_members(db, class_id)
    return [one for one in everyone if one.role is ClassRole.student and one.status is Status.active]


def _attempts(db: Session, regrade: Regrade) -> Sequence[tuple[UUID, UUID, bool]]:
    """What is to be graded anew, those first that make the marks and the standings. Raises Invalid."""
    students = [one.id for one in _students(db, regrade.class_id) if regrade.student_id in (None, one.id)]
    found = repository.load_graded_attempts(db, students, regrade.exercise, MAX_ATTEMPTS + 1)
    if len(found) > MAX_ATTEMPTS:
        raise Invalid(TOO_MANY.format(most=MAX_ATTEMPTS))
    of_students: dict[UUID, list[ScoredAttempt]] = {name: [] for name in students}
    for submission, student, sent_at, _, score in found:
        of_students[student].append(ScoredAttempt(submission, sent_at, score or 0.0))
    marker = _marker(db, regrade)
    kept = {one.id for sent in of_students.values() for one in sent}
    if regrade.scope == RegradeScope.assignment:
        # What is outside of the dates makes no mark of this assignment, whatever it is worth.
        kept = {one.id for student, sent in of_students.items() for one in sent if marker(student, [one]) is not None}
    counted = {sent[-1].id for sent in of_students.values() if sent}
    counted |= {marked[0] for student, sent in of_students.items() if (marked := marker(student, sent)) is not None}
    rows = [
        (submission, grading, submission in counted) for submission, _, _, grading, _ in found if submission in kept
    ]
    if not rows:
        raise Invalid(NOTHING)
    return sorted(rows, key=lambda row: not row[2])


def _marker(db: Session, regrade: Regrade) -> Marker:
    """What makes a mark: in an assignment its rules, else one's best attempt."""
    if regrade.assignment_id is None:
        return best_mark
    assignment = assignments.find_assignment(db, regrade.class_id, regrade.assignment_id)
    return best_mark if assignment is None else _by_rules(db, assignment)


def _by_rules(db: Session, assignment: Assignment) -> Marker:
    """As in the gradebook: of a test, what was sent while its student sat it."""
    differences = assignments.load_exemptions(db, [assignment.id]).get(assignment.id, [])
    labels = {one.id: one.groups for one in classes.load_members(db, assignment.class_id)}
    sittings = sitting_repository.load_sittings(db, [assignment.id]) if assignment.mode == Mode.test else None

    def mark(student: UUID, attempts: Sequence[ScoredAttempt]) -> CountedMark:
        mine = rules.rules_in_force(assignment, differences, student, labels.get(student, ()))
        if sittings is not None:
            sat = sittings.get((assignment.id, student))
            attempts = counting.attempts_in_sitting(attempts, sat.began_at, sat.handed_in_at) if sat else ()
        found = counting.mark_attempts(mine, AttemptSelection(assignment.counts), attempts).counted
        return None if found is None else (found.attempt, found.points)

    return mark


def find_regrade(db: Session, class_id: UUID, regrade_id: UUID | str) -> Regrade:
    """Raises NotFound for one that is not of this class."""
    found = repository.find_regrade(db, class_id, parse_uuid(regrade_id, UNKNOWN))
    if found is None:
        raise NotFound(UNKNOWN)
    return found


def load_history(db: Session, class_id: UUID) -> Sequence[tuple[Regrade, RegradeProgress]]:
    """The class's last regrades, newest first."""
    found = repository.load_class_regrades(db, class_id, HISTORY)
    counts = repository.count_graded(db, [one.id for one in found])
    return [(one, _advance(one, *counts[one.id])) for one in found]


def load_progress(db: Session, regrade: Regrade) -> RegradeProgress:
    return _advance(regrade, *repository.count_graded(db, [regrade.id])[regrade.id])


def _advance(regrade: Regrade, graded: int, total: int) -> RegradeProgress:
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
    """What it does to whom, in the order of a list of names."""
    found = {one.student: one for one in mark_changes(db, regrade, repository.load_attempts(db, regrade.id))}
    since = repository.count_sent_since(db, list(found), regrade.exercise, regrade.created_at)
    order = [one.id for one in classes.load_members(db, regrade.class_id) if one.id in found]
    names = [*order, *(name for name in found if name not in set(order))]
    told = tuple(replace(found[name], sent_since=since.get(name, 0)) for name in names)
    return RegradePreview(regrade, load_progress(db, regrade), told)


def mark_changes(db: Session, regrade: Regrade, copies: Sequence[RegradedAttempt]) -> Sequence[MarkChange]:
    """One for each student."""
    return compute_changes(RegradePolicy(regrade.policy), copies, _marker(db, regrade))


def record_grading(
    db: Session, queue: Queue, regrade_id: UUID, item_id: UUID, graded: GradingResult, needs: str | None = None
) -> None:
    """Keeps a new grading, which does not count yet, and has the next attempt graded, by a worker of the same version.

    Nothing is kept of an attempt that has gone with its author.
    """
    item = repository.load_item_ids(db, item_id)
    if item is not None and item[2] is None and gradings.lock_submission(db, item[0]) is not None:
        grading = gradebook.add_uncounted_grading(db, item[0], graded)
        why: tuple[VerdictDifference, ...] = (FAILED,)
        if graded.verdict.outcome.counts:
            why = compare_verdicts(Verdict.from_json(gradings.load_verdict(db, item[1])), graded.verdict)
        repository.set_graded(db, item_id, grading, why)
    following = repository.load_next_item(db, regrade_id)
    if following is not None:
        enqueue_next(db, queue, following[0].regrade_id, following[2], needs)


def stop_regrade(db: Session, regrade_id: UUID) -> None:
    """No more attempts are graded; nothing where it is over. What was found is never applied."""
    regrade = lock_regrade(db, regrade_id)
    if load_progress(db, regrade).state is RegradeState.running:
        regrade.stopped_at = utc_now()


def find_applied_regrade(db: Session, grading_id: UUID) -> AppliedRegrade | None:
    """What the author of an attempt is told, while a regrade has this grading of it count."""
    return repository.find_applied_regrade(db, grading_id)


def lock_regrade(db: Session, regrade_id: UUID) -> Regrade:
    """Raises NotFound."""
    regrade = repository.lock_regrade(db, regrade_id)
    if regrade is None:
        raise NotFound(UNKNOWN)
    return regrade
