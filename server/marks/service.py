"""Set and withdraw overrides, and load marks. Functions work inside the caller's transaction."""

from __future__ import annotations

import math
from collections.abc import Collection
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.class_assignments import load_class_assignments
from server.assignments.models import Assignment
from server.assignments.rules import is_assigned_to
from server.assignments.sitting_repository import load_sitting
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import list_partnerships
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Invalid, NotFound
from server.classes import repository as classes
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.service import NOT_A_MEMBER, require_not_archived
from server.course import Course
from server.database import utc_now
from server.gradebook.service import load_withholding_times
from server.identity.models import Account
from server.marks import columns_repository, repository, rubrics_repository
from server.marks.loading import load_gradebook, load_unassigned_mark
from server.marks.means import FULL_POINTS
from server.marks.models import REASON_LENGTH, Override
from server.marks.own import VisibleMarks
from server.marks.schemas import ExerciseMark
from server.text.lines import describe_forbidden_character, normalise_lines

NO_SUCH_EXERCISE = "La classe n’a pas cet exercice."
NO_SUCH_ASSIGNMENT = "La classe n’a pas ce devoir."
NOT_IN_ASSIGNMENT = "Ce devoir ne demande pas cet exercice."
NOT_CONCERNED = (
    "Ce devoir n’est pas donné à cet élève : ajoutez d’abord l’élève au groupe {groups}, sur la page « Élèves »."
)
EVERYWHERE = "dans tous les devoirs"
IN_ASSIGNMENT = "dans le devoir « {title} » seulement"
NOTHING_SET = "Cette note n’est pas modifiée, ou ne l’est plus."
ONE_OF = "Donnez des points, ou dispensez de l’exercice : l’un des deux."
OUT_OF_RANGE = "Les points vont de 0 à 20."
NOT_A_NUMBER = "« {text} » n’est pas un nombre de points : écrivez par exemple 12,5."
NEEDS_REASON = "Indiquez le motif : l’élève le lit, et le journal de la classe le garde."
LONG_REASON = f"Le motif compte {REASON_LENGTH} caractères au plus."


def parse_override_points(text: str) -> float:
    """Parse points as a teacher writes them: « 12,5 ». Raise Invalid."""
    try:
        points = float(text.strip().replace(",", "."))
    except ValueError:
        raise Invalid(NOT_A_NUMBER.format(text=text.strip()[:20])) from None
    return _require_points_in_range(points)


def _require_points_in_range(points: float) -> float:
    if not (math.isfinite(points) and 0 <= points <= FULL_POINTS):
        raise Invalid(OUT_OF_RANGE)
    return points + 0.0  # turns a negative zero into a zero


def parse_override_reason(text: str) -> str:
    """Return a reason without blanks around its lines. Raise Invalid for one that is empty, long or unreadable."""
    reason = normalise_lines(text)
    if not reason:
        raise Invalid(NEEDS_REASON)
    if len(reason) > REASON_LENGTH:
        raise Invalid(LONG_REASON)
    unwritable = describe_forbidden_character(reason)
    if unwritable:
        raise Invalid(f"Dans le motif, {unwritable}.")
    return reason


def set_override(
    db: Session,
    course: Course,
    school_class: SchoolClass,
    by: Account,
    student: UUID,
    exercise: str,
    *,
    points: float | None,
    excused: bool,
    reason: str,
    assignment_id: UUID | None = None,
) -> None:
    """Set a mark in place of the automatic one, or of an earlier override of this scope.

    `assignment_id`: the only assignment in which it holds; None: all that ask the exercise, now and later. Raise
    NotFound, Conflict or Invalid.
    """
    if (points is None) is not excused:
        raise Invalid(ONE_OF)
    points, reason = None if points is None else _require_points_in_range(points), parse_override_reason(reason)
    earlier, scope = _lock_override(db, course, school_class, student, exercise, assignment_id)
    marks = load_exercise_marks(db, course, school_class, student, exercise, assignment_id)
    now = utc_now()
    if earlier is not None:
        earlier.withdrawn_at = now
        db.flush()
    override = Override(
        class_id=school_class.id,
        account_id=student,
        exercise=exercise,
        assignment_id=assignment_id,
        points=points,
        excused=excused,
        reason=reason,
        based_on=sorted({mark.grading for mark in marks}, key=str),
        by=by.id,
        at=now,
    )
    db.add(override)
    audit.record_event(
        db,
        school_class.id,
        by.id,
        AuditAction.mark_overridden,
        student=student,
        about=f"{exercise_title(course, exercise)}, {scope}",
        before=_best_automatic_values(marks) if earlier is None else _override_values(earlier),
        after=_override_values(override),
        reason=reason,
    )
    db.flush()


def withdraw_override(
    db: Session,
    course: Course,
    school_class: SchoolClass,
    by: Account,
    student: UUID,
    exercise: str,
    reason: str = "",
    *,
    assignment_id: UUID | None = None,
) -> None:
    """Withdraw the override of this scope, if there is one: see `set_override`. Raise NotFound or Conflict.

    In an assignment, an override that holds everywhere is then in force again, else the automatic mark.
    """
    override, scope = _lock_override(db, course, school_class, student, exercise, assignment_id)
    if override is None:
        return
    marks = load_exercise_marks(db, course, school_class, student, exercise, assignment_id)
    override.withdrawn_at = utc_now()
    audit.record_event(
        db,
        school_class.id,
        by.id,
        AuditAction.override_withdrawn,
        student=student,
        about=f"{exercise_title(course, exercise)}, {scope}",
        before=_override_values(override),
        after=_best_automatic_values(marks),
        reason=parse_override_reason(reason) if reason.strip() else "",
    )
    db.flush()


