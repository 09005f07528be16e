"""What an assignment comes to for a student: against fractions, state by state."""

from __future__ import annotations

from datetime import UTC, datetime
from fractions import Fraction
from typing import Any
from uuid import uuid4

import pytest

from server.assignments.models import Mode
from server.base.errors import Conflict, Invalid, NotFound
from server.classes.models import ClassRole, Status
from server.course import Course
from server.database import Database
from server.identity.models import Account
from server.marks import service
from server.marks.files import MoodleIdentifier, build_moodle_table, marks_as_lines
from server.marks.loading import load_gradebook
from server.marks.models import Override
from server.marks.schemas import AssignmentMark, Gradebook
from server.marks.states import MarkState
from tests.support.caches import clear_caches
from tests.support.classes import seat
from tests.support.counting import Counted
from tests.support.marks import AFTER, CLOSES, DAY, DUE, ODOMETRY, OPENS, POSES, Term
from tests.support.service import new_account


@pytest.fixture
def term(sqlite: Database) -> Term:
    return Term.begin(sqlite)


def made(term: Term, course: Course, now: datetime = AFTER) -> Gradebook:
    with term.database.read() as db:
        return load_gradebook(db, course, term.made, now)


def only(term: Term, course: Course, now: datetime = AFTER) -> AssignmentMark:
    (row,) = made(term, course, now).rows
    (mark,) = row.marks
    return mark


def change(term: Term, course: Course, student: Account, exercise: str = POSES, **values: Any) -> None:
    row = {"points": None, "excused": False, "reason": "à l’oral", **values}
    with term.database.write() as db:
        service.set_override(db, course, term.made, term.teacher, student.id, exercise, **row)


def test_missing_exercises_count_zero_once_the_assignment_is_over(term: Term, course: Course) -> None:
    term.assignment(exercises={POSES: 1.0, ODOMETRY: 3.0})
    ada = term.student("Ada", "Lovelace")
    assert (only(term, course).state, only(term, course).points) == (MarkState.not_handed_in, None)
    assert only(term, course, OPENS - DAY).state is MarkState.upcoming
    assert (only(term, course, OPENS).state, only(term, course, OPENS).points) == (MarkState.open, None)
    term.send(ada, POSES, 13)
    assert (only(term, course, DUE).points, only(term, course, DUE).points_in_average) == (13, None)
    assert only(term, course).points == float(Fraction(13, 4))
    assert made(term, course).rows[0].average == 3.25
    term.send(ada, ODOMETRY, 20, CLOSES + DAY)
    assert only(term, course).points == 3.25, "too late to count"


def test_a_test_is_over_once_handed_in_whatever_its_dates(term: Term, course: Course) -> None:
    test = term.assignment(mode=Mode.test, due_at=None, closes_at=None)
    ada, zola, _ = [term.student(*name) for name in (("Ada", "Abel"), ("Émile", "Zola"), ("Blaise", "Pascal"))]
    term.sit(test, ada, OPENS + 2 * DAY)
    term.sit(test, zola)
    for student in (ada, zola):
        term.send(student, POSES, 20)

    def told() -> dict[str, tuple[MarkState, float | None, float | None]]:
        rows = made(term, course).rows
        return {row.member.name: (row.marks[0].state, row.marks[0].points, row.average) for row in rows}

    before = told()
    assert before["Ada Abel"] == (MarkState.done, 10.0, 10.0), "what was not sent counts 0"
    assert before["Blaise Pascal"] == (MarkState.open, None, None)
    with term.database.write() as db:
        db.merge(test).released_at = AFTER - DAY
    assert told() == {**before, "Blaise Pascal": (MarkState.not_handed_in, None, None)}


