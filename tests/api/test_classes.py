"""Classes by the HTTP interface (contract, section 6): shapes, joining, lists."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any
from uuid import UUID, uuid4

import pytest

from server.classes.models import ClassRole, Membership, SchoolClass
from server.database import utc_now
from server.identity.models import Account, Role
from tests.support.classes import Person, person, seat
from tests.support.service import Site

API = "/api/v1/classes"
LIST = "nom,prenom,email,identifiant,groupe\n"


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


def call(site: Site, who: Person, method: str, path: str, status: int, **options: Any) -> Any:
    answer = site.client.request(method, path, headers=who.headers | options.pop("headers", {}), **options)
    assert answer.status_code == status, answer.text
    return answer.json()


def create(site: Site, who: Person, name: str = "MPSI 2", status: int = 201) -> Any:
    return call(site, who, "POST", API, status, json={"name": name, "module": "l20"})


def roster(site: Site, who: Person, made: Any, text: str | bytes, status: int = 200, query: str = "") -> Any:
    content = text.encode() if isinstance(text, str) else text
    path = f"{API}/{made['id']}/roster{query}"
    return call(site, who, "POST", path, status, content=content, headers={"Content-Type": "text/csv"})


def test_a_class_is_made_found_and_joined(site: Site, martin: Person) -> None:
    made = create(site, martin)
    assert made.keys() == {"id", "name", "module", "join_code", "url"}
    assert (made["name"], made["module"], made["url"]) == ("MPSI 2", "l20", f"{API}/{made['id']}")
    (listed,) = call(site, martin, "GET", API, 200)
    assert listed == call(site, martin, "GET", made["url"], 200)
    assert listed == {**made, "role": "teacher", "status": "active", "archived_at": None}

    ada = person(site)
    call(site, ada, "GET", made["url"], 404)
    assert call(site, ada, "GET", API, 200) == []
    code = made["join_code"]
    typed = f" {code[:4].lower()}-{code[4:]} "
    joined = call(site, ada, "POST", f"{API}/join", 200, json={"code": typed})
    assert joined == {**made, "join_code": None, "role": "student", "status": "active", "archived_at": None}
    assert call(site, ada, "POST", f"{API}/join", 200, json={"code": code}) == joined
    (student,) = call(site, martin, "GET", f"{made['url']}/students", 200)
    assert student.keys() == {"id", "name", "groups", "joined_at", "last_seen_at"}
    assert (student["id"], student["name"], student["groups"]) == (str(ada.id), "Ada", [])
    assert datetime.fromisoformat(student["joined_at"]).tzinfo is not None
    assert student["last_seen_at"] is None
    site.submit(ada.headers)
    (student,) = call(site, martin, "GET", f"{made['url']}/students", 200)
    assert datetime.fromisoformat(student["last_seen_at"]) <= utc_now()


def test_a_code_that_is_not_good_opens_nothing(site: Site, martin: Person) -> None:
    made, ada = create(site, martin), person(site)
    with site.database.write() as db:
        row = db.get_one(SchoolClass, UUID(made["id"]))
        row.join_code_until = utc_now() - timedelta(seconds=1)
    for code in (made["join_code"], "BCDFGHJK", "", "é" * 90):
        call(site, ada, "POST", f"{API}/join", 404, json={"code": code})
    with site.database.write() as db:
        row = db.get_one(SchoolClass, UUID(made["id"]))
        row.join_code, row.join_code_until = "BCDFGHJK", utc_now() + timedelta(days=1)
    call(site, ada, "POST", f"{API}/join", 404, json={"code": made["join_code"]})
    call(site, ada, "POST", f"{API}/join", 200, json={"code": "bcdf ghjk"})


def test_codes_are_not_tried_in_turn(site: Site, martin: Person) -> None:
    made, ada = create(site, martin), person(site)
    site.tighten(join_burst=2)
    for _ in range(2):
        call(site, ada, "POST", f"{API}/join", 404, json={"code": "BCDFGHJK"})
    call(site, ada, "POST", f"{API}/join", 429, json={"code": made["join_code"]})


def test_a_lecture_hall_joins_from_one_address_and_wrong_codes_are_counted(site: Site, martin: Person) -> None:
    made = create(site, martin)
    site.tighten(guest_burst=2, guest_refill_seconds=1000.0)
    for _ in range(4):
        call(site, person(site), "POST", f"{API}/join", 200, json={"code": made["join_code"]})
    for status in (404, 404, 429):
        call(site, person(site), "POST", f"{API}/join", status, json={"code": "BCDFGHJK"})


def test_what_is_refused_names_the_missing_right(site: Site, martin: Person) -> None:
    made = create(site, martin)
    ada, helper, stranger = person(site), person(site), person(site, Role.teacher)
    with site.database.read() as db:
        row = db.get_one(SchoolClass, UUID(made["id"]))
    seat(site.database, row, ada.account)
    seat(site.database, row, helper.account, ClassRole.assistant)
    assert "droit de créer une classe" in create(site, ada, status=403)["detail"]
    told = call(site, ada, "GET", f"{made['url']}/students", 403)["detail"]
    assert told == (
        "Il vous manque le droit de voir les élèves de la classe. Dans la classe « MPSI 2 », "
        "les enseignants et les assistants l’ont."
    )
    assert "droit de tenir la liste de la classe" in roster(site, helper, made, LIST, 403)["detail"]
    call(site, helper, "GET", f"{made['url']}/students", 200)
    for path in (made["url"], f"{made['url']}/students", f"{API}/{uuid4()}", f"{API}/zut"):
        call(site, stranger, "GET", path, 404)
    roster(site, stranger, made, LIST, 404)
    call(site, martin, "POST", API, 404, json={"name": "x", "module": "l99"})
    assert "nom de 1 à 100" in call(site, martin, "POST", API, 422, json={"name": " ", "module": "l20"})["detail"]


def test_a_list_is_tried_then_written_then_changes_nothing(site: Site, martin: Person) -> None:
    made = create(site, martin)
    text = LIST + "Lovelace,Ada,ada@example.org,ada,TP1\nTuring,Alan,,,TP2\nNul,Part,pas une adresse,,\n"
    told = roster(site, martin, made, text, query="?dry_run=true")
    assert told.keys() == {
        "added", "updated", "unchanged", "left", "rejected", "ignored_columns", "columns", "warnings", "leaving",
        "not_in_list", "classes", "encoding",
    }  # fmt: skip
    assert (told["added"], told["updated"], told["unchanged"], told["left"]) == (2, 0, 0, 0)
    assert [one["line"] for one in told["rejected"]] == [4]
    assert "pas une adresse" in told["rejected"][0]["reason"]
    assert call(site, martin, "GET", f"{made['url']}/students", 200) == []
    assert roster(site, martin, made, text) == told
    students = call(site, martin, "GET", f"{made['url']}/students", 200)
    assert [(one["name"], one["groups"]) for one in students] == [("Ada Lovelace", ["TP1"]), ("Alan Turing", ["TP2"])]
    again = roster(site, martin, made, text)
    assert (again["added"], again["updated"], again["unchanged"], again["left"]) == (0, 0, 2, 0)
    moved = roster(site, martin, made, "nom;prenom;identifiant;groupe\nLovelace;Ada;ada;TP3\n", query="?mode=replace")
    assert [(one["name"], one["joined_by_code"]) for one in moved["leaving"]] == [("Alan Turing", False)]
    assert (moved["added"], moved["updated"], moved["unchanged"], moved["left"]) == (0, 1, 0, 1)
    with site.database.read() as db:
        assert len(db.query(Account).all()) == 3, "nobody is deleted"
        assert sorted(row.status for row in db.query(Membership).all()) == ["active", "active", "left"]
    back = roster(site, martin, made, text)
    assert (back["added"], back["updated"], back["unchanged"], back["left"]) == (0, 2, 0, 0)


def test_a_list_that_is_none_is_refused_whole(site: Site, martin: Person) -> None:
    made = create(site, martin)
    for content in (b"", b"Lovelace,Ada\n", b"nom,nom\nA,B\n", b"\x00\x01", b"PK\x03\x04 no spreadsheet", b'nom\n"a'):
        assert roster(site, martin, made, content, 422)["detail"]
    roster(site, martin, made, b"nom\n" + b"a\n" * 300_000, 413)
    assert "2000 lignes" in roster(site, martin, made, b"nom\n" + b"a\n" * 2001, 422)["detail"]


def test_whoever_is_named_in_a_list_is_not_taken_in_unasked(site: Site, martin: Person) -> None:
    """Or any teacher would read what the owner of a known login has done, and hand over their password."""
    made = create(site, martin)
    with site.database.write() as db:
        db.add(Account(role=Role.administrator, name="Grace Hopper", login="grace"))
    told = roster(site, martin, made, "nom,identifiant\nHopper,grace\n")
    assert (told["added"], told["left"]) == (0, 0)
    assert "compte qui existe déjà" in told["rejected"][0]["reason"]
    other = create(site, martin, "PSI")
    roster(site, martin, made, "nom,identifiant\nNoether,emmy\n")
    assert roster(site, martin, other, "nom,identifiant\nNoether,emmy\n")["added"] == 1, "her own student elsewhere"


def test_a_list_takes_nobody_out_unless_it_replaces_the_class(site: Site, martin: Person) -> None:
    made, own = create(site, martin), person(site)
    call(site, own, "POST", f"{API}/join", 200, json={"code": made["join_code"]})
    roster(site, martin, made, "nom,prenom\nLovelace,Ada\nTuring,Alan\n")
    part = "Prénom 1;Nom de famille*;Bourse\nGrace;Hopper;oui\n"
    told = roster(site, martin, made, part)
    assert (told["added"], told["left"], told["leaving"], told["not_in_list"]) == (1, 0, [], 3)
    assert told["ignored_columns"] == ["Bourse"]
    assert told["columns"] == [
        {"column": "Prénom 1", "read_as": "prenom"},
        {"column": "Nom de famille*", "read_as": "nom"},
        {"column": "Bourse", "read_as": None},
    ]
    told = roster(site, martin, made, part, query="?mode=replace&dry_run=true")
    assert told["left"] == len(told["leaving"]) == 3
    assert sorted((one["name"], one["joined_by_code"]) for one in told["leaving"]) == [
        ("Ada", True), ("Ada Lovelace", False), ("Alan Turing", False),
    ]  # fmt: skip
    assert len(call(site, martin, "GET", f"{made['url']}/students", 200)) == 4
    roster(site, martin, made, part, 422, query="?mode=zut")


def test_a_list_of_several_classes_fills_those_of_its_teacher(site: Site, martin: Person) -> None:
    here, there = create(site, martin, "MPSI 1"), create(site, martin, "PCSI")
    other = create(site, person(site, Role.teacher, "M. Durand"), "PSI")
    listed = "Classe;Nom;Prénom\nMPSI1;Lovelace;Ada\npcsi;Turing;Alan\nPSI;Hopper;Grace\n"
    told = roster(site, martin, here, listed)
    assert (told["added"], told["rejected"]) == (1, [])
    assert [(one["id"], one["name"], one["added"]) for one in told["classes"]] == [(there["id"], "PCSI", 1)]
    assert "1 ligne de « PSI »" in told["warnings"][0]
    for made, name in ((here, "Ada Lovelace"), (there, "Alan Turing")):
        assert [one["name"] for one in call(site, martin, "GET", f"{made['url']}/students", 200)] == [name]
    with site.database.read() as db:
        assert len(db.query(SchoolClass).all()) == 3, "a class is never made by a list"
        assert not db.query(Membership).filter_by(class_id=UUID(other["id"]), role=ClassRole.student).all()
    told = roster(site, martin, here, listed, query="?class=PSI&only_here=true")
    assert (told["added"], told["classes"]) == (1, [])
    told = roster(site, martin, here, listed, query="?class=*&dry_run=true")
    assert (told["unchanged"], told["added"]) == (2, 1)
    assert "nulle part « 5B »" in roster(site, martin, here, listed, 422, query="?class=5B")["detail"]
    told = roster(site, martin, create(site, martin, "Option robotique"), "Division;Nom\nTB1;Noether\nTB2;Germain\n")
    assert (told["added"], "TB1" in told["warnings"][0]) == (2, True)


def test_columns_that_are_in_doubt_are_asked_and_said_by_hand(site: Site, martin: Person) -> None:
    made = create(site, martin)
    content = "Kind;Vorname\nLovelace;Ada\n"
    assert "?columns=nom,prenom" in roster(site, martin, made, content, 422)["detail"]
    told = roster(site, martin, made, content, query="?columns=nom,prenom&first_line=2")
    assert (told["added"], told["rejected"]) == (1, [])
    mac = "nom;prenom\nLegué;Chloé\n".encode("mac_roman")
    told = roster(site, martin, made, mac)
    assert (told["added"], told["encoding"]) == (1, "mac_roman")
    students = call(site, martin, "GET", f"{made['url']}/students", 200)
    assert [one["name"] for one in students] == ["Chloé Legué", "Ada Lovelace"]
    roster(site, martin, made, mac, 422, query="?encoding=zut")
