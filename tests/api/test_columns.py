"""Columns, decisions, rules of the mean and scopes of overrides over HTTP."""

from __future__ import annotations

from typing import Any
from uuid import uuid4

import pytest

from server.identity.models import Role
from tests.support.classes import Person, person, seat
from tests.support.marks import POSES, Term
from tests.support.service import Site


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


@pytest.fixture
def term(site: Site, martin: Person) -> Term:
    return Term.begin(site.database, martin.account)


def call(site: Site, who: Person, method: str, path: str, status: int = 200, **options: Any) -> Any:
    answer = site.client.request(method, f"/api/v1/classes/{path}", headers=who.headers, **options)
    assert answer.status_code == status, answer.text
    return answer.json() if answer.content else None


def test_a_column_lives(site: Site, term: Term, martin: Person) -> None:
    ada, alan = term.student("Ada", "Lovelace"), term.student("Alan", "Turing")
    place = f"{term.made.id}/columns"
    oral = call(site, martin, "POST", place, 201, json={"title": " Oral ", "out_of": 10, "taken_on": "2026-03-16"})
    assert (oral["title"], oral["out_of"], oral["taken_on"], oral["weight"], oral["published_at"]) == (
        "Oral", 10, "2026-03-16", 1, None,
    )  # fmt: skip
    one = f"{place}/{oral['id']}"
    marks = [
        {"student": str(ada.id), "points": 7.5, "comment": "bien", "version": 0},
        {"student": str(alan.id), "state": "absent"},
    ]
    typed = call(site, martin, "PUT", f"{one}/marks", json={"marks": marks})
    keys = ("name", "points", "state", "comment", "version")
    assert [tuple(mark[key] for key in keys) for mark in typed["marks"]] == [
        ("Ada Lovelace", 7.5, None, "bien", 1), ("Alan Turing", None, "absent", "", 1),
    ]  # fmt: skip
    stale = {"marks": [{"student": str(ada.id), "points": 3, "version": 0}]}
    assert "Ada Lovelace" in call(site, martin, "PUT", f"{one}/marks", 409, json=stale)["detail"]
    book = call(site, martin, "GET", f"{term.made.id}/gradebook")
    assert [(column["title"], column["mean"], column["copies"]) for column in book["columns"]] == [("Oral", 7.5, 1)]
    assert [(row["columns"][0]["state"], row["columns"][0]["counted"], row["average"]) for row in book["students"]] == [
        ("done", 15, 15), ("absent", None, None),
    ]  # fmt: skip
    changed = call(site, martin, "PATCH", one, json={"published": True, "weight": 2, "version": oral["version"]})
    assert (changed["weight"], changed["published_at"] is None) == (2, False)
    call(site, martin, "PATCH", one, 409, json={"weight": 3, "version": oral["version"]})
    assert call(site, martin, "PATCH", one, json={"taken_on": None})["taken_on"] is None
    other = call(site, martin, "POST", place, 201, json={"title": "Participation", "bonus": True, "published": True})
    call(site, martin, "PATCH", f"{place}/{other['id']}", json={"place": 0})
    assert [column["title"] for column in call(site, martin, "GET", place)] == ["Participation", "Oral"]
    call(site, martin, "DELETE", one, 204)
    assert [column["title"] for column in call(site, martin, "GET", f"{place}?deleted=true")] == ["Oral"]
    call(site, martin, "PUT", f"{one}/marks", 409, json={"marks": []})
    call(site, martin, "POST", f"{one}/restore")
    assert call(site, martin, "GET", one)["marks"][0]["points"] == 7.5
    kinds = {event["what"] for event in call(site, martin, "GET", f"{term.made.id}/audit")["events"]}
    assert kinds == {"column_made", "column_changed", "column_deleted", "column_restored", "column_mark_changed"}


REFUSED: tuple[dict[str, Any], ...] = (
    {},
    {"title": "\u200b"},
    {"title": "Oral", "out_of": 0},
    {"title": "Oral", "out_of": 1.234},
    {"title": "Oral", "taken_on": "16/03/2026"},
    {"title": "Oral", "taken_on": "1999-01-01"},
    {"title": "Oral", "weight": -1},
    {"title": "Oral", "weight": "2"},
    {"title": "Oral", "coefficient": 2},
)


