"""Begin, change and end the lesson of a class. Functions work inside the caller's transaction."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback
from server.assignments import repository as assignments
from server.assignments.models import Mode
from server.assignments.service import list_counting_exercises
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, Invalid, NotFound
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.service import NOT_A_MEMBER, require_not_archived
from server.course import Course
from server.lesson import repository
from server.lesson.models import LONGEST_LESSON, Afterwards, LiveLesson
from server.studio import service as studio

MIN_EXERCISES, MAX_EXERCISES = 1, 4
UNDER_WAY = "Une séance est déjà en cours dans cette classe."
NO_LESSON = "Aucune séance n’est en cours dans cette classe."
HOW_MANY = f"Choisissez d’un à {MAX_EXERCISES} exercices."
UNKNOWN_EXERCISE = "« {name} » n’est pas un exercice ouvert à cette classe : choisissez-en un dans la liste."
NO_CHALLENGE = "Choisissez l’exercice à proposer aux élèves qui ont fini."


@dataclass(frozen=True)
class LessonPlan:
    """The exercises of the day, and what a student gets who has finished them."""

    exercises: tuple[str, ...]
    next_step: Afterwards = Afterwards.none
    challenge: str = ""


def find_current_lesson(db: Session, class_id: UUID, now: datetime) -> LiveLesson | None:
    """Return the lesson that goes on in a class, or None."""
    lesson = repository.find_latest_lesson(db, class_id)
    return lesson if lesson is not None and is_lesson_under_way(lesson, now) else None


def is_lesson_under_way(lesson: LiveLesson, now: datetime) -> bool:
    return lesson.ended_at is None and lesson.started_at > now - LONGEST_LESSON


def lesson_end(lesson: LiveLesson) -> datetime:
    """Return when a lesson ended, or ends at the latest."""
    return lesson.ended_at or lesson.started_at + LONGEST_LESSON


def require_current_lesson(db: Session, class_id: UUID, now: datetime) -> LiveLesson:
    """Return the lesson that goes on. Raises Conflict."""
    lesson = find_current_lesson(db, class_id, now)
    if lesson is None:
        raise Conflict(NO_LESSON)
    return lesson


def list_available_exercises(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Sequence[str]:
    """Return the exercises that a lesson may have: those that count, then those that the teachers of the class have
    published, but for those of tests whose results are held.

    Those of assignments that are open now come first, the assignment that opened last before the others.
    """
    counting = list_counting_exercises(db, course, school_class, now)
    counting = [
        *counting,
        *(name for name in studio.list_exercises_of_class_teachers(db, school_class) if name not in counting),
    ]
    given = assignments.load_class_assignments(db, school_class.id)
    exercises = assignments.load_exercises(db, [assignment.id for assignment in given])
    tested: set[str] = set()
    first: dict[str, None] = {}
    for assignment in sorted(given, key=lambda row: row.opens_at, reverse=True):
        names = [row.exercise for row in exercises.get(assignment.id, ())]
        is_open = assignment.opens_at <= now and (assignment.closes_at is None or now < assignment.closes_at)
        if assignment.mode == Mode.test:
            is_held = assignment.released_at is None or assignment.released_at > now
            tested.update(names if is_held and assignment.opens_at <= now else ())
        elif is_open:
            first.update(dict.fromkeys(names))
    ordered = [*(name for name in first if name in counting), *(name for name in counting if name not in first)]
    return [name for name in ordered if name not in tested]


def start_lesson(
    db: Session, course: Course, school_class: SchoolClass, by: UUID, plan: LessonPlan, now: datetime
) -> LiveLesson:
    """Begin a lesson. Raises Conflict where one goes on, or Invalid."""
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)
    if find_current_lesson(db, school_class.id, now) is not None:
        raise Conflict(UNDER_WAY)
    plan = _validate_plan(db, course, school_class, plan, now)
    lesson = LiveLesson(class_id=school_class.id, started_at=now, started_by=by, **_plan_columns(plan))
    db.add(lesson)
    db.flush()
    audit.record_event(db, school_class.id, by, AuditAction.lesson_started, after=_plan_columns(plan))
    return lesson


def change_lesson(
    db: Session, course: Course, school_class: SchoolClass, by: UUID, plan: LessonPlan, now: datetime
) -> None:
    """Change the exercises of the day, or the next step. Raises Conflict or Invalid."""
    classes.lock_class(db, school_class.id)
    lesson = require_current_lesson(db, school_class.id, now)
    plan = _validate_plan(db, course, school_class, plan, now)
    before = {name: getattr(lesson, name) for name in _plan_columns(plan)}
    for name, value in _plan_columns(plan).items():
        setattr(lesson, name, value)
    audit.record_event(db, school_class.id, by, AuditAction.lesson_changed, before=before, after=_plan_columns(plan))


def end_lesson(db: Session, school_class: SchoolClass, by: UUID, now: datetime) -> LiveLesson:
    """End the lesson that goes on. Raises Conflict."""
    classes.lock_class(db, school_class.id)
    lesson = require_current_lesson(db, school_class.id, now)
    lesson.ended_at = now
    audit.record_event(db, school_class.id, by, AuditAction.lesson_ended)
    return lesson


def _plan_columns(plan: LessonPlan) -> dict[str, str | list[str] | None]:
    return {"exercises": list(plan.exercises), "next_step": plan.next_step.value, "challenge": plan.challenge or None}


def _validate_plan(
    db: Session, course: Course, school_class: SchoolClass, plan: LessonPlan, now: datetime
) -> LessonPlan:
    available = list_available_exercises(db, course, school_class, now)
    exercises = tuple(dict.fromkeys(plan.exercises))
    challenges = (plan.challenge,) if plan.next_step is Afterwards.challenge else ()
    for name in (*exercises, *filter(None, challenges)):
        if name not in available:
            raise Invalid(UNKNOWN_EXERCISE.format(name=course.title_of_exercise(name)))
    if not MIN_EXERCISES <= len(exercises) <= MAX_EXERCISES:
        raise Invalid(HOW_MANY)
    if challenges == ("",):
        raise Invalid(NO_CHALLENGE)
    return LessonPlan(exercises, plan.next_step, "".join(challenges))


def record_student_visit(
    db: Session, school_class: SchoolClass, by: UUID, student: UUID, exercise: str, now: datetime
) -> None:
    """Record that a teacher has seen a student in the lesson that goes on. Raises Conflict or NotFound."""
    lesson = require_current_lesson(db, school_class.id, now)
    if student not in {member.id for member in classes.load_active_students(db, school_class.id)}:
        raise NotFound(NOT_A_MEMBER)
    repository.save_visit(db, lesson.id, student, exercise[:200], now, by)


@dataclass(frozen=True)
class ProjectionRules:
    """The parts of a misconception that may be shown to a whole class: nothing that is held back from a student."""

    refusal: str
    shows_solution: bool


HELD = (
    "« {title} » retient encore le diagnostic de cet exercice : le projeter l’apprendrait aux élèves. Il pourra l’être "
    "quand les résultats seront publiés."
)


def load_projection_rules(db: Session, students: Collection[UUID], exercise: str) -> ProjectionRules:
    """Return the rules for these students: held diagnoses and tests forbid all, held solutions the right program."""
    holds = feedback.load_holds_by_student(db, students, exercise).values()
    diagnoses = [hold.diagnosis for hold in holds if hold.diagnosis is not None]
    refusal = HELD.format(title=diagnoses[0].title) if diagnoses else ""
    return ProjectionRules(refusal, all(hold.solution is None for hold in holds))
