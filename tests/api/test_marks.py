"""Marks by the HTTP interface (contract, section 6): set, withdrawn, taken away, and the log of it."""

from __future__ import annotations

import csv
import io
from typing import Any
from uuid import uuid4

import pytest
import python_calamine

from server.identity.models import Role
from server.marks.means import format_number
from tests.support.classes import Person, person
from tests.support.marks import DUE, ODOMETRY, POSES, Term
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
    return answer


def test_a_mark_is_set_read_looked_at_again_and_withdrawn(site: Site, term: Term, martin: Person) -> None:
    term.assignment("DM 1", {POSES: 2.0, ODOMETRY: 1.0})
    ada = term.student("Ada", "Lovelace", groups=["TP1"])
    term.send(ada, POSES, 5)
    path = f"{term.made.id}/marks/{ada.id}/{POSES}"
    set_one = call(site, martin, "PUT", path, json={"points": 11, "reason": "à l’oral"}).json()
    assert set_one["student"] == str(ada.id)
    override = set_one["mark"]["override"]
    assert (set_one["mark"]["points"], set_one["mark"]["automatic"]) == (11, 5)
    assert (override["reason"], override["by"], override["stale"]) == ("à l’oral", "Mme Martin", False)
    term.send(ada, POSES, 6, DUE)
    made = call(site, martin, "GET", f"{term.made.id}/gradebook").json()
    assert made.keys() == {"class", "generated_at", "marking", "assignments", "columns", "students"}
    (column,), (row,) = made["assignments"], made["students"]
    assert [one["weight"] for one in column["exercises"]] == [2, 1]
    assert (column["copies"], column["mean"], column["median"]) == (1, 7.33, 7.33)
    (mark,) = row["marks"]
    assert (row["name"], row["average"], mark["points"], mark["state"]) == ("Ada Lovelace", 7.33, 7.33, "done")
    assert [one["override"]["stale"] if one["override"] else None for one in mark["exercises"]] == [True, None]
    call(site, martin, "DELETE", path, 204)
    call(site, martin, "DELETE", path, 204)
    excused = call(site, martin, "PUT", path, json={"excused": True, "reason": "dispensée"}).json()
    assert (excused["mark"]["points"], excused["mark"]["excused"], excused["mark"]["automatic"]) == (None, True, 6)
    log = call(site, martin, "GET", f"{term.made.id}/audit").json()
    assert (log["total"], [one["what"] for one in log["events"]]) == (
        3, ["mark_overridden", "override_withdrawn", "mark_overridden"],
    )  # fmt: skip
    last, withdrawn, first = log["events"]
    assert (first["before"], first["after"]) == ({"points": 5.0}, {"points": 11.0})
    assert (withdrawn["before"], withdrawn["after"]) == ({"points": 11.0}, {"points": 6.0})
    assert (last["after"], last["student"]["name"]) == ({"points": None, "excused": True}, "Ada Lovelace")
    some = call(site, martin, "GET", f"{term.made.id}/audit?what=mark_overridden&skip=1&student={ada.id}").json()
    assert (some["total"], some["events"]) == (2, [first])


REFUSED: tuple[dict[str, Any], ...] = (
    {"points": 21, "reason": "x"},
    {"points": "12", "reason": "x"},
    {"points": 12},
    {"points": 12, "reason": "  "},
    {"points": 12, "excused": True, "reason": "x"},
    {"reason": "x"},
    {"points": 12, "reason": "x", "student": "moi"},
    {"points": 12, "reason": "x" * 1001},
)


def test_what_cannot_be_a_mark_is_refused(site: Site, term: Term, martin: Person) -> None:
    ada = term.student("Ada", "Lovelace")
    for body in REFUSED:
        call(site, martin, "PUT", f"{term.made.id}/marks/{ada.id}/{POSES}", 422, json=body)
    assert call(site, martin, "GET", f"{term.made.id}/audit").json() == {"total": 0, "events": []}


def test_marks_are_of_students_and_exercises_that_are_there(site: Site, term: Term, martin: Person) -> None:
    ada, body = term.student("Ada", "Lovelace"), {"points": 12, "reason": "x"}
    for where in (f"{uuid4()}/{POSES}", f"zut/{POSES}", f"{ada.id}/l20/rien", f"{martin.id}/{POSES}"):
        call(site, martin, "PUT", f"{term.made.id}/marks/{where}", 404, json=body)
    call(site, person(site, account=ada), "PUT", f"{term.made.id}/marks/{ada.id}/{POSES}", 403, json=body)


def test_files_say_what_the_json_says(site: Site, term: Term, martin: Person) -> None:
    term.assignment("=DM; 1", {POSES: 1.0})
    term.assignment("DM 2", {ODOMETRY: 1.0}, weight=2.0)
    ada = term.student("Ada", "Lovelace", email="ada@example.org")
    term.student("Alan", "Turing")
    term.send(ada, POSES, 12.5)
    term.send(ada, ODOMETRY, 40 / 3)

    def file(query: str) -> Any:
        return call(site, martin, "GET", f"{term.made.id}/gradebook?format={query}")

    made = file("json").json()
    known = [[one["points"] for one in row["marks"]] + [row["average"]] for row in made["students"]]
    assert known == [[12.5, 13.33, 13.06], [None, None, None]]

    sheet = file("csv")
    assert sheet.headers["content-disposition"].startswith('attachment; filename="balise-mpsi-2-notes-20')
    text = sheet.content.decode("utf-8-sig")
    header, first, second = csv.reader(io.StringIO(text, newline=""), delimiter=";")
    assert header == ["Nom", "Prénom", "Identifiant", "Groupe", "'=DM; 1", "DM 2", "Moyenne"]
    assert first[:2] == ["Lovelace", "Ada"]
    assert first[4:] == [format_number(one) for one in known[0]] == ["12,5", "13,33", "13,06"]
    assert second[4:] == ["non rendu", "non rendu", ""]

    xlsx = file("xlsx")
    book = python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(xlsx.content))
    assert book.sheet_names == ["Notes", "Exercices", "Explications"]
    notes = book.get_sheet_by_name("Notes").to_python()
    assert (notes[0][4], notes[1][4:], notes[2][4:]) == ("=DM; 1", known[0], ["non rendu", "non rendu", ""])
    weights = [row[:2] for row in book.get_sheet_by_name("Explications").to_python()[1:3]]
    assert weights == [["=DM; 1", 1], ["DM 2", 2]]

    moodle = file("moodle")
    assert moodle.headers["x-balise-left-out"] == "1"
    assert moodle.content.decode() == '"Email address","\'=DM; 1","DM 2"\r\n"ada@example.org","12.5","13.33"\r\n'
    assert file("moodle&identifier=id").headers["x-balise-left-out"] == "2"
    call(site, martin, "GET", f"{term.made.id}/gradebook?format=pdf", 422)
