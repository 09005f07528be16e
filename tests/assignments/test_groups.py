"""Assignments for a part of the class: every room agrees on whom they concern; groups are made, dealt and renamed."""

from __future__ import annotations

from datetime import timedelta
from random import Random
from typing import Any
from uuid import UUID

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.assignments import editing, feedback, groups, repository, sittings
from server.assignments.models import Assignment, Mode
from server.assignments.rules import OUTSIDE, SendingWindow, rules_in_force
from server.assignments.schemas import AssignmentInput
from server.assignments.service import load_counting_exercises
from server.assignments.student_assignments import load_assignments_for_student, load_open_assignments
from server.audit.models import AuditAction
from server.audit.repository import load_entries
from server.audit.schemas import AuditFilter
from server.base.errors import InvalidFields, NotFound
from server.board.service import load_board
from server.classes import repository as classes
from server.course import Course
from server.database import Database, utc_now
from server.identity.models import Account
from server.marks.loading import load_gradebook
from server.marks.service import load_visible_marks
from server.marks.states import MarkState
from tests.support.marks import AFTER, DAY, DUE, ODOMETRY, OPENS, POSES, Term

LABELS = ("TP1", "TP2", "Reprise")


@given(st.sets(st.sampled_from(LABELS)), st.sets(st.sampled_from(LABELS)), st.booleans())
def test_an_assignment_concerns_its_groups_and_who_has_sat_it(given_to: set[str], own: set[str], sat: bool) -> None:
    test = Assignment(
        id=UUID(int=1), class_id=UUID(int=1), title="DM", mode=Mode.test, opens_at=OPENS, late="accept",
        duration_minutes=60, groups=tuple(given_to),
    )  # fmt: skip

    class Sat:
        began_at, handed_in_at, ended_by = OPENS, None, None

    rules = rules_in_force(test, (), UUID(int=2), own)
    windows = SendingWindow(rules, Sat() if sat else None)
    assert rules.is_concerned == (not given_to or bool(given_to & own))
    assert windows.concerns_student == (rules.is_concerned or sat)
    assert (windows.judge_timing(OPENS) is not OUTSIDE) == sat


def people(database: Database) -> tuple[Term, Account, Account, Account]:
    term = Term.begin(database)
    ada = term.student("Ada", "Lovelace", groups=["TP1"])
    alan = term.student("Alan", "Turing", groups=["TP2"])
    return term, ada, alan, term.student("Inès", "Roy")


def test_the_mark_of_others_is_not_concerned_and_counts_nowhere(database: Database, course: Course) -> None:
    term, ada, alan, _ = people(database)
    whole, part = term.assignment("Tous", {ODOMETRY: 1.0}), term.assignment("TP1", {POSES: 1.0}, groups=("TP1",))
    for student in (ada, alan):
        term.send(student, ODOMETRY, 10)
        term.send(student, POSES, 20)
    with database.read() as db:
        book = load_gradebook(db, course, term.made, AFTER)
        marks = {row.member.name: {one.title: mark for one, mark in zip(book.assignments, row.marks, strict=True)}
                 for row in book.rows}  # fmt: skip
        states = {name: own[part.title].state for name, own in marks.items()}
        assert states == {
            "Ada Lovelace": MarkState.done, "Alan Turing": MarkState.not_concerned, "Inès Roy": MarkState.not_concerned
        }  # fmt: skip
        averages = {row.member.name: row.average for row in book.rows}
        assert averages == {"Ada Lovelace": 15.0, "Alan Turing": 10.0, "Inès Roy": None}, "never a 0"
        assert book.assignment_statistics([one.title for one in book.assignments].index(part.title)).count == 1
        own = load_visible_marks(db, course, term.made, alan.id, AFTER)
        assert [mark.assignment.title for mark in own.marks] == [whole.title], "and alan is not told of it"
        assert [line.title for line in own.terms] == [whole.title]
        assert own.average == 10.0


def test_what_a_student_is_given_is_what_counts_for_them(database: Database, course: Course) -> None:
    term, ada, alan, ines = people(database)
    now = utc_now()
    term.assignment("TP1", {POSES: 1.0}, groups=("TP1",), opens_at=now - DAY, due_at=now + DAY, closes_at=None)
    term.assignment("Tous", {ODOMETRY: 1.0}, opens_at=now - DAY, due_at=now + DAY, closes_at=None)
    with database.read() as db:
        for student, titles in ((ada, ["TP1", "Tous"]), (alan, ["Tous"]), (ines, ["Tous"])):
            member = classes.find_membership(db, term.made.id, student.id)
            assert member is not None
            shown = load_assignments_for_student(db, term.made.id, student.id, member.groups, now)
            assert sorted(own.assignment.title for own in shown) == titles
            assert sorted(own.assignment.title for own in load_open_assignments(db, student.id, now)) == titles
        counting = load_counting_exercises(db, course, term.made, now)
        assert set(counting.names) == {POSES, ODOMETRY}
        assert set(counting.counting_for_student(("TP1",))) == {POSES, ODOMETRY}
        assert counting.counting_for_student(()) == (ODOMETRY,)
    term.send(alan, ODOMETRY, 20, now)
    with database.read() as db:
        board = load_board(db, course, term.made, now)
        assert board.counts.finished == 1, "alan needs nothing that is given to others"
        assert not board.cells_by_pair[alan.id, POSES].is_concerned