def test_exemptions_of_a_student_change_their_marks(term: Term, course: Course) -> None:
    given = term.assignment(exercises={POSES: 1.0}, late="penalty", late_per_day=2.0)
    ada = term.student("Ada", "Lovelace")
    term.send(ada, POSES, 15, DUE + 1.5 * DAY)
    assert (only(term, course).points, only(term, course).days_late) == (11, 2)
    term.exempt(given, ada, due_at=DUE + DAY)
    assert (only(term, course).points, only(term, course).days_late) == (13, 1)
    term.exempt(given, ada, excused=True)
    assert (only(term, course).state, only(term, course).points) == (MarkState.excused, None)
    assert made(term, course).rows[0].average is None


def test_override_stands_beside_the_automatic_mark_and_becomes_stale(term: Term, course: Course) -> None:
    term.assignment()
    ada = term.student("Ada", "Lovelace")
    sent = term.send(ada, POSES, 4)
    change(term, course, ada, points=12.0)
    mark = only(term, course)
    assert (mark.points, mark.has_override_or_decision, mark.stale) == (6, True, False)
    assert (mark.exercises[0].points, mark.exercises[0].effective.automatic) == (12, 4)
    assert mark.exercises[0].override is not None
    assert (mark.exercises[0].override.by, mark.exercises[0].override.reason) == ("Mme Martin", "à l’oral")
    term.grade(sent, 8)
    assert only(term, course).stale, "graded anew"
    change(term, course, ada, points=14.0)
    assert not only(term, course).stale, "looked at again"
    term.send(ada, POSES, 5)
    assert not only(term, course).stale, "an attempt that would not count"
    term.send(ada, POSES, 16)
    assert (only(term, course).stale, only(term, course).points) == (True, 7)
    change(term, course, ada, ODOMETRY, excused=True)
    assert only(term, course).points == 14
    with term.database.write() as db:
        service.withdraw_override(db, course, term.made, term.teacher, ada.id, POSES)
    assert only(term, course).points == 16
    with term.database.read() as db:
        assert len(db.query(Override).all()) == 3, "nothing is lost"


def test_excused_from_all_exercises_is_excused_from_the_assignment(term: Term, course: Course) -> None:
    term.assignment(exercises={POSES: 1.0})
    ada = term.student("Ada", "Lovelace")
    change(term, course, ada, excused=True)
    assert (only(term, course).state, only(term, course).points) == (MarkState.excused, None)


def test_override_without_any_attempt(term: Term, course: Course) -> None:
    term.assignment(exercises={POSES: 1.0})
    ada = term.student("Ada", "Lovelace")
    change(term, course, ada, points=9.0)
    assert (only(term, course).state, only(term, course).points, only(term, course).stale) == (MarkState.done, 9, False)
    term.send(ada, POSES, 3)
    assert only(term, course).stale


REFUSED: tuple[tuple[dict[str, Any], type[Exception]], ...] = (
    ({"points": 20.5}, Invalid),
    ({"points": float("nan")}, Invalid),
    ({"points": -0.1}, Invalid),
    ({}, Invalid),
    ({"points": 3.0, "excused": True}, Invalid),
    ({"points": 3.0, "reason": " \n"}, Invalid),
    ({"points": 3.0, "reason": "x" * 1001}, Invalid),
    ({"points": 3.0, "reason": "a\x00"}, Invalid),
    ({"points": 3.0, "exercise": "l20/rien"}, NotFound),
)


def test_refused_overrides_change_nothing(term: Term, course: Course) -> None:
    ada = term.student("Ada", "Lovelace")
    for values, refused in REFUSED:
        with pytest.raises(refused):
            change(term, course, ada, **values)
    with term.database.read() as db:
        assert db.query(Override).all() == []


def test_only_active_students_have_marks(term: Term, course: Course) -> None:
    gone = term.student("Alan", "Turing", status=Status.left, left_at=OPENS)
    helper = seat(term.database, term.made, new_account(term.database), ClassRole.assistant)
    for one in (gone, helper, term.teacher, new_account(term.database)):
        with pytest.raises(NotFound):
            change(term, course, one, points=1.0)
    assert made(term, course).rows == ()
    term.student("Ada", "Lovelace")
    with term.database.write() as db:
        db.merge(term.made).archived_at = AFTER
    term.made.archived_at = AFTER
    with pytest.raises(Conflict):
        change(term, course, term.student("Grace", "Hopper"), points=1.0)


