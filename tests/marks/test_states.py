"""Each state of a mark: how one comes to it, what it is called, and how it counts as the class has chosen."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime

import pytest

from server.assignments.models import Mode
from server.audit.wording import FIELDS, VALUES
from server.base.errors import Conflict, Invalid, NotFound
from server.classes.models import Status
from server.course import Course
from server.database import Database
from server.identity.models import Account
from server.marks import decisions, service
from server.marks.files import assignment_value_cell, explain_marking_rules
from server.marks.loading import load_gradebook
from server.marks.models import MarkingPolicy, StateDecision
from server.marks.repository import load_marking_rules, load_prevailing_overrides
from server.marks.schemas import AssignmentMark, Gradebook
from server.marks.states import STATE_WORDS, Counting, DecidedState, MarkingRules, MarkState
from tests.support.marks import AFTER, CLOSES, DAY, DUE, ODOMETRY, OPENS, POSES, Term
from tests.support.service import new_account

ZEROES = MarkingRules(*[Counting.zero] * 4)


@pytest.fixture
def term(sqlite: Database) -> Term:
    return Term.begin(sqlite)


def made(term: Term, course: Course, now: datetime = AFTER) -> Gradebook:
    with term.database.read() as db:
        return load_gradebook(db, course, term.made, now)


def only(term: Term, course: Course, now: datetime = AFTER) -> AssignmentMark:
    ((mark,),) = (row.marks for row in made(term, course, now).rows)
    return mark


def choose(term: Term, rules: MarkingRules, version: int | None = None) -> None:
    with term.database.write() as db:
        decisions.set_marking_rules(db, term.made, term.teacher, rules, version)


def decide(term: Term, student: Account, state: str, assignment_id: object, reason: str = "") -> None:
    with term.database.write() as db:
        decisions.set_state_decision(db, term.made, term.teacher, student.id, assignment_id, state, reason)  # type: ignore[arg-type]


def test_six_states_are_six_words(term: Term, course: Course) -> None:
    dm = term.assignment("DM", {POSES: 1.0}, late="refuse", closes_at=None)
    names = ("zéro", "rien", "tard", "absent", "dispensé", "douze")
    students = {name: term.student(name, name) for name in names}
    term.send(students["zéro"], POSES, 0)
    term.send(students["douze"], POSES, 12)
    term.send(students["tard"], POSES, 20, DUE + DAY)
    decide(term, students["absent"], "absent", dm.id)
    decide(term, students["dispensé"], "excused", dm.id)
    cells = {row.member.given_name: assignment_value_cell(row.marks[0]) for row in made(term, course).rows}
    assert cells == {
        "zéro": 0.0, "rien": "non rendu", "tard": "refusé (retard)", "absent": "absent", "dispensé": "dispensé",
        "douze": 12.0,
    }  # fmt: skip
    assert {assignment_value_cell(row.marks[0]) for row in made(term, course, OPENS - 3 * DAY).rows} >= {"à venir"}
    averages = {row.member.given_name: row.average for row in made(term, course).rows}
    assert averages == {**dict.fromkeys(names), "zéro": 0.0, "douze": 12.0}
    choose(term, ZEROES)
    averages = {row.member.given_name: row.average for row in made(term, course).rows}
    assert averages == {**dict.fromkeys(names, 0.0), "dispensé": None, "douze": 12.0}


@pytest.mark.parametrize("rule", ["not_handed_in", "late_refused", "absent"])
def test_each_rule_is_about_its_state_alone(term: Term, course: Course, rule: str) -> None:
    dm = term.assignment("DM", {POSES: 1.0}, late="refuse", closes_at=None)
    nothing, late, away = (term.student(name, name) for name in ("rien", "tard", "absent"))
    term.send(late, POSES, 20, DUE + DAY)
    decide(term, away, "absent", dm.id)
    choose(term, replace(MarkingRules(), **{rule: Counting.zero}))  # type: ignore[arg-type]
    counted = {row.marks[0].state.value for row in made(term, course).rows if row.average == 0.0}
    assert counted == {rule}
    assert nothing.id


def test_a_blank_of_a_copy_counts_zero_unless_the_class_says_otherwise(term: Term, course: Course) -> None:
    term.assignment(exercises={POSES: 1.0, ODOMETRY: 3.0}, late="refuse", closes_at=None)
    ada = term.student("Ada", "Lovelace")
    term.send(ada, POSES, 12)
    assert only(term, course).points == 3
    term.send(ada, ODOMETRY, 20, CLOSES)
    assert only(term, course).points == 3, "refused as late is worth no more than a blank"
    assert [one.state_within(only(term, course).state) for one in only(term, course).exercises] == [
        MarkState.done, MarkState.late_refused,
    ]  # fmt: skip
    choose(term, MarkingRules(unanswered=Counting.ignore))
    assert only(term, course).points == 12


def test_a_blank_copy_of_a_test_is_a_zero(term: Term, course: Course) -> None:
    test = term.assignment(exercises={POSES: 1.0}, mode=Mode.test)
    ada, _ = term.student("Ada", "Abel"), term.student("Émile", "Zola")
    term.sit(test, ada, OPENS + DAY)
    states = [(row.marks[0].state, row.marks[0].points) for row in made(term, course).rows]
    assert states == [(MarkState.done, 0.0), (MarkState.not_handed_in, None)]
    choose(term, MarkingRules(unanswered=Counting.ignore))
    assert made(term, course).rows[0].marks[0].points == 0.0


def test_a_decision_holds_until_it_is_withdrawn(term: Term, course: Course) -> None:
    dm = term.assignment(exercises={POSES: 1.0})
    ada = term.student("Ada", "Lovelace")
    term.send(ada, POSES, 12)
    for state, expected, points in (
        ("absent", MarkState.absent, None), ("zero", MarkState.done, 0.0), ("excused", MarkState.excused, None),
    ):  # fmt: skip
        decide(term, ada, state, dm.id, "vu le 3 mars")
        mark = only(term, course)
        assert (mark.state, mark.points, mark.has_override_or_decision, mark.stale) == (expected, points, True, False)
    with term.database.write() as db:
        decisions.withdraw_state_decision(db, term.made, term.teacher, ada.id, dm.id)
        decisions.withdraw_state_decision(db, term.made, term.teacher, ada.id, dm.id)
    assert (only(term, course).state, only(term, course).points) == (MarkState.done, 12)
    with term.database.read() as db:
        assert len(db.query(StateDecision).all()) == 3, "nothing is lost"


def test_work_sent_after_a_decision_is_to_be_looked_at(term: Term, course: Course) -> None:
    dm = term.assignment(exercises={POSES: 1.0}, closes_at=None)
    ada = term.student("Ada", "Lovelace")
    decide(term, ada, "absent", dm.id)
    with term.database.write() as db:
        db.query(StateDecision).update({"at": OPENS})
    assert not only(term, course).stale
    term.send(ada, POSES, 12)
    assert (only(term, course).state, only(term, course).stale) == (MarkState.absent, True)


def test_refused_decisions_change_nothing(term: Term) -> None:
    dm, ada = term.assignment(), term.student("Ada", "Lovelace")
    elsewhere = Term.begin(term.database).assignment()
    gone = term.student("Alan", "Turing", status=Status.left)
    for student, state, assignment, reason, refusal in (
        (ada, "malade", dm, "", Invalid),
        (ada, "absent", dm, "x" * 1001, Invalid),
        (ada, "absent", elsewhere, "", NotFound),
        (gone, "absent", dm, "", NotFound),
        (term.teacher, "absent", dm, "", NotFound),
        (new_account(term.database), "absent", dm, "", NotFound),
    ):
        with pytest.raises(refusal):
            decide(term, student, state, assignment.id, reason)
    with term.database.read() as db:
        assert db.query(StateDecision).all() == []


def test_rules_seen_by_another_teacher_are_not_overwritten(term: Term) -> None:
    with term.database.read() as db:
        assert load_marking_rules(db, term.made.id).is_chosen, "a new class has the default"
    choose(term, ZEROES, 0)
    with pytest.raises(Conflict):
        choose(term, MarkingRules(), 0)
    with term.database.read() as db:
        kept = load_marking_rules(db, term.made.id)
    assert (kept.rules, kept.version) == (ZEROES, 1)
    choose(term, MarkingRules(), 1)


def test_a_copied_class_has_the_rules_that_were_chosen(term: Term) -> None:
    other, third = Term.begin(term.database).made, Term.begin(term.database).made
    with term.database.write() as db:
        values = dict.fromkeys(("not_handed_in", "late_refused", "absent", "unanswered"), "zero")
        db.add(MarkingPolicy(class_id=term.made.id, **values))
    with term.database.write() as db:
        decisions.copy_marking_rules(db, term.made, other)
        assert load_marking_rules(db, other.id).rules == MarkingRules(), "nobody has chosen them"
    choose(term, ZEROES)
    with term.database.write() as db:
        decisions.copy_marking_rules(db, term.made, third)
        assert (load_marking_rules(db, third.id).rules, load_marking_rules(db, third.id).is_chosen) == (ZEROES, True)


def test_an_override_holds_in_one_assignment_or_everywhere(term: Term, course: Course) -> None:
    first, second = (term.assignment(title, {POSES: 1.0}) for title in ("DM 1", "DM 2"))
    ada = term.student("Ada", "Lovelace")
    term.send(ada, POSES, 4)

    def points() -> list[float | None]:
        return [mark.points for mark in made(term, course).rows[0].marks]

    def set_points(value: float, assignment_id: object) -> None:
        with term.database.write() as db:
            service.set_override(
                db, course, term.made, term.teacher, ada.id, POSES, points=value, excused=False, reason="oral",
                assignment_id=assignment_id,  # type: ignore[arg-type]
            )  # fmt: skip

    def withdraw(assignment_id: object) -> None:
        with term.database.write() as db:
            service.withdraw_override(db, course, term.made, term.teacher, ada.id, POSES, assignment_id=assignment_id)  # type: ignore[arg-type]

    def on_board() -> float | None:
        with term.database.read() as db:
            override = load_prevailing_overrides(db, term.made.id).get((ada.id, POSES))
        return None if override is None else override.points

    set_points(11, first.id)
    assert (points(), on_board()) == ([11, 4], 11)
    set_points(15, None)
    assert (points(), on_board()) == ([11, 15], 15)
    set_points(12, first.id)
    assert (points(), on_board()) == ([12, 15], 15)
    withdraw(None)
    withdraw(None)
    assert points() == [12, 4]
    set_points(13, second.id)
    assert (points(), on_board()) == ([12, 13], 13)
    withdraw(first.id)
    assert points() == [4, 13]
    with term.database.write() as db:
        db.merge(second).removed_at = AFTER
    assert (points(), on_board()) == ([4], None), "of a deleted assignment nothing is in force"
    with term.database.write() as db:
        db.merge(second).removed_at = None
    assert (points(), on_board()) == ([4, 13], 13)
    elsewhere = Term.begin(term.database).assignment()
    for assignment, exercise in ((elsewhere, POSES), (first, ODOMETRY)):
        with pytest.raises(NotFound), term.database.write() as db:
            service.set_override(
                db, course, term.made, term.teacher, ada.id, exercise, points=1.0, excused=False, reason="x",
                assignment_id=assignment.id,
            )  # fmt: skip


def test_an_override_in_one_assignment_is_stale_by_that_one(term: Term, course: Course) -> None:
    early, late = (term.assignment(title, {POSES: 1.0}, closes_at=end, due_at=None)
                   for title, end in (("Tôt", OPENS + 2 * DAY), ("Tard", CLOSES)))  # fmt: skip
    ada = term.student("Ada", "Lovelace")
    term.send(ada, POSES, 4)
    for assignment in (early, late):
        with term.database.write() as db:
            service.set_override(
                db, course, term.made, term.teacher, ada.id, POSES, points=9.0, excused=False, reason="oral",
                assignment_id=assignment.id,
            )  # fmt: skip
    term.send(ada, POSES, 16, OPENS + 3 * DAY)
    gradebook = made(term, course)
    titles = [assignment.title for assignment in gradebook.assignments]
    stale = {title: mark.stale for title, mark in zip(titles, gradebook.rows[0].marks, strict=True)}
    assert stale == {"Tard": True, "Tôt": False}


def test_words_are_the_same_wherever_they_stand() -> None:
    for state in DecidedState:
        word = VALUES["state"][state]
        assert word == ("0" if state is DecidedState.zero else STATE_WORDS[MarkState(state.value)])
    for rule in ("not_handed_in", "late_refused", "absent"):
        assert FIELDS[rule] == STATE_WORDS[MarkState(rule)]
    notes = " ".join(explain_marking_rules(MarkingRules(absent=Counting.zero)))
    assert all(f"« {word} »" in notes for word in STATE_WORDS.values())
    assert "un enseignant l’a dit ; la note compte 0" in notes