def test_a_test_of_others_holds_nothing_and_cannot_be_begun(database: Database) -> None:
    term, ada, alan, _ = people(database)
    now = utc_now()
    test = term.assignment(
        "Contrôle", {POSES: 1.0}, mode=Mode.test, groups=("TP1",), opens_at=now - DAY, due_at=None,
        closes_at=now + DAY, duration_minutes=60,
    )  # fmt: skip
    with database.read() as db:
        assert feedback.load_holds(db, ada.id, POSES).submission_refusal
        assert not feedback.load_holds(db, alan.id, POSES).submission_refusal
        with pytest.raises(NotFound):
            sittings.begin_sitting(db, test, alan.id, ["TP2"], now)
    with database.write() as db:
        sittings.begin_sitting(db, test, ada.id, ["TP1"], now)
    with database.write() as db:
        groups.delete_group(db, term.made, term.teacher.id, "TP2")
        member = classes.find_membership(db, term.made.id, ada.id)
        assert member is not None
        member.groups = []
    with database.read() as db:
        assert [own.assignment.title for own in load_assignments_for_student(db, term.made.id, ada.id, (), now)] == [
            "Contrôle"
        ], "what ada has begun stays hers"
        assert feedback.load_holds(db, ada.id, POSES).running_tests


def test_groups_are_made_from_names_in_either_order_and_every_wrong_line_is_named(database: Database) -> None:
    term, ada, alan, ines = people(database)
    with database.write() as db:
        members = classes.load_members(db, term.made.id)
        found = groups.find_named_students(members, "lovelace ADA\n\nInes Roy\nAda Lovelace\n")
        assert found == [ada.id, ines.id]
        assert groups.create_group(db, term.made, term.teacher.id, " Reprise  ", found) == "Reprise"
        changes = load_entries(db, term.made.id, AuditFilter(what=AuditAction.groups_changed), limit=9)
        assert {entry.student.id for entry in changes if entry.student is not None} == {ada.id, ines.id}
    for text, words in (("Zoé\nAda Lovelace\nBob", "« Zoé », « Bob »"), ("  ", "au moins un nom")):
        with database.read() as db, pytest.raises(InvalidFields) as refused:
            groups.find_named_students(classes.load_members(db, term.made.id), text)
        assert words in refused.value.problems["names"]
    for name in ("reprise", "", "a, b", "x" * 41):
        with database.write() as db, pytest.raises(InvalidFields):
            groups.create_group(db, term.made, term.teacher.id, name, [alan.id])


@pytest.mark.parametrize("count", [2, 3, 7])
def test_dealt_groups_are_equal_and_hold_everybody_once(database: Database, count: int) -> None:
    term = Term.begin(database)
    students = [term.student(f"Élève{number}", "Petit").id for number in range(7)]
    with database.write() as db:
        labels = groups.create_random_groups(db, term.made, term.teacher.id, "TP", count, students, Random(3))
        own = {member.id: member.groups for member in classes.load_members(db, term.made.id) if member.id in students}
    assert sorted(label for labels in own.values() for label in labels) == sorted(
        labels[index % count] for index in range(7)
    )


def test_a_renamed_group_keeps_its_assignments_and_exemptions(database: Database, course: Course) -> None:
    term, ada, _, _ = people(database)
    part = term.assignment("TP1", {POSES: 1.0}, groups=("TP1", "TP2"))
    with database.write() as db:
        groups.rename_group(db, term.made, term.teacher.id, "TP1", "Lundi")
    with database.read() as db:
        stored = repository.find_assignment(db, term.made.id, part.id)
        assert stored is not None
        assert tuple(stored.groups) == ("Lundi", "TP2")
        book = load_gradebook(db, course, term.made, AFTER, only=[ada.id])
        assert book.rows[0].marks[0].state is not MarkState.not_concerned
    with database.write() as db, pytest.raises(InvalidFields) as refused:
        groups.delete_group(db, term.made, term.teacher.id, "Lundi")
    assert "devoir « TP1 »" in refused.value.problems["name"]


def test_an_assignment_is_given_only_to_groups_that_the_class_has(database: Database, course: Course) -> None:
    term, *_ = people(database)
    fields: dict[str, Any] = {"title": "DM", "exercises": ((POSES, 1.0),), "opens_at": OPENS, "due_at": DUE}
    with database.write() as db, pytest.raises(InvalidFields) as refused:
        editing.create_assignment(db, course, term.made, term.teacher.id, AssignmentInput(**fields, groups=("TP9",)))
    assert "TP9" in refused.value.problems["groups"]
    with database.write() as db:
        made = editing.create_assignment(
            db, course, term.made, term.teacher.id, AssignmentInput(**fields, groups=("TP1", "TP1"))
        )
        assert tuple(made.groups) == ("TP1",)
        past = editing.load_editable_fields(db, made)
    with database.write() as db:
        groups_of_ada = classes.load_active_students(db, term.made.id)
        for student in groups_of_ada:
            member = classes.find_membership(db, term.made.id, student.id)
            assert member is not None
            member.groups = []
        stored = editing.find_assignment(db, term.made, made.id)
        later = AssignmentInput(**{**fields, "due_at": DUE + timedelta(days=1)}, groups=past.groups)
        editing.update_assignment(db, course, term.made, term.teacher.id, stored, later)  # an emptied group may stay
