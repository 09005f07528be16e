"""« Après la séance »: an exercise is at fault by those who fail it, not by those who have solved it already."""

from __future__ import annotations

from datetime import timedelta

from sqlalchemy import update

from server.board.lesson_review import (
    MAX_TO_SEE,
    MIN_FAILURES,
    MIN_FAILURES_OF_WEEK,
    MIN_TRIED,
    SuspectExercise,
    build_lesson_review,
    list_student_ids_to_see,
)
from server.board.service import load_class_progress
from server.board.stuck import StuckSign
from server.classes.models import Membership
from server.course import Course
from server.database import Database
from tests.support.marks import AFTER, DAY, ODOMETRY, OPENS, POSES, Term


def test_who_has_solved_an_exercise_does_not_fail_it(database: Database, course: Course) -> None:
    term = Term.begin(database)
    students = [term.student(f"Élève{number}", "Petit") for number in range(MIN_TRIED)]
    for number, student in enumerate(students):
        if number:
            term.send(student, POSES, 20, OPENS)
        term.send(student, POSES, 5, OPENS + timedelta(minutes=5))
    with database.read() as db:
        progress = load_class_progress(db, course, term.made, AFTER)
    assert build_lesson_review(progress, [POSES], OPENS, AFTER).at_fault == ()
    for student in students[1:]:
        term.send(student, POSES, 5, AFTER + timedelta(minutes=1))
    later = AFTER + timedelta(hours=1)
    fresh = [term.student(f"Autre{number}", "Petit") for number in range(MIN_TRIED)]
    for student in fresh:
        term.send(student, POSES, 5, later)
    with database.read() as db:
        progress = load_class_progress(db, course, term.made, later)
    fault = build_lesson_review(progress, [POSES], OPENS, later).at_fault
    assert fault == (SuspectExercise(POSES, 2 * MIN_TRIED, MIN_TRIED - 1, MIN_TRIED + 1),)


def test_students_without_an_attempt_are_told_apart_by_what_is_known_of_them(sqlite: Database, course: Course) -> None:
    term, during, after = Term.begin(sqlite), OPENS + timedelta(minutes=20), AFTER + timedelta(hours=9)
    present, absent, later, busy = (term.student(name, "Petit") for name in ("Ada", "Alan", "Grace", "Kurt"))
    term.send(busy, ODOMETRY, 20, during)
    with sqlite.write() as db:
        for student, seen_at in ((present, during), (absent, OPENS - timedelta(days=1)), (later, after)):
            own = Membership.class_id == term.made.id, Membership.account_id == student.id
            db.execute(update(Membership).where(*own).values(last_seen_at=seen_at))
    with sqlite.read() as db:
        review = build_lesson_review(load_class_progress(db, course, term.made, after), [POSES], OPENS, AFTER)
    assert (review.idle, review.absent) == ((present.id,), (absent.id,))
    assert review.unknown == (later.id,), "seen after the lesson: nobody knows whether they were there"
    assert review.elsewhere == (busy.id,)


def test_those_for_whom_there_is_no_room_are_named_too(sqlite: Database, course: Course) -> None:
    term = Term.begin(sqlite)
    for number in range(MAX_TO_SEE + 2):
        student = term.student(f"Élève{number}", "Petit")
        for points in (5, 4, 3):
            term.send(student, POSES, points, OPENS + timedelta(minutes=10 - points))
    with sqlite.read() as db:
        review = build_lesson_review(load_class_progress(db, course, term.made, AFTER), [POSES], OPENS, AFTER)
    assert (len(review.to_see), len(review.more_to_see)) == (MAX_TO_SEE, 2)


def test_a_week_says_to_see_fewer_students_than_its_lessons(sqlite: Database, course: Course) -> None:
    term, end = Term.begin(sqlite), OPENS + 6 * DAY
    names = ("Ada", "Kurt", "Emmy", "Grace", "Alan", "Sophie")
    repeating, many, few, moved_on, overcame, solved = (term.student(name, "Petit") for name in names)
    for student in (repeating, solved):
        for day in (1, 3):
            term.send(student, POSES, 4 - day, OPENS + day * DAY, diagnosis="degres")
    for student, failures in ((many, MIN_FAILURES_OF_WEEK), (few, MIN_FAILURES), (moved_on, MIN_FAILURES_OF_WEEK)):
        for number in range(failures):
            term.send(student, POSES, (failures - number) / 2, OPENS + 2 * DAY + timedelta(minutes=20 * number))
    term.send(moved_on, ODOMETRY, 20, end)
    for day, mistake in ((1, "degres"), (2, "degres"), (3, None)):
        term.send(overcame, POSES, 4 - day, OPENS + day * DAY, diagnosis=mistake)
    term.send(solved, POSES, 20, end)
    with sqlite.read() as db:
        progress = load_class_progress(db, course, term.made, end)
    review = build_lesson_review(progress, [POSES, ODOMETRY], OPENS, end, is_week=True)
    assert [(row.account, row.failures) for row in review.to_see] == [
        (repeating.id, 2),
        (many.id, MIN_FAILURES_OF_WEEK),
    ]
    assert [[day.isoformat() for day in row.days] for row in review.to_see] == [["2026-03-03", "2026-03-05"], []]
    lesson = [POSES], OPENS + 2 * DAY, OPENS + 2 * DAY + timedelta(hours=1)
    assert list_student_ids_to_see(progress, *lesson) == {many.id, few.id, moved_on.id}, (
        "the rule of a lesson is not as strict"
    )


def test_who_was_stuck_until_the_end_of_a_lesson_is_to_be_seen(sqlite: Database, course: Course) -> None:
    term, end = Term.begin(sqlite), OPENS + timedelta(hours=1)
    names = ("Ada", "Alan", "Grace", "Kurt", "Emmy", "Hugo")
    stuck, quick, elsewhere, gone, silent, left = (term.student(name, "Petit") for name in names)
    all_minutes = ((16, 13), (5, 3), (16, 13), (59, 50), (25,), (25,))
    for student, minutes in zip((stuck, quick, elsewhere, gone, silent, left), all_minutes, strict=True):
        for number, before in enumerate(minutes):
            term.send(student, POSES, 3 - number, end - timedelta(minutes=before))
    term.send(elsewhere, ODOMETRY, 5, end - timedelta(minutes=2))
    with sqlite.write() as db:
        for student, seen_at in ((silent, end + timedelta(hours=9)), (left, end - timedelta(minutes=24))):
            own = Membership.class_id == term.made.id, Membership.account_id == student.id
            db.execute(update(Membership).where(*own).values(last_seen_at=seen_at))
    with sqlite.read() as db:
        progress = load_class_progress(db, course, term.made, end)
    review = build_lesson_review(progress, [POSES, ODOMETRY], OPENS, end)
    assert [(row.account, row.failures) for row in review.to_see] == [(stuck.id, 2), (silent.id, 1)]
    shown = review.to_see[1].stuck
    assert shown is not None
    assert (shown.sign, shown.since) == (StuckSign.silence, end - timedelta(minutes=25)), "as the lesson's page said"
    assert list_student_ids_to_see(progress, [POSES, ODOMETRY], OPENS, end) == {stuck.id, silent.id}
