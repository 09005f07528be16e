"""The gradebook's pages: the table, one mark and what is set in its place, copies, the log."""

from __future__ import annotations

import csv
import io
import json
import re
import zipfile
from html import unescape
from uuid import uuid4

import pytest

from server.assignments.models import TeamMember
from server.audit import service as audit
from server.audit.models import AuditAction, AuditEvent
from server.marks.models import Override
from server.rights.models import Right
from tests.support.caches import clear_caches
from tests.support.classes import person, seat
from tests.support.client import TestClient
from tests.support.counting import Counted
from tests.support.marks import AFTER, DUE, ODOMETRY, OPENS, POSES, Term
from tests.support.service import Site


@pytest.fixture
def term(site: Site) -> Term:
    return Term.begin(site.database)


@pytest.fixture
def martin(site: Site, term: Term) -> TestClient:
    return person(site, account=term.teacher).browser(site)


@pytest.fixture
def href(term: Term) -> str:
    return f"/classes/{term.made.id}"


def text_of(browser: TestClient, path: str, status: int = 200) -> str:
    answer = browser.get(path)
    assert answer.status_code == status, answer.text
    return re.sub(r"\s+", " ", unescape(answer.text))


def names_in(page: str) -> list[str]:
    return re.findall(r'<th scope="row">(.+?)</th>', page)


