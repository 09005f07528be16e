"""« Demain matin »: an exercise is at fault by those who fail it, not by those who have solved it already."""

from __future__ import annotations

from datetime import timedelta

from server.board.lesson_review import MIN_TRIED, ExerciseAtFault, build_review
from server.board.service import load_progress
from server.course import Course
from server.database import Database
from tests.support.marks import AFTER, OPENS, POSES, Term


def test_who_has_solved_an_exercise_does_not_fail_it(database: Database, course: Course) -> None:
    term = Term.begin(database)
    students = [term.student(f"Élève{number}", "Petit") for number in range(MIN_TRIED)]
    for number, student in enumerate(students):
        if number:
            term.send(student, POSES, 20, OPENS)
        term.send(student, POSES, 5, OPENS + timedelta(minutes=5))
    with database.read() as db:
        progress = load_progress(db, course, term.made, AFTER)
    assert build_review(progress, [POSES], OPENS, AFTER).at_fault == ()
    for student in students[1:]:
        term.send(student, POSES, 5, AFTER + timedelta(minutes=1))
    later = AFTER + timedelta(hours=1)
    fresh = [term.student(f"Autre{number}", "Petit") for number in range(MIN_TRIED)]
    for student in fresh:
        term.send(student, POSES, 5, later)
    with database.read() as db:
        progress = load_progress(db, course, term.made, later)
    fault = build_review(progress, [POSES], OPENS, later).at_fault
    assert fault == (ExerciseAtFault(POSES, 2 * MIN_TRIED, MIN_TRIED - 1, MIN_TRIED + 1),)