def test_what_cannot_be_a_column_or_a_mark_is_refused(site: Site, term: Term, martin: Person) -> None:
    ada, place = term.student("Ada", "Lovelace"), f"{term.made.id}/columns"
    for body in REFUSED:
        call(site, martin, "POST", place, 422, json=body)
    one = f"{place}/{call(site, martin, 'POST', place, 201, json={'title': 'Oral'})['id']}"
    for status, mark in (
        (422, {"student": str(ada.id), "points": 21}),
        (422, {"student": str(ada.id), "points": 1.234}),
        (422, {"student": str(ada.id), "points": 2, "state": "absent"}),
        (422, {"student": str(ada.id), "state": "malade"}),
        (422, {"student": str(ada.id), "comment": "x" * 501}),
        (422, {"points": 2}),
        (404, {"student": None, "points": 2}),
        (404, {"student": str(martin.id), "points": 2}),
    ):
        call(site, martin, "PUT", f"{one}/marks", status, json={"marks": [mark]})
    call(site, martin, "GET", f"{place}/{uuid4()}", 404)
    call(site, martin, "GET", f"{place}/zut", 404)
    assert [mark["version"] for mark in call(site, martin, "GET", one)["marks"]] == [0]


def test_states_are_decided_and_counted_as_the_class_chooses(site: Site, term: Term, martin: Person) -> None:
    given, ada = term.assignment(exercises={POSES: 1.0}), term.student("Ada", "Lovelace")
    helper = person(site)
    seat(site.database, term.made, helper.account, "assistant")

    def mark() -> tuple[str, Any, Any, Any]:
        (row,) = call(site, martin, "GET", f"{term.made.id}/gradebook")["students"]
        (told,) = row["marks"]
        decision = told["decision"] and told["decision"]["state"]
        return told["state"], told["counted"], row["average"], decision

    assert mark() == ("not_handed_in", None, None, None)
    marking = f"{term.made.id}/marking"
    assert call(site, helper, "GET", marking) == {
        "not_handed_in": "ignore", "late_refused": "ignore", "absent": "ignore", "unanswered": "zero",
        "chosen": True, "version": 0,
    }  # fmt: skip
    call(site, helper, "PATCH", marking, 403, json={"absent": "zero"})
    chosen = call(site, martin, "PATCH", marking, json={"not_handed_in": "zero", "version": 0})
    assert (chosen["not_handed_in"], chosen["absent"], chosen["version"]) == ("zero", "ignore", 1)
    call(site, martin, "PATCH", marking, 409, json={"absent": "zero", "version": 0})
    assert mark() == ("not_handed_in", 0, 0, None)
    path = f"{term.made.id}/assignments/{given.id}/decisions/{ada.id}"
    made = call(site, martin, "PUT", path, json={"state": "absent", "reason": "Absente le 3 mars."})
    assert (made["decision"]["state"], made["decision"]["by"]) == ("absent", "Mme Martin")
    assert mark() == ("absent", None, None, "absent")
    call(site, martin, "PUT", path, json={"state": "zero"})
    assert mark() == ("done", 0, 0, "zero")
    call(site, martin, "PUT", path, 422, json={"state": "malade"})
    call(site, martin, "DELETE", path, 204)
    assert mark() == ("not_handed_in", 0, 0, None)


def test_an_override_says_where_it_holds(site: Site, term: Term, martin: Person) -> None:
    first, second = (term.assignment(title, {POSES: 1.0}) for title in ("DM 1", "DM 2"))
    ada = term.student("Ada", "Lovelace")
    path, body = f"{term.made.id}/marks/{ada.id}/{POSES}", {"points": 11, "reason": "oral"}

    def points() -> list[float | None]:
        (row,) = call(site, martin, "GET", f"{term.made.id}/gradebook")["students"]
        return [mark["points"] for mark in row["marks"]]

    here = call(site, martin, "PUT", f"{path}?assignment={second.id}", json=body)
    assert here["mark"]["override"]["assignment"] == str(second.id)
    assert points() == [None, 11]
    everywhere = call(site, martin, "PUT", path, json={**body, "points": 15})
    assert everywhere["mark"]["override"]["assignment"] is None
    assert points() == [15, 11]
    log = call(site, martin, "GET", f"{term.made.id}/audit")["events"]
    assert [event["about"].rpartition(", ")[2] for event in log] == [
        "dans tous les devoirs", "dans le devoir « DM 2 » seulement",
    ]  # fmt: skip
    call(site, martin, "DELETE", path, 204)
    assert points() == [None, 11]
    call(site, martin, "DELETE", f"{path}?assignment={first.id}", 204)
    call(site, martin, "DELETE", f"{path}?assignment={second.id}", 204)
    assert points() == [None, None]
    call(site, martin, "PUT", f"{path}?assignment={uuid4()}", 404, json=body)
    call(site, martin, "PUT", f"{path}?assignment=zut", 422, json=body)
