"""What those who teach the class have done of it: assignments, a test and its results, a mark, what was said.

Each through the service that a teacher's click takes, so that it stands in the class's log.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import editing, exemption_service, releases, sitting_repository
from server.assignments.models import Assignment, EndedBy, LatePolicy, Mode, WeightedExercise
from server.assignments.schemas import AssignmentInput, ExemptionInput, ExemptionTarget
from server.base.settings import Settings
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.schemas import Member
from server.comments import notes, notes_repository
from server.comments import service as comments
from server.comments.line_tracking import LineRange
from server.comments.schemas import WHOLE_WORK, ThreadTarget
from server.course import Course, Exercise, Module
from server.demo.people import GROUPS
from server.demo.story import LESSON_DURATION, PlannedAttempt, divide_exercises_evenly, lesson_start_times
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.lesson import service as lessons
from server.lesson.models import Afterwards
from server.lesson.service import LessonPlan
from server.marks import columns
from server.marks import service as marks
from server.marks.columns import MarkEntry
from server.marks.schemas import TypedMark
from server.marks.states import TypedState
from server.marks.typed import ColumnInput

WEEK = timedelta(days=7)
DAY = timedelta(days=1)
TEST_LESSON = 1  # the lesson at the end of which there was a test
TEST_LENGTH = 2  # its last exercises
PHRASE = "Le calcul est juste, mais relisez l’unité : un angle s’écrit ici en radians."
LINE = "Cette ligne mérite un nom plus parlant : on doit comprendre sans lire la suite."
ANSWERED = "Je ne comprends pas cette remarque, pouvez-vous m’expliquer ?"
ORAL_SCALE = 10.0
ANSWER = "Faites le calcul à la main sur le premier exemple, et comparez avec ce que rend votre fonction."
OPEN = "Mon programme marche chez moi, mais pas ici : où est la différence ?"
WORD = "Beaucoup d’entre vous ont la même difficulté : relisez la définition, puis l’exemple du cours."


@dataclass(frozen=True)
class DemoClassroom:
    """The class, who teaches it and who learns there."""

    course: Course
    module: Module
    school_class: SchoolClass
    teacher: Account
    students: Sequence[UUID]


def create_assignments(db: Session, room: DemoClassroom, now: datetime) -> Assignment:
    """One for each lesson, due a week after, and a test in one of them; a test to come. The test that is past."""
    starts, by_lesson = lesson_start_times(now), divide_exercises_evenly(room.module)
    for number, (start, exercises) in enumerate(zip(starts, by_lesson, strict=True)):
        late, per_day = (LatePolicy.accept, None) if number % 2 else (LatePolicy.penalty, 2.0)
        given = exercises[:-TEST_LENGTH] if number == TEST_LESSON and len(exercises) > TEST_LENGTH else exercises
        due = start + WEEK
        last = _create_assignment(
            db,
            room,
            AssignmentInput(f"Semaine {number + 1}", _with_weights(given), start, due, due + WEEK, late, per_day),
        )
    grant = ExemptionInput(due_at=starts[-1] + WEEK + 2 * DAY, reason="sortie de classe")
    _grant_exemption(db, room, last, ExemptionTarget(label=GROUPS[-1]), grant)
    opens = (now + WEEK).replace(minute=0, second=0, microsecond=0)
    asked = (by_lesson[0][-1], by_lesson[-1][-1])
    end = _create_assignment(
        db,
        room,
        _build_test_assignment_input("Contrôle de fin de module", asked, opens, opens + timedelta(hours=2), 55),
    )
    _grant_exemption(db, room, end, ExemptionTarget((room.students[-1],)), ExemptionInput(time_factor=4 / 3))
    start = starts[TEST_LESSON]
    test = _build_test_assignment_input(
        "Contrôle de mi-parcours", by_lesson[TEST_LESSON][-TEST_LENGTH:], start, start + LESSON_DURATION, None
    )
    return _create_assignment(db, room, test)


def record_lessons_with_presence(db: Session, room: DemoClassroom, now: datetime) -> None:
    """Hold each lesson with its first exercises; the last one goes on, and who has finished helps somebody."""
    starts, by_lesson = lesson_start_times(now), divide_exercises_evenly(room.module)
    for start, exercises in zip(starts, by_lesson, strict=True):
        names = tuple(exercise.id for exercise in exercises[: lessons.MAX_EXERCISES])
        plan = LessonPlan(names, Afterwards.help if start == starts[-1] else Afterwards.none)
        lessons.start_lesson(db, room.course, room.school_class, room.teacher.id, plan, start)
        if start != starts[-1]:
            lessons.end_lesson(db, room.school_class, room.teacher.id, start + LESSON_DURATION)


def _with_weights(exercises: Sequence[Exercise]) -> tuple[WeightedExercise, ...]:
    return tuple(WeightedExercise(exercise.id) for exercise in exercises)


def _build_test_assignment_input(
    title: str, exercises: Sequence[Exercise], opens: datetime, closes: datetime, minutes: int | None
) -> AssignmentInput:
    return AssignmentInput(
        *(title, _with_weights(exercises), opens, None, closes),
        late=LatePolicy.refuse,
        weight=2.0,
        mode=Mode.test,
        duration_minutes=minutes,
    )


def _create_assignment(db: Session, room: DemoClassroom, fields: AssignmentInput) -> Assignment:
    return editing.create_assignment(db, room.course, room.school_class, room.teacher.id, fields)


def _grant_exemption(
    db: Session, room: DemoClassroom, assignment: Assignment, target: ExemptionTarget, fields: ExemptionInput
) -> None:
    exemption_service.grant_exemptions(
        db, room.school_class, room.teacher.id, assignment, _load_members(db, room), target, fields
    )


def _load_members(db: Session, room: DemoClassroom) -> Sequence[Member]:
    return classes.load_members(db, room.school_class.id)


def record_test_sittings(db: Session, room: DemoClassroom, test: Assignment, steps: Sequence[PlannedAttempt]) -> None:
    """Those who came to that lesson sat the test, which is released since."""
    end = test.opens_at + LESSON_DURATION
    came = sorted({step.pupil for step in steps if test.opens_at <= step.sent_at <= end})
    for pupil in came:
        sitting_repository.insert_sitting_once(db, test.id, room.students[pupil], test.opens_at)
        sitting = sitting_repository.load_sitting(db, test.id, room.students[pupil])
        assert sitting is not None
        sitting_repository.end_sitting(db, sitting, end, EndedBy.time)
    releases.release_feedback(db, test, room.teacher.id, test.opens_at + 2 * DAY)


def create_oral_marks_column(db: Session, room: DemoClassroom, now: datetime) -> None:
    """Have the teacher type the marks of an oral, published: a few students are not called yet, one was absent."""
    oral = columns.create_column(
        db, room.school_class, room.teacher, ColumnInput("Oral", ORAL_SCALE, (now - WEEK).date(), 0.5)
    )
    called = room.students[: len(room.students) * 2 // 3]
    entries = [MarkEntry(student, TypedMark(float(5 + number % 6))) for number, student in enumerate(called)]
    entries[-1:] = [MarkEntry(called[-1], TypedMark(state=TypedState.absent))]
    columns.store_column_marks(db, room.school_class, room.teacher, oral.id, entries)
    columns.set_column_published(db, room.school_class, room.teacher, oral.id, published=True)


def write_example_comments(
    db: Session, room: DemoClassroom, steps: Sequence[PlannedAttempt], settings: Settings
) -> None:
    """A mark that is set, a comment on a line, a kept phrase, questions answered and open, a word to several.

    About what the first students have sent last to code exercises.
    """
    code = [step for step in steps if room.course.exercises[step.exercise].kind == "code"]
    latest = list({step.pupil: step for step in code}.values())[:3]
    for place, step in enumerate(latest):
        author = db.get_one(Account, room.students[step.pupil])
        attempt = gradebook.find_latest_attempt(db, author, step.exercise)
        assert attempt is not None
        if place == 0:
            marks.set_override(
                *(db, room.course, room.school_class, room.teacher, author.id, step.exercise),
                points=15.0,
                excused=False,
                reason="Le raisonnement a été expliqué à l’oral.",
            )
            comments.begin_thread(db, room.teacher, attempt, ThreadTarget(LineRange(1, 1)), LINE, settings)
            notes.save_phrase(db, room.teacher, PHRASE, step.exercise, None)
        thread = comments.begin_thread(db, author, attempt, WHOLE_WORK, OPEN if place == 1 else ANSWERED, settings)
        if place != 1:
            comments.reply_to_thread(db, room.teacher, thread, ANSWER, settings)
    if latest:
        exercise = latest[-1].exercise
        known = notes_repository.load_current_misconceptions(db, room.school_class.id, exercise)
        misconception = known[0][0] if known else None
        notes.send_note_to_students(db, room.teacher, room.school_class, exercise, misconception, WORD, "", settings)
