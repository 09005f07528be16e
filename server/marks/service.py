"""Setting a mark, taking that back, and what marks come to. Functions work inside the caller's transaction."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Invalid, NotFound
from server.classes import repository as classes
from server.classes.models import ClassRole, SchoolClass, Status
from server.classes.service import NOT_A_MEMBER, require_open
from server.course import Course
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook import standings
from server.identity.models import Account
from server.marks import repository
from server.marks.loading import load_gradebook, load_unassigned_mark
from server.marks.means import FULL
from server.marks.models import REASON_LENGTH, Override
from server.marks.schemas import EffectivePoints, ExerciseMark, OwnMarks, StudentExercise

NO_SUCH_EXERCISE = "La classe n’a pas cet exercice."
NOTHING_SET = "Cette note n’est pas modifiée, ou ne l’est plus."
ONE_OF = "Donnez des points, ou dispensez de l’exercice : l’un des deux."
OUT_OF_RANGE = "Les points vont de 0 à 20."
NOT_A_NUMBER = "« {text} » n’est pas un nombre de points : écrivez par exemple 12,5."
NEEDS_REASON = "Indiquez le motif : l’élève le lit, et le journal de la classe le garde."
LONG_REASON = f"Le motif compte {REASON_LENGTH} caractères au plus."
UNREADABLE = "Le motif contient un caractère qui ne s’écrit pas."


def load_effective_points(
    db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]
) -> Mapping[StudentExercise, EffectivePoints]:
    """The points in force in a class of many students at many exercises, whatever its assignments: two queries.

    An automatic mark is the best of all attempts here. A pair with neither attempt nor override is left out.
    """
    best = standings.load_standings(db, students, exercises)
    found = {key: EffectivePoints(FULL * sums.best_score) for key, sums in best.items()}
    for key, one in repository.load_overrides(db, class_id, students, exercises).items():
        found[key] = EffectivePoints(found[key].automatic if key in found else None, one)
    return found


def parse_points(text: str) -> float:
    """As somebody writes them: « 12,5 ». Raises Invalid."""
    try:
        points = float(text.strip().replace(",", "."))
    except ValueError:
        raise Invalid(NOT_A_NUMBER.format(text=text.strip()[:20])) from None
    return _in_range(points)


def _in_range(points: float) -> float:
    if not (math.isfinite(points) and 0 <= points <= FULL):
        raise Invalid(OUT_OF_RANGE)
    return points + 0.0  # of a negative zero makes a zero


def parse_reason(text: str) -> str:
    """Raises Invalid."""
    reason = "\n".join(line.strip() for line in text.strip().splitlines())
    if not reason:
        raise Invalid(NEEDS_REASON)
    if len(reason) > REASON_LENGTH:
        raise Invalid(LONG_REASON)
    if not reason.replace("\n", " ").replace("\t", " ").isprintable():
        raise Invalid(UNREADABLE)
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
) -> None:
    """Sets a mark in place of the automatic one, or of the one set before. Raises NotFound, Conflict or Invalid."""
    if (points is None) is not excused:
        raise Invalid(ONE_OF)
    points, reason = None if points is None else _in_range(points), parse_reason(reason)
    before = _ready(db, course, school_class, student, exercise)
    marks = load_exercise_marks(db, course, school_class, student, exercise)
    now = utc_now()
    if before is not None:
        before.withdrawn_at = now
        db.flush()
    made = Override(
        class_id=school_class.id,
        account_id=student,
        exercise=exercise,
        points=points,
        excused=excused,
        reason=reason,
        based_on=sorted({one.grading for one in marks}, key=str),
        by=by.id,
        at=now,
    )
    db.add(made)
    old = _values(before) if before is not None else _automatic(marks)
    audit.record_event(
        db,
        school_class.id,
        by.id,
        AuditAction.mark_overridden,
        student=student,
        about=exercise_title(course, exercise),
        before=old,
        after=_values(made),
        reason=reason,
    )
    db.flush()


def withdraw_override(
    db: Session, course: Course, school_class: SchoolClass, by: Account, student: UUID, exercise: str, reason: str = ""
) -> None:
    """The automatic mark is in force again, as it may be already. Raises NotFound or Conflict."""
    before = _ready(db, course, school_class, student, exercise)
    if before is None:
        return
    marks = load_exercise_marks(db, course, school_class, student, exercise)
    before.withdrawn_at = utc_now()
    audit.record_event(
        db,
        school_class.id,
        by.id,
        AuditAction.override_withdrawn,
        student=student,
        about=exercise_title(course, exercise),
        before=_values(before),
        after=_automatic(marks),
        reason=parse_reason(reason) if reason.strip() else "",
    )
    db.flush()


def _ready(db: Session, course: Course, school_class: SchoolClass, student: UUID, exercise: str) -> Override | None:
    """The override in force; nobody else sets or withdraws one in this class until the commit."""
    require_open(school_class)
    classes.lock_class(db, school_class.id)
    membership = classes.find_membership(db, school_class.id, student)
    if membership is None or membership.role != ClassRole.student or membership.status != Status.active:
        raise NotFound(NOT_A_MEMBER)
    if not _is_of(db, course, school_class, exercise):
        raise NotFound(NO_SUCH_EXERCISE)
    return repository.find_override(db, school_class.id, student, exercise)


def _is_of(db: Session, course: Course, school_class: SchoolClass, exercise: str) -> bool:
    """One of the module's, or of an assignment of the class, which may have outlived it in the course."""
    known = course.exercises.get(exercise)
    if known is not None and known.id.partition("/")[0] == school_class.module:
        return True
    given = assignments.load_exercises(db, [one.id for one in assignments.load_class_assignments(db, school_class.id)])
    return any(one.exercise == exercise for rows in given.values() for one in rows)


def load_exercise_marks(
    db: Session, course: Course, school_class: SchoolClass, student: UUID, exercise: str
) -> list[ExerciseMark]:
    """A student's marks at an exercise: one for each assignment that asks it; where none does, that of all attempts."""
    made = load_gradebook(db, course, school_class, utc_now(), only=[student])
    found = [one for row in made.rows for mark in row.marks for one in mark.exercises if one.exercise == exercise]
    return found or [load_unassigned_mark(db, school_class, student, exercise)]


def _values(one: Override) -> dict[str, object]:
    return {"points": one.points, "excused": one.excused}


def _automatic(marks: list[ExerciseMark]) -> dict[str, object]:
    """Of several assignments the best."""
    points = [one.counted.points for one in marks if one.counted is not None]
    return {"points": max(points, default=None), "excused": False}


def exercise_title(course: Course, exercise: str) -> str:
    known = course.exercises.get(exercise)
    return exercise if known is None else f"{known.title} ({exercise})"


def load_own_marks(db: Session, course: Course, school_class: SchoolClass, student: UUID, now: datetime) -> OwnMarks:
    """What a student is told of their marks: all but those of a test that is held back. None of who learns not here.

    The reason of an override is told: it stands in `exercises[…].override`, with who set it.
    """
    made = load_gradebook(db, course, school_class, now, only=[student])
    return OwnMarks.of(made, gradebook.load_withholding_times(db, student))


def adopt_overrides(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """What was set on a guest's marks holds for the account that the same person has opened."""
    repository.move(db, guest_id, account_id, utc_now())
