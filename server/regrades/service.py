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
from server.assignments import counting, papers, rules
from server.assignments import repository as assignments
from server.assignments.counting import Sent
from server.assignments.models import Assignment, Counts, Mode
from server.base.errors import Conflict, Invalid, NotFound
from server.base.identities import identity_of
from server.classes import repository as classes
from server.classes.models import SchoolClass, Seat, Status
from server.classes.schemas import Member
from server.classes.service import require_open
from server.course import Course
from server.database import utc_now
from server.gradebook import repository as gradings
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.queue.port import Queue, Sender
from server.regrades import repository
from server.regrades.models import Policy, Regrade, Scope
from server.regrades.preview import Marked, Marker, best, changes
from server.regrades.schemas import Advance, Change, Copy, Outdated, Preview, State, Told, Wanted
from server.regrades.why import FAILED, Reason, reasons
from server.submissions.service import needs_of

#: The kind of the job that grades the next attempt of a regrade; its key is the regrade's id.
REGRADE = "regrade"
#: After all that anybody waits for: see `server.submissions.senders`.
REGRADE_RANK = 9
MOST_ATTEMPTS = 5000
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
class Regrades:
    """What begins regrades, and says which are called for."""

    course: Course
    queue: Queue

    def start(self, db: Session, school_class: SchoolClass, by: UUID, wanted: Wanted) -> Regrade:
        """Raises NotFound, Invalid or Conflict."""
        require_open(school_class)
        if wanted.exercise not in self.exercises(school_class):
            raise NotFound(NO_EXERCISE)
        classes.lock(db, school_class.id)
        if any(one.exercise == wanted.exercise for one in repository.running(db, school_class.id)):
            raise Conflict(ALREADY)
        made = _made(db, school_class, by, wanted)
        rows = _attempts(db, made)
        db.add(made)
        db.flush()
        repository.add_items(db, made.id, rows)
        needs = needs_of(made.exercise, self.course.version_of(made.exercise))
        put(db, self.queue, made.id, made.class_id, needs)
        return made

    def exercises(self, school_class: SchoolClass) -> Mapping[str, str]:
        """The exercises of the class's module, with their titles."""
        module = self.course.modules.get(school_class.module)
        return {} if module is None else {one.id: one.title for one in module.exercises}

    def outdated(self, db: Session, school_class: SchoolClass) -> Sequence[Outdated]:
        """Exercises that have changed since some attempts were graded, in the course's order."""
        versions = {name: self.course.version_of(name) for name in self.exercises(school_class)}
        return repository.outdated(db, school_class.id, versions)


def put(db: Session, queue: Queue, regrade_id: UUID, class_id: UUID, needs: str | None) -> None:
    """Has the next attempt graded, in the class's turn, by a worker that `needs` fits (see `needs_of`)."""
    whose = f"class {class_id}"
    queue.put(db, REGRADE, str(regrade_id), sender=Sender(whose, line=whose, rank=REGRADE_RANK), needs=needs)


def _made(db: Session, school_class: SchoolClass, by: UUID, wanted: Wanted) -> Regrade:
    """Not stored yet. Raises NotFound or Invalid."""
    made = Regrade(
        class_id=school_class.id,
        exercise=wanted.exercise,
        policy=wanted.policy,
        scope=Scope.school_class,
        created_by=by,
        created_at=utc_now(),
    )
    if wanted.assignment is not None and wanted.student is not None:
        raise Invalid(ONE_SCOPE)
    if wanted.assignment is not None:
        if assignments.by_id(db, school_class.id, wanted.assignment) is None:
            raise NotFound(NO_ASSIGNMENT)
        parts = assignments.exercises(db, [wanted.assignment]).get(wanted.assignment, [])
        if wanted.exercise not in {part.exercise for part in parts}:
            raise Invalid(NOT_IN_ASSIGNMENT)
        made.scope, made.assignment_id = Scope.assignment, wanted.assignment
    elif wanted.student is not None:
        if wanted.student not in {one.id for one in _students(db, school_class.id)}:
            raise NotFound(NO_STUDENT)
        made.scope, made.student_id = Scope.student, wanted.student
    return made


def _students(db: Session, class_id: UUID) -> Sequence[Member]:
    everyone = classes.members(db, class_id)
    return [one for one in everyone if one.seat is Seat.student and one.status is Status.active]


def _attempts(db: Session, regrade: Regrade) -> Sequence[tuple[UUID, UUID, bool]]:
    """What is to be graded anew, those first that make the marks and the standings. Raises Invalid."""
    students = [one.id for one in _students(db, regrade.class_id) if regrade.student_id in (None, one.id)]
    found = repository.graded_attempts(db, students, regrade.exercise, MOST_ATTEMPTS + 1)
    if len(found) > MOST_ATTEMPTS:
        raise Invalid(TOO_MANY.format(most=MOST_ATTEMPTS))
    of_students: dict[UUID, list[Sent]] = {name: [] for name in students}
    for submission, student, sent_at, _, score in found:
        of_students[student].append(Sent(submission, sent_at, score or 0.0))
    marker = _marker(db, regrade)
    kept = {one.id for sent in of_students.values() for one in sent}
    if regrade.scope == Scope.assignment:
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
        return best
    assignment = assignments.by_id(db, regrade.class_id, regrade.assignment_id)
    return best if assignment is None else _by_rules(db, assignment)


