"""Columns of a teacher's own: what may be typed, who sees it, what of it counts, and how it comes back."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import date
from typing import Any
from uuid import UUID, uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.audit.models import AuditAction, AuditEvent
from server.base.errors import Conflict, Invalid, InvalidFields, NotFound
from server.course import Course
from server.database import Database
from server.marks import columns, decisions, service
from server.marks.columns import MarkEntry
from server.marks.files import MoodleIdentifier, build_marks_sheet, build_moodle_table
from server.marks.loading import load_gradebook
from server.marks.models import ManualColumn, ManualMark, StateDecision
from server.marks.schemas import Gradebook, TypedMark
from server.marks.states import TypedState
from server.marks.typed import (
    ColumnInput,
    format_typed_mark,
    parse_mark_comment,
    parse_typed_mark,
    validate_column_fields,
)
from server.personal.marks_data import marks_data
from tests.support.marks import AFTER, POSES, Term

ORAL = ColumnInput("Oral", out_of=10.0, taken_on=date(2026, 3, 16), weight=3.0)


@pytest.fixture
def term(sqlite: Database) -> Term:
    return Term.begin(sqlite)


def gradebook(term: Term, course: Course) -> Gradebook:
    with term.database.read() as db:
        return load_gradebook(db, course, term.made, AFTER)


def create(term: Term, fields: ColumnInput = ORAL, *, published: bool = False) -> UUID:
    with term.database.write() as db:
        column = columns.create_column(db, term.made, term.teacher, fields)
        columns.set_column_published(db, term.made, term.teacher, column.id, published=published)
        return column.id


def type_marks(term: Term, column: UUID, typed: dict[Any, str], out_of: float = 10.0, **values: Any) -> None:
    entries = [MarkEntry(student.id, parse_typed_mark(text, out_of), **values) for student, text in typed.items()]
    with term.database.write() as db:
        columns.store_column_marks(db, term.made, term.teacher, column, entries)


def test_columns_count_by_their_weight_and_a_bonus_on_top(term: Term, course: Course) -> None:
    term.assignment(exercises={POSES: 1.0})
    ada, alan = term.student("Ada", "Lovelace"), term.student("Alan", "Turing")
    term.send(ada, POSES, 12)
    oral = create(term)
    type_marks(term, oral, {ada: "7,5", alan: "abs"})
    averages = [row.average for row in gradebook(term, course).rows]
    assert averages == [(12 + 3 * 15) / 4, None]
    bonus = create(term, ColumnInput("Participation", out_of=2.0, bonus=True))
    type_marks(term, bonus, {ada: "1,5", alan: "2"}, 2.0)
    assert [row.average for row in gradebook(term, course).rows] == [(12 + 3 * 15) / 4 + 1.5, None]
    type_marks(term, oral, {ada: "10"})
    type_marks(term, bonus, {ada: "2"}, 2.0)
    assert gradebook(term, course).rows[0].average == 20.0
    type_marks(term, oral, {ada: ""})
    assert gradebook(term, course).rows[0].average == 14.0, "what is not typed yet does not count"


def test_students_see_what_is_published(term: Term, course: Course) -> None:
    ada = term.student("Ada", "Lovelace", email="ada@example.org")
    hidden, shown = create(term), create(term, replace(ORAL, title="Papier"), published=True)
    type_marks(term, hidden, {ada: "2"}, comment="à revoir")
    type_marks(term, shown, {ada: "8"}, comment="bien")
    with term.database.read() as db:
        own = service.load_visible_marks(db, course, term.made, ada.id, AFTER)
    assert [(mark.column.title, mark.typed.comment) for mark in own.columns] == [("Papier", "bien")]
    assert own.average == 16.0
    assert [term_.title for term_ in own.terms if term_.counted is not None] == ["Papier"]
    made = gradebook(term, course)
    assert made.rows[0].average == 10.0, "teachers count all they have typed"
    assert build_marks_sheet(made).header[-3:] == ("Oral /10", "Papier /10", "Moyenne")
    assert build_moodle_table(made, MoodleIdentifier.email).header == (
        "Email address",
        "Exercices du module",
        "Papier /10",
    )


def test_a_deleted_column_comes_back_with_its_marks(term: Term, course: Course) -> None:
    ada = term.student("Ada", "Lovelace")
    column = create(term)
    type_marks(term, column, {ada: "8"})
    with term.database.write() as db:
        columns.delete_column(db, term.made, term.teacher, column)
        columns.delete_column(db, term.made, term.teacher, column)
    assert (gradebook(term, course).columns, gradebook(term, course).rows[0].average) == ((), None)
    with pytest.raises(Conflict):
        type_marks(term, column, {ada: "9"})
    with term.database.write() as db:
        columns.restore_column(db, term.made, term.teacher, column)
    assert gradebook(term, course).rows[0].average == 16.0
    with term.database.read() as db:
        actions = [event.what for event in db.query(AuditEvent).order_by(AuditEvent.at, AuditEvent.id)]
    assert actions == [
        AuditAction.column_made, AuditAction.column_mark_changed, AuditAction.column_deleted,
        AuditAction.column_restored,
    ]  # fmt: skip


def test_columns_are_ordered(term: Term, course: Course) -> None:
    names = {title: create(term, replace(ORAL, title=title)) for title in "abc"}

    def order() -> str:
        return "".join(column.title for column in gradebook(term, course).columns)

    for title, place, expected in (("c", 0, "cab"), ("c", 99, "abc"), ("b", -5, "bac"), ("a", 1, "bac")):
        with term.database.write() as db:
            columns.move_column(db, term.made, term.teacher, names[title], place)
        assert order() == expected


def test_two_teachers_who_type_at_once_lose_nothing(term: Term) -> None:
    ada, alan = term.student("Ada", "Lovelace"), term.student("Alan", "Turing")
    column = create(term)
    type_marks(term, column, {ada: "5", alan: "6"}, version=0)
    with pytest.raises(Conflict, match="Ada Lovelace"):
        type_marks(term, column, {ada: "7"}, version=0)
    with pytest.raises(Conflict):
        type_marks(term, column, {alan: "9", ada: "7"}, version=0)
    with term.database.read() as db:
        stored = {mark.account_id: (mark.points, mark.version) for mark in db.query(ManualMark)}
    assert stored == {ada.id: (5.0, 1), alan.id: (6.0, 1)}, "all or none"
    type_marks(term, column, {ada: "5"}, version=0)
    type_marks(term, column, {ada: "7"}, version=1)


def test_what_cannot_be_a_column_is_refused(term: Term) -> None:
    refused: tuple[tuple[dict[str, Any], set[str]], ...] = (
        ({"title": " \u200b"}, {"title"}),
        ({"title": "x" * 101}, {"title"}),
        ({"out_of": 0.0}, {"out_of"}),
        ({"out_of": 1000.5}, {"out_of"}),
        ({"out_of": 12.345}, {"out_of"}),
        ({"out_of": float("nan"), "weight": float("nan")}, {"out_of", "weight"}),
        ({"weight": -1.0}, {"weight"}),
        ({"taken_on": date(1999, 12, 31)}, {"taken_on"}),
    )
    for values, fields in refused:
        with pytest.raises(InvalidFields) as told:
            validate_column_fields(replace(ORAL, **values))
        assert told.value.problems.keys() == fields
    ada = term.student("Ada", "Lovelace")
    column = create(term)
    type_marks(term, column, {ada: "8"})
    with pytest.raises(Invalid, match="8"), term.database.write() as db:
        columns.change_column(db, term.made, term.teacher, column, replace(ORAL, out_of=5.0))
    with pytest.raises(NotFound):
        type_marks(term, uuid4(), {ada: "8"})
    with pytest.raises(NotFound):
        type_marks(term, column, {term.teacher: "8"})
    elsewhere = Term.begin(term.database)
    with pytest.raises(NotFound):
        type_marks(elsewhere, column, {ada: "8"})


def test_the_number_of_columns_is_bounded(term: Term, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "MAX_COLUMNS", 2)
    monkeypatch.setattr(columns, "MAX_WITH_DELETED", 3)
    first, _ = create(term), create(term)
    with pytest.raises(Conflict):
        create(term)
    with term.database.write() as db:
        columns.delete_column(db, term.made, term.teacher, first)
    create(term)
    with pytest.raises(Conflict), term.database.write() as db:
        columns.restore_column(db, term.made, term.teacher, first)
    with term.database.write() as db:
        db.query(ManualColumn).update({"deleted_at": AFTER})
    with pytest.raises(Conflict):
        create(term)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("12,5", TypedMark(12.5)), (" 12.50 ", TypedMark(12.5)), ("8/20", TypedMark(8.0)), ("0", TypedMark(0.0)),
        ("-0", TypedMark(0.0)), ("ABS", TypedMark(state=TypedState.absent)),
        ("absente", TypedMark(state=TypedState.absent)),
        ("Dispensé", TypedMark(state=TypedState.excused)), ("disp.", TypedMark(state=TypedState.excused)),
        ("non rendu", TypedMark(state=TypedState.not_handed_in)), ("nr", TypedMark(state=TypedState.not_handed_in)),
        ("", TypedMark()), (" \u00a0", TypedMark()),
    ],
)  # fmt: skip
def test_a_cell_is_read_as_it_is_typed(text: str, expected: TypedMark) -> None:
    assert parse_typed_mark(text, 20.0) == expected


@pytest.mark.parametrize("text", ["quinze", "20,01", "-1", "12,345", "8/10", "nan", "inf", "1e1", "1_0", "٣", "12 13"])
def test_a_cell_that_is_no_mark_is_refused_in_words(text: str) -> None:
    with pytest.raises(Invalid, match=re.escape(f"« {text} »")):
        parse_typed_mark(text, 20.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("21", "« 21 » dépasse 20."),
        ("-1", "plus petit que 0"),
        ("0,333", "plus de deux décimales"),
        ("5/10", "cette colonne est notée sur 20"),
        ("quinze", "n’est pas une note de 0 à 20, ni « abs »"),
    ],
)
def test_a_refused_cell_says_in_one_line_what_is_wrong_with_it(text: str, said: str) -> None:
    with pytest.raises(Invalid) as refused:
        parse_typed_mark(text, 20.0)
    assert said in refused.value.detail
    assert len(refused.value.detail) < 80  # beside a field of a phone


def test_comments_fit_in_a_line() -> None:
    assert parse_mark_comment("  bon\u00a0travail\n ") == "bon travail"
    for text in ("x" * 501, "a\x00"):
        with pytest.raises(Invalid):
            parse_mark_comment(text)


hundredths = st.integers(0, 100_000).map(lambda number: number / 100)


@given(st.one_of(hundredths.map(TypedMark), st.sampled_from(TypedState).map(lambda state: TypedMark(state=state))))
def test_what_a_cell_shows_is_read_again(mark: TypedMark) -> None:
    assert parse_typed_mark(format_typed_mark(mark), 1000.0) == mark


def test_a_guest_s_marks_follow_to_the_account(term: Term) -> None:
    given = term.assignment(exercises={POSES: 1.0})
    guest, account = term.student("Ada", "Invitée"), term.student("Ada", "Lovelace")
    shared, own = create(term), create(term, replace(ORAL, title="Papier"))
    type_marks(term, shared, {guest: "3", account: "8"})
    type_marks(term, own, {guest: "5"})
    with term.database.write() as db:
        decisions.set_state_decision(db, term.made, term.teacher, guest.id, given.id, "absent", "")
        service.move_guest_marks(db, guest.id, account.id)
        stored = {(mark.column_id, mark.account_id): mark.points for mark in db.query(ManualMark)}
        assert stored == {(shared, account.id): 8.0, (own, account.id): 5.0}, "one's own is kept where both have one"
        assert [decision.account_id for decision in db.query(StateDecision)] == [account.id]


def test_personal_data_have_what_is_published(term: Term) -> None:
    given, ada = term.assignment(exercises={POSES: 1.0}), term.student("Ada", "Lovelace")
    hidden, shown = create(term), create(term, replace(ORAL, title="Papier"), published=True)
    for column, text in ((hidden, "2"), (shown, "abs")):
        type_marks(term, column, {ada: text}, comment=f"remarque {text}")
    with term.database.write() as db:
        decisions.set_state_decision(db, term.made, term.teacher, ada.id, given.id, "zero", "copie blanche")
    with term.database.read() as db:
        told = marks_data(db, ada.id)
        hers = marks_data(db, term.teacher.id)
    assert [(mark["column"], mark["state"], mark["comment"]) for mark in told["columns"]] == [
        ("Papier", "absent", "remarque abs"),
    ]  # fmt: skip
    assert [(decision["state"], decision["reason"]) for decision in told["decisions"]] == [("zero", "copie blanche")]
    assert "remarque 2" not in str(told)
    assert [event["what"] for event in told["changes_about_you"]] == ["state_decided"]
    assert sum(event["what"] == "column_mark_changed" for event in hers["changes_you_made"]) == 2