def _lock_override(
    db: Session, course: Course, school_class: SchoolClass, student: UUID, exercise: str, assignment_id: UUID | None
) -> tuple[Override | None, str]:
    """Return the override in force of this scope, and the scope in words; lock those of the class until the commit."""
    membership = lock_student_marks(db, school_class, student)
    if assignment_id is None:
        if not _belongs_to_class(db, course, school_class, exercise):
            raise NotFound(NO_SUCH_EXERCISE)
        scope = EVERYWHERE
    else:
        assigned = load_class_assignments(db, school_class.id)
        assignment = next((each for each in assigned.assignments if each.id == assignment_id), None)
        if assignment is None:
            raise NotFound(NO_SUCH_ASSIGNMENT)
        if all(row.exercise != exercise for row in assigned.exercises[assignment_id]):
            raise NotFound(NOT_IN_ASSIGNMENT)
        require_assignment_concerns(db, assignment, membership)
        scope = IN_ASSIGNMENT.format(title=assignment.title)
    return repository.find_active_override(db, school_class.id, student, exercise, assignment_id), scope


def require_assignment_concerns(db: Session, assignment: Assignment, membership: Membership) -> None:
    """Raise Invalid for a student whom an assignment does not concern, and who has not sat it."""
    if not is_assigned_to(assignment, membership.groups) and not load_sitting(db, assignment.id, membership.account_id):
        raise Invalid(NOT_CONCERNED.format(groups=" ou ".join(f"« {label} »" for label in assignment.groups)))


def lock_student_marks(db: Session, school_class: SchoolClass, student: UUID) -> Membership:
    """Lock what teachers decide in an open class until the commit, and return the membership.

    Raise NotFound for anyone but an active student.
    """
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    membership = classes.find_membership(db, school_class.id, student)
    if membership is None or membership.role != ClassRole.student or membership.status != Status.active:
        raise NotFound(NOT_A_MEMBER)
    return membership


def _belongs_to_class(db: Session, course: Course, school_class: SchoolClass, exercise: str) -> bool:
    """Whether the exercise is in the module of the class, or in one of its assignments, even if it left the course."""
    known = course.exercises.get(exercise)
    if known is not None and known.id.partition("/")[0] == school_class.module:
        return True
    exercises = load_class_assignments(db, school_class.id).exercises
    return any(row.exercise == exercise for rows in exercises.values() for row in rows)


def load_exercise_marks(
    db: Session,
    course: Course,
    school_class: SchoolClass,
    student: UUID,
    exercise: str,
    assignment_id: UUID | None = None,
) -> list[ExerciseMark]:
    """Load a student's marks at an exercise: one for each assignment that asks it, or that of one of them; where none
    asks it, that of all attempts."""
    gradebook = load_gradebook(db, course, school_class, utc_now(), only=[student])
    marks = [
        exercise_mark
        for row in gradebook.rows
        for assignment, mark in zip(gradebook.assignments, row.marks, strict=True)
        for exercise_mark in mark.exercises
        if exercise_mark.exercise == exercise and assignment_id in {None, assignment.id}
    ]
    return marks or [load_unassigned_mark(db, school_class, student, exercise)]


def _override_values(override: Override) -> dict[str, object]:
    return {"points": override.points, "excused": override.excused}


def _best_automatic_values(marks: list[ExerciseMark]) -> dict[str, object]:
    """Return the best of the automatic marks of several assignments."""
    points = [mark.counted.points for mark in marks if mark.counted is not None]
    return {"points": max(points, default=None), "excused": False}


def exercise_title(course: Course, exercise: str) -> str:
    known = course.exercises.get(exercise)
    return exercise if known is None else f"{known.title} ({exercise})"


def load_visible_marks(
    db: Session, course: Course, school_class: SchoolClass, student: UUID, now: datetime
) -> VisibleMarks:
    """Load a student's marks as they may see them, without those that a test withholds; none for other members.

    The reason of an override, and who set it, are in `exercises[…].override`.
    """
    gradebook = load_gradebook(db, course, school_class, now, only=[student])
    withheld = set(load_withholding_times(db, student))
    for partner in _load_partner_ids(db, gradebook.assignments, student):
        withheld |= load_withholding_times(db, partner).keys()
    return VisibleMarks.from_gradebook(gradebook, withheld)


def _load_partner_ids(db: Session, assignments: Collection[Assignment], student: UUID) -> frozenset[UUID]:
    """Load those whose attempts count for a student in some assignment."""
    teams = load_places_of_team_assignments(db, assignments).values()
    return frozenset(share.partner.account_id for places in teams for share in list_partnerships(places, student))


def move_guest_marks(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move what teachers set for a guest to the account that the same person has opened."""
    now = utc_now()
    repository.move_overrides(db, guest_id, account_id, now)
    repository.move_decisions(db, guest_id, account_id, now)
    columns_repository.move_column_marks(db, guest_id, account_id)
    rubrics_repository.move_rubric_markings(db, guest_id, account_id)