def test_the_table_is_sorted_filtered_and_escaped(
    term: Term, martin: TestClient, href: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = term.assignment("DM <b>", {POSES: 1.0})
    ada = term.student("Ada", "Lovelace", groups=["TP1"])
    alan = term.student("Alan", "<i>Turing", groups=["TP2"])
    term.student("Grace", "Hopper", groups=["TP1"])
    term.send(ada, POSES, 8)
    term.send(alan, POSES, 12.5, DUE + (AFTER - DUE) / 7)
    raw = martin.get(f"{href}/carnet").text
    assert "<i>Turing" not in raw
    assert "DM &lt;b&gt;" in raw
    page = text_of(martin, f"{href}/carnet")
    assert names_in(page)[:3] == ["Grace Hopper", "Alan <i>Turing", "Ada Lovelace"]
    assert "+2 j" in page
    assert ">non rendu</a>" in page
    by_mark = text_of(martin, f"{href}/carnet?tri={given.id}")
    assert names_in(by_mark)[:3] == ["Alan <i>Turing", "Ada Lovelace", "Grace Hopper"]
    group = text_of(martin, f"{href}/carnet?groupe=TP1&colonne={given.id}")
    assert names_in(group)[:2] == ["Grace Hopper", "Ada Lovelace"]
    assert "non rendu 8</textarea>" in group
    detail = text_of(martin, f"{href}/carnet?devoir={given.id}&tri=l20/poses")
    assert "Note du devoir" in detail
    assert names_in(detail)[0] == "Alan <i>Turing"
    text_of(martin, f"{href}/carnet?devoir=zut", 404)
    assert "MPSI" in text_of(martin, f"{href}/carnet?tri=zut&groupe=zut&colonne=zut")
    monkeypatch.setattr("server.desk.marks.views.STUDENTS_PER_PAGE", 2)
    assert names_in(text_of(martin, f"{href}/carnet?tri=moyenne&p=2"))[0] == "Grace Hopper"
    assert names_in(text_of(martin, f"{href}/carnet?p=99"))[0] == "Ada Lovelace", "the last page there is"
    copied = re.search(r"readonly[^>]*>(.*?)</textarea>", text_of(martin, f"{href}/carnet?colonne=moyenne"))
    assert copied
    assert copied[1].split() == ["12,5", "8"], "of all pages, in the order of the list"


def test_a_mark_is_set_kept_and_withdrawn(site: Site, term: Term, martin: TestClient, href: str) -> None:
    given = term.assignment("DM 1", {POSES: 1.0})
    ada = term.student("Ada", "Lovelace")
    term.send(ada, POSES, 8)
    path = f"{href}/carnet/{ada.id}/{given.id}"
    assert "/soumissions/" in text_of(martin, path)
    form = {"exercice": POSES, "motif": "revu <ensemble>", "points": "quinze"}
    refused = martin.post(path, data={**form, "action": "noter"})
    assert refused.status_code == 422
    assert "« quinze » n’est pas un nombre" in refused.text
    assert "revu &lt;ensemble&gt;" in refused.text, "nothing that was written is lost"
    done = martin.post(path, data={**form, "action": "noter", "points": " 15,5 "})
    assert (done.status_code, done.headers["location"]) == (303, f"{path}#poses")
    shown = text_of(martin, path)
    assert "revu <ensemble>" in shown
    assert "15,5 / 20" in shown
    assert "✎" in text_of(martin, f"{href}/carnet")
    term.send(ada, POSES, 9)
    assert "à revoir</span> Depuis" in text_of(martin, path)
    assert martin.post(path, data={"exercice": POSES, "action": "garder"}).status_code == 303
    assert "à revoir</span> Depuis" not in text_of(martin, path)
    assert martin.post(path, data={**form, "action": "dispenser"}).status_code == 303
    assert ">dispensé</a>" in text_of(martin, f"{href}/carnet")
    assert martin.post(path, data={"exercice": POSES, "action": "retirer"}).status_code == 303
    assert martin.post(path, data={"exercice": POSES, "action": "garder"}).status_code == 404
    assert martin.post(path, data={**form, "action": "zut"}).status_code == 404
    with site.database.read() as db:
        assert [one.points for one in db.query(Override).order_by(Override.at)] == [15.5, 15.5, None]
    log = text_of(martin, f"{href}/journal")
    assert "4 changements" in log
    for told in ("15,5", "note modifiée retirée", "revu <ensemble>", "dispense"):
        assert told in log
    helper = person(site)
    seat(site.database, term.made, helper.account, "assistant")  # type: ignore[arg-type]
    assert 'name="action"' not in text_of(helper.browser(site), path)
    assert Right.change_marks.value in helper.browser(site).post(path, data=form).text


def test_a_mark_that_another_teacher_has_set_meanwhile_is_told(term: Term, martin: TestClient, href: str) -> None:
    given, ada = term.assignment("DM 1", {POSES: 1.0}), term.student("Ada", "Lovelace")
    path = f"{href}/carnet/{ada.id}/{given.id}"
    drawn = re.search(r'name="version" value="([^"]+)"', martin.get(path).text)
    assert drawn
    typed = {"exercice": POSES, "action": "noter", "motif": "oral", "version": drawn[1]}
    assert martin.post(path, data={**typed, "points": "15"}).status_code == 303
    late = martin.post(path, data={**typed, "points": "9", "motif": "revu"})
    assert late.status_code == 409
    assert all(text in unescape(late.text) for text in ("15, dans ce devoir", "9 revu", "Enregistrer ma version"))
    assert "15 / 20" in text_of(martin, path)
    decided = martin.post(path, data={"action": "decider", "etat": "absent", "version": drawn[1]})
    assert decided.status_code == 409
    fields = dict(re.findall(r'<input type="hidden" name="([^"]+)" value="([^"]*)">', late.text))
    assert martin.post(path, data=fields).status_code == 303
    assert "9 / 20" in text_of(martin, path)


def test_a_mark_holds_where_the_teacher_says(term: Term, martin: TestClient, href: str) -> None:
    first, second = (term.assignment(title, {POSES: 1.0}) for title in ("DM 1", "DM 2"))
    ada = term.student("Ada", "Lovelace")
    path, other = (f"{href}/carnet/{ada.id}/{assignment.id}" for assignment in (first, second))
    form = {"exercice": POSES, "action": "noter", "motif": "oral", "points": "15"}
    assert "aussi « DM 2 »" in text_of(martin, path)
    martin.post(path, data=form)
    assert "dans ce devoir seulement, par" in text_of(martin, path)
    assert "15 / 20" not in text_of(martin, other)
    martin.post(path, data={**form, "points": "11", "portee": "partout"})
    assert "dans tous les devoirs, par" in text_of(martin, other)
    assert "15 / 20" in text_of(martin, path), "that of the assignment takes precedence there"
    log = text_of(martin, f"{href}/journal")
    assert "dans tous les devoirs" in log
    assert "dans le devoir « DM 1 » seulement" in log
    martin.post(path, data={"exercice": POSES, "action": "retirer"})
    assert "11 / 20" in text_of(martin, path)
    martin.post(other, data={"exercice": POSES, "action": "retirer", "portee": "partout"})
    assert "11 / 20" not in text_of(martin, path)


def copies_of(martin: TestClient, path: str) -> tuple[zipfile.ZipFile, list[list[str]]]:
    answer = martin.get(path)
    assert answer.status_code == 200
    assert re.search(r'filename="balise-mpsi-2-copies-[\d-]+\.zip"', answer.headers["content-disposition"])
    archive = zipfile.ZipFile(io.BytesIO(answer.content))
    assert archive.testzip() is None
    index = archive.read("index.csv").decode("utf-8-sig")
    return archive, list(csv.reader(io.StringIO(index, newline=""), delimiter=";"))[1:]


def test_the_index_of_copies_says_with_whom_each_is_handed_in(term: Term, martin: TestClient, href: str) -> None:
    together = term.assignment("DM à deux", {POSES: 1.0}, team_size=2)
    ada, bob, team = term.student("Ada", "Lovelace"), term.student("Bob", "Petit"), uuid4()
    with term.database.write() as db:
        rows = {"assignment_id": together.id, "team_id": team, "since": OPENS}
        db.add_all(TeamMember(account_id=account.id, **rows) for account in (ada, bob))
    term.send(ada, POSES, 12)
    _, index = copies_of(martin, f"{href}/carnet/copies?noms=true")
    assert {(row[3], row[8]) for row in index} == {("Lovelace Ada", "Bob Petit"), ("Petit Bob", "Ada Lovelace")}
    _, index = copies_of(martin, f"{href}/carnet/copies")
    assert {row[8] for row in index} == {""}, "pseudonyms are not given away"


def test_archive_of_copies_with_names_or_pseudonyms(term: Term, martin: TestClient, href: str) -> None:
    first = term.assignment("../DM", {POSES: 1.0, ODOMETRY: 1.0})
    term.assignment("DM 2", {POSES: 1.0}, counts="last")
    twins = [term.student("Ada", "Lovelace") for _ in range(2)]
    for points, one in zip((3.0, 5.0), twins, strict=True):
        term.send(one, POSES, points)
        term.send(one, POSES, 1.0, DUE)
    term.send(twins[0], ODOMETRY, 20)
    archive, index = copies_of(martin, f"{href}/carnet/copies?noms=true&devoir={first.id}")
    assert {row[0] for row in index} | {"index.csv"} == set(archive.namelist())
    twin = (3.0, 5.0) if twins[0].id.hex < twins[1].id.hex else (5.0, 3.0)  # of one name, in the order of their ids
    read = {(row[0], archive.read(row[0]).decode(), row[3], row[5]) for row in index}
    assert read == {
        ("dm/poses/lovelace-ada.py", f"# {twin[0]}\n", "Lovelace Ada", f"{twin[0]:g}"),
        ("dm/poses/lovelace-ada-2.py", f"# {twin[1]}\n", "Lovelace Ada", f"{twin[1]:g}"),
        ("dm/calcul_odometrie/" + ("lovelace-ada" if twin[0] == 3 else "lovelace-ada-2") + ".json", "# 20\n",
         "Lovelace Ada", "20"),
    }  # fmt: skip
    archive, index = copies_of(martin, f"{href}/carnet/copies")
    assert len(index) == 5
    assert not any("ovelace" in cell or "2026" in cell for row in index for cell in row)
    assert {row[3] for row in index} == {"eleve-1", "eleve-2"}
    assert all(f"/{row[3]}." in row[0] and archive.read(row[0]) for row in index)
    by_points = {row[3]: row[5] for row in index if row[0].startswith("dm/poses")}
    assert sorted(by_points.values()) == ["3", "5"], "the same pseudonym all through"
    for unknown in ("zut", str(twins[0].id)):
        assert martin.get(f"{href}/carnet/copies?devoir={unknown}").status_code == 404
    last = {archive.read(row[0]).decode() for row in index if row[0].startswith("dm-2/")}
    assert last == {"# 1.0\n"}


def test_the_page_asks_no_more_for_a_bigger_class(site: Site, term: Term, martin: TestClient, href: str) -> None:
    def statements(path: str) -> int:
        with Counted(site.database) as counted:
            text_of(martin, path)
        return len(counted.statements)

    given = term.assignment()
    term.send(term.student("Ada", "Lovelace", groups=["TP1"]), POSES, 3)
    paths = [f"{href}/carnet", f"{href}/carnet?devoir={given.id}", f"{href}/journal"]
    text_of(martin, paths[0])  # that they were there is noted
    clear_caches()
    few = [statements(path) for path in paths for _ in range(2)]
    for number in range(3):
        term.assignment(f"DM {number}")
        term.send(term.student("Ada", f"n° {number}"), POSES, 4)
        with site.database.write() as db:
            audit.record_event(db, term.made.id, term.teacher.id, AuditAction.staff_changed, about=str(number))
    clear_caches()
    again = [statements(path) for path in paths for _ in range(2)]
    assert again == few
    assert again[0] > again[1], "of what has not changed, nothing more is asked"
    assert max(again) <= 14


def test_the_log_is_filtered_paged_and_downloaded(site: Site, term: Term, martin: TestClient, href: str) -> None:
    ada = term.student("Ada", "Lovelace")
    with site.database.write() as db:
        for number in range(103):
            audit.record_event(
                db, term.made.id, term.teacher.id, AuditAction.staff_changed, about=f"=n° {number}", reason="@x"
            )
        change = {"before": {"points": 3.5}, "after": {"points": None}}
        audit.record_event(
            db, term.made.id, term.teacher.id, AuditAction.mark_overridden, student=ada.id, about="Poses", **change
        )
    page = text_of(martin, f"{href}/journal")
    assert "104 changements, 1 à 18" in page
    older = re.search(r'rel="next" href="([^"]+)"', page)
    assert older
    assert "19 à 36" in text_of(martin, older[1])
    assert "Cette page est vide" in text_of(martin, f"{href}/journal?p=9")
    only = text_of(martin, f"{href}/journal?eleve={ada.id}&genre=zut")
    assert "1 changement," in only
    assert "3,5 → rien" in only
    assert "Aucun changement de ce genre" in text_of(martin, f"{href}/journal?genre=student_removed")
    answer = martin.get(f"{href}/journal/fichier")
    assert answer.headers["content-type"].startswith("text/csv")
    rows = list(csv.reader(io.StringIO(answer.content.decode("utf-8-sig"), newline=""), delimiter=";"))
    assert len(rows) == 105
    assert rows[1][1:] == ["Mme Martin", "note modifiée", "Ada Lovelace", "Poses", "points : 3,5 → rien", ""]
    assert rows[2][4:] == ["'=n° 102", "", "'@x"]
    events = json.loads(martin.get(f"{href}/journal/fichier?format=json&eleve={ada.id}").content)
    assert [(one["what"], one["before"]) for one in events] == [("mark_overridden", {"points": 3.5})]
    with site.database.write() as db:
        db.query(AuditEvent).delete()
    assert json.loads(martin.get(f"{href}/journal/fichier?format=json").content) == []
    assert "Rien n’a encore été changé" in text_of(martin, f"{href}/journal")