def _by_rules(db: Session, assignment: Assignment) -> Marker:
    """As in the gradebook: of a test, what was sent while its student sat it."""
    differences = assignments.exemptions(db, [assignment.id]).get(assignment.id, [])
    labels = {one.id: one.groups for one in classes.members(db, assignment.class_id)}
    sittings = papers.sittings_of(db, [assignment.id]) if assignment.mode == Mode.test else None

    def mark(student: UUID, attempts: Sequence[Sent]) -> Marked:
        mine = rules.in_force(assignment, differences, student, labels.get(student, ()))
        if sittings is not None:
            sat = sittings.get((assignment.id, student))
            attempts = counting.in_sitting(attempts, sat.began_at, sat.handed_in_at) if sat else ()
        found = counting.result(mine, Counts(assignment.counts), attempts).counted
        return None if found is None else (found.attempt, found.points)

    return mark


def find(db: Session, class_id: UUID, regrade_id: UUID | str) -> Regrade:
    """Raises NotFound for one that is not of this class."""
    found = repository.by_id(db, class_id, identity_of(regrade_id, UNKNOWN))
    if found is None:
        raise NotFound(UNKNOWN)
    return found


def history(db: Session, class_id: UUID) -> Sequence[tuple[Regrade, Advance]]:
    """The class's last regrades, newest first."""
    found = repository.of_class(db, class_id, HISTORY)
    counts = repository.counts(db, [one.id for one in found])
    return [(one, _advance(one, *counts[one.id])) for one in found]


def advance(db: Session, regrade: Regrade) -> Advance:
    return _advance(regrade, *repository.counts(db, [regrade.id])[regrade.id])


def _advance(regrade: Regrade, graded: int, total: int) -> Advance:
    if regrade.stopped_at is not None:
        state = State.stopped
    elif graded < total:
        state = State.running
    elif regrade.applied_at is None:
        state = State.ready
    else:
        state = State.applied if regrade.is_applied else State.undone
    return Advance(state, graded, total)


def preview(db: Session, regrade: Regrade) -> Preview:
    """What it does to whom, in the order of a list of names."""
    found = {one.student: one for one in changes_of(db, regrade, repository.copies(db, regrade.id))}
    since = repository.sent_since(db, list(found), regrade.exercise, regrade.created_at)
    order = [one.id for one in classes.members(db, regrade.class_id) if one.id in found]
    names = [*order, *(name for name in found if name not in set(order))]
    told = tuple(replace(found[name], since=since.get(name, 0)) for name in names)
    return Preview(regrade, advance(db, regrade), told)


def changes_of(db: Session, regrade: Regrade, copies: Sequence[Copy]) -> Sequence[Change]:
    """One for each student."""
    return changes(Policy(regrade.policy), copies, _marker(db, regrade))


def record(
    db: Session, queue: Queue, regrade_id: UUID, item_id: UUID, graded: GradingResult, needs: str | None = None
) -> None:
    """Keeps a new grading, which does not count yet, and has the next attempt graded, by a worker of the same version.

    Nothing is kept of an attempt that has gone with its author.
    """
    item = repository.item(db, item_id)
    if item is not None and item[2] is None and gradings.lock_submission(db, item[0]) is not None:
        grading = gradebook.add_uncounted_grading(db, item[0], graded)
        why: tuple[Reason, ...] = (FAILED,)
        if graded.verdict.outcome.counts:
            why = reasons(Verdict.from_json(gradings.load_verdict(db, item[1])), graded.verdict)
        repository.set_graded(db, item_id, grading, why)
    following = repository.next_item(db, regrade_id)
    if following is not None:
        put(db, queue, following[0].regrade_id, following[2], needs)


def stop(db: Session, regrade_id: UUID) -> None:
    """No more attempts are graded; nothing where it is over. What was found is never applied."""
    regrade = locked(db, regrade_id)
    if advance(db, regrade).state is State.running:
        regrade.stopped_at = utc_now()


def told(db: Session, grading_id: UUID) -> Told | None:
    """What the author of an attempt is told, while a regrade has this grading of it count."""
    return repository.told(db, grading_id)


def locked(db: Session, regrade_id: UUID) -> Regrade:
    """Raises NotFound."""
    regrade = repository.locked(db, regrade_id)
    if regrade is None:
        raise NotFound(UNKNOWN)
    return regrade
