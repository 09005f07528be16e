"""The class of nobody: the same from the same seed, graded as any other, and a lesson that goes on."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from random import Random

from graders.core.contract.findings import Judgement
from server.assignments import service as assignments
from server.assignments.models import Exemption
from server.audit.models import AuditAction, AuditEvent
from server.base.settings import Settings
from server.classes import repository as classes
from server.classes.models import ClassRole
from server.comments import service as comments
from server.comments.models import Note, Phrase, ThreadState
from server.course import Course
from server.database import Database, utc_now
from server.demo.living import SimulatedLessonThread
from server.demo.loading import choose_demo_module, create_demo_class
from server.demo.people import FAMILY, GIVEN, draw_simulated_students
from server.demo.story import LESSON_DURATION, divide_exercises_evenly, lesson_start_times, plan_attempts
from server.gradebook import standings
from server.marks.loading import load_gradebook
from server.submissions.models import Submission
from server.submissions.service import SubmissionService
from tests.support.quick import the_course
from tests.support.service import fake_verdict


def test_nobody_has_the_login_of_another() -> None:
    assert len(set(GIVEN)) == len(GIVEN)
    assert len(set(FAMILY)) == len(FAMILY)
    everyone = draw_simulated_students(Random(1), 800)
    assert len({one.login for one in everyone}) == 800
    assert all(one.login.replace(".", "").isalpha() and one.login.isascii() for one in everyone)
    assert Counter(one.group for one in everyone) == {"TP1": 400, "TP2": 400}


def test_a_demonstration_is_of_the_module_with_the_most_exercises() -> None:
    course = the_course()
    assert choose_demo_module(course).slug == "l20"
    turned = {slug: course.modules[slug] for slug in reversed(list(course.modules))}
    assert choose_demo_module(replace(course, modules=turned)).slug == "l20"


def test_the_same_seed_tells_the_same_story(course: Course) -> None:
    module, now = course.modules["l20"], utc_now()

    def told(seed: int) -> list[tuple[int, str, str, object, int]]:
        random = Random(seed)
        steps = plan_attempts(module, draw_simulated_students(random, 35), random, now)
        return [(step.pupil, step.exercise, step.submission.subject, step.sent_at, step.repeats) for step in steps]

    first = told(20)
    assert first == told(20)
    assert first != told(21)
    starts = lesson_start_times(now)
    at_home = [step for step in first if not any(start <= step[3] <= start + LESSON_DURATION for start in starts)]
    assert 0 < len(at_home) < len(first) / 10, "few go on between two lessons"
    assert all(starts[0] < step[3] < starts[-1] for step in at_home)
    assert [step[3] for step in first] == sorted(step[3] for step in first)
    assert {step[1] for step in first} == {exercise.id for exercise in module.exercises}
    assert any(step[3] > now for step in first), "the lesson goes on"
    diagnoses = Counter(subject for _, name, subject, *_ in first if subject.startswith("erreur") and "predire" in name)
    assert max(diagnoses.values()) >= 3, "a mistake that several share"


def test_each_exercise_is_in_one_lesson(course: Course) -> None:
    module = course.modules["l20"]
    given = [one for lesson in divide_exercises_evenly(module) for one in lesson]
    assert len(given) == len(module.exercises)
    assert set(given) == set(module.exercises)


def test_what_is_written_is_a_class_whose_standings_are_right(
    database: Database, course: Course, store: SubmissionService
) -> None:
    graded: list[tuple[str, bytes, int]] = []

    def grade(exercise: str, source: bytes, seed: int) -> Judgement:
        graded.append((exercise, source, seed))
        return Judgement(fake_verdict("# outcome: wrong_answer" if b'print("ici' in source else "", seed))

    module = course.modules["l20"]
    loaded = create_demo_class(
        database, course, module, grade, Settings(), seed=3, students=4, report_progress=lambda _done, _all: None
    )
    with database.read() as db:
        made = classes.find_class(db, loaded.class_id)
        assert made is not None
        seats = Counter(member.role for member in classes.load_members(db, made.id))
        assert seats == {ClassRole.teacher: 1, ClassRole.assistant: 1, ClassRole.student: 4}
        opened = assignments.list_counting_exercises(db, course, made, utc_now())
        assert list(opened) == [exercise.id for exercise in module.exercises]
        sent = db.query(Submission).count()
        book = load_gradebook(db, course, made, utc_now())
        (tested,) = [place for place, one in enumerate(book.assignments) if one.released_at is not None]
        assert [row.marks[tested].state for row in book.rows if row.marks[tested].points], "a test with its marks"
        assert sum(mark.has_override_or_decision for row in book.rows for mark in row.marks) >= 1
        assert {one.label is None for one in db.query(Exemption)} == {True, False}
        asked = comments.load_thread_page(db, made, None, 1)
        assert asked.counts[ThreadState.open] >= 1
        assert asked.counts[ThreadState.answered] >= 1
        assert db.query(Phrase).count() == db.query(Note).count() == 1
        assert {
            AuditAction.assignment_made,
            AuditAction.exemption_made,
            AuditAction.feedback_released,
            AuditAction.lesson_started,
            AuditAction.lesson_ended,
            AuditAction.mark_overridden,
            AuditAction.column_made,
            AuditAction.column_changed,
            AuditAction.column_mark_changed,
        } == {one.what for one in db.query(AuditEvent)}
        latest = max(one.created_at for one in db.query(Submission))
        assert latest <= utc_now()
    codes = [one for one in graded if course.exercises[one[0]].kind == "code"]
    assert len(codes) == len(set(codes)), "the same file is graded once"
    with database.write() as db:
        assert not any(standings.rebuild_account(db, account) for account in loaded.accounts)
    soon = [replace(step, sent_at=utc_now()) for step in loaded.upcoming[:2]]
    lesson = SimulatedLessonThread(database, course, store, replace(loaded, upcoming=soon))
    lesson.start()
    lesson.join()
    with database.read() as db:
        assert db.query(Submission).count() == sent + len(soon)