def test_a_class_without_assignments_has_its_module_s_exercises(term: Term, course: Course) -> None:
    ada = term.student("Ada", "Lovelace")
    assert only(term, course).state is MarkState.open
    term.send(ada, POSES, 12, datetime(2020, 1, 1, tzinfo=UTC))
    assert (only(term, course).state, only(term, course).points) == (MarkState.done, 12)
    change(term, course, ada, points=15.0)
    assert only(term, course).points == 15


def test_own_marks_leave_out_withheld_tests(term: Term, course: Course) -> None:
    term.assignment("DM", {POSES: 1.0})
    test = term.assignment("DS", {ODOMETRY: 1.0}, mode=Mode.test, weight=3.0)
    term.assignment("Les deux", {POSES: 1.0, ODOMETRY: 1.0}, weight=0.0)
    ada = term.student("Ada", "Lovelace")
    term.sit(test, ada, OPENS + 2 * DAY)
    term.send(ada, ODOMETRY, 20, OPENS + 3 * DAY)  # as a guest, say: not while they sat it
    term.send(ada, POSES, 10)
    term.send(ada, ODOMETRY, 2)
    with term.database.read() as db:
        told = service.load_visible_marks(db, course, term.made, ada.id, AFTER)
        nobody = service.load_visible_marks(db, course, term.made, uuid4(), AFTER)
    assert {one.assignment.title: one.mark.points if one.mark else None for one in told.marks} == {
        "DM": 10,
        "DS": None,
        "Les deux": None,  # what a test holds is held in every mark
    }
    assert told.average == 10
    assert made(term, course).rows[0].average == 4
    assert nobody.marks == ()


def test_column_text_and_moodle_file(term: Term, course: Course) -> None:
    term.assignment("DM", {POSES: 1.0})
    test = term.assignment("DS", {POSES: 1.0}, mode=Mode.test)
    zola = term.student("Émile", "Zola", email="zola@example.org")
    term.sit(test, zola)
    term.student("Paul", "Éluard", email="eluard@example.org")
    term.student("Ada", "Lovelace")
    for family in ("Un", "Deux"):
        term.student("Bob", family, email="bob@example.org")
    hopper = term.student("Grace", "Hopper", email="hopper@example.org")
    term.send(zola, POSES, 12.5)
    change(term, course, hopper, excused=True)
    found = made(term, course)
    assert (
        marks_as_lines(found, str(found.assignments[0].id))
        == "non rendu\nnon rendu\ndispensé\nnon rendu\nnon rendu\n12,5"
    )
    assert [row.member.family_name for row in found.rows] == [
        "Deux",
        "Éluard",
        "Hopper",
        "Lovelace",
        "Un",
        "Zola",
    ]
    moodle = build_moodle_table(found, MoodleIdentifier.email)
    assert b"".join(moodle.iter_csv_lines()).decode() == (
        '"Email address","DM","Remarques"\r\n"eluard@example.org","","DM : non rendu"\r\n'
        '"hopper@example.org","","DM : dispensé"\r\n"zola@example.org","12.5",""\r\n'
    )
    assert set(moodle.left_out) == {"Ada Lovelace", "Bob Un", "Bob Deux"}


def test_a_gradebook_takes_as_many_queries_for_a_bigger_class(term: Term, course: Course) -> None:
    def statements() -> int:
        clear_caches()
        with Counted(term.database) as counted:
            made(term, course)
        return len(counted.statements)

    term.assignment()
    term.send(term.student("Ada", "Lovelace"), POSES, 3)
    few = statements()
    for number in range(3):
        term.assignment(f"DM {number}")
        student = term.student("Ada", f"n° {number}")
        term.send(student, POSES, 4)
        change(term, course, student, points=4.0)
    assert statements() == few <= 9
