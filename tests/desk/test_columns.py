"""The pages of a teacher's own columns: typed, pasted, refused without loss, by two at once, published, undone."""

from __future__ import annotations

import re
from html import unescape
from uuid import UUID

import pytest

from server.identity.models import Account, Role
from server.marks.models import ManualColumn, ManualMark, MarkingPolicy
from tests.support.classes import Person, person, seat
from tests.support.client import TestClient
from tests.support.marks import POSES, Term
from tests.support.service import Site


@pytest.fixture
def term(site: Site) -> Term:
    return Term.begin(site.database)


@pytest.fixture
def martin(site: Site, term: Term) -> TestClient:
    return person(site, account=term.teacher).browser(site)


@pytest.fixture
def href(term: Term) -> str:
    return f"/classes/{term.made.id}/carnet"


def text_of(browser: TestClient, path: str, status: int = 200) -> str:
    answer = browser.get(path)
    assert answer.status_code == status, answer.text
    return re.sub(r"\s+", " ", unescape(answer.text))


def column_path(martin: TestClient, href: str, **fields: str) -> str:
    made = martin.post(f"{href}/colonnes", data={"titre": "Oral <b>", "sur": "10", "coefficient": "2", **fields})
    assert made.status_code == 303, made.text
    return str(made.headers["location"])


def fields_of(browser: TestClient, path: str) -> dict[str, str]:
    """The fields of the form of marks, as a browser would send them."""
    form = re.search(r'class="column-form">(.*?)</form>', browser.get(path).text, re.DOTALL)
    assert form
    tags = re.findall(r"<input[^>]*>", form[1])
    pairs = [(re.search(r'name="([^"]+)"', tag), re.search(r'value="([^"]*)"', tag)) for tag in tags]
    return {unescape(name[1]): unescape(value[1]) for name, value in pairs if name and value}


def stored(site: Site) -> dict[UUID, tuple[float | None, str | None, str]]:
    with site.database.read() as db:
        return {mark.account_id: (mark.points, mark.state, mark.comment) for mark in db.query(ManualMark)}


def pupils(term: Term) -> tuple[Account, Account]:
    return term.student("Ada", "Lovelace"), term.student("Alan", "Turing")


def test_marks_are_typed_shown_and_published(site: Site, term: Term, martin: TestClient, href: str) -> None:
    ada, alan = pupils(term)
    path = column_path(martin, href)
    saved = martin.post(path, data={f"n-{ada.id}": "7,5", f"r-{ada.id}": "très <i>clair", f"n-{alan.id}": "abs"})
    assert saved.headers["location"] == f"{path}?fait=1"
    assert stored(site) == {ada.id: (7.5, None, "très <i>clair"), alan.id: (None, "absent", "")}
    raw = martin.get(path).text
    assert "<i>clair" not in raw
    assert "Oral <b>" not in raw
    book = text_of(martin, href)
    assert "Oral <b> /10" in book
    assert ">7,5</a>" in book
    assert ">absent</a>" in book
    own = person(site, account=ada).browser(site)
    assert "très <i>clair" not in text_of(own, f"/classes/{term.made.id}")
    assert martin.post(path, data={"action": "publier"}).status_code == 303
    page = text_of(own, f"/classes/{term.made.id}")
    assert "7,5 / 10" in page
    assert "très <i>clair" in page
    assert "Pourquoi cette moyenne" in page
    assert "15 / 20" in page
    explained = text_of(martin, f"{href}/{ada.id}")
    assert "Moyenne = Σ (coefficient × note)" in explained
    martin.post(path, data={"action": "cacher"})
    assert "7,5 / 10" not in text_of(own, f"/classes/{term.made.id}")


def test_nothing_typed_is_lost_where_a_cell_is_refused(site: Site, term: Term, martin: TestClient, href: str) -> None:
    ada, alan = pupils(term)
    path = column_path(martin, href)
    refused = martin.post(path, data={f"n-{ada.id}": "quinze<", f"n-{alan.id}": "6", f"r-{alan.id}": "bien"})
    assert refused.status_code == 422
    page = unescape(refused.text)
    assert "« quinze< » n’est pas une note de 0 à 10" in page
    assert "quinze&lt;" in refused.text
    assert 'value="6"' in page
    assert 'value="bien"' in page
    assert stored(site) == {}


def test_a_column_is_pasted_and_read_again_before_it_is_saved(
    site: Site, term: Term, martin: TestClient, href: str
) -> None:
    ada, alan = pupils(term)
    path = column_path(martin, href)
    pasted = martin.post(path, data={"action": "coller", "collage": "8,25\r\nabs\r\n"})
    assert pasted.status_code == 200
    assert "2 lignes collées" in pasted.text
    assert stored(site) == {}
    cells = dict(re.findall(r'name="(n-[^"]+)" type="text" value="([^"]*)"', pasted.text))
    assert cells == {f"n-{ada.id}": "8,25", f"n-{alan.id}": "abs"}
    martin.post(path, data=cells)
    assert stored(site)[ada.id][0] == 8.25
    assert martin.post(path, data={"action": "coller", "collage": "1\n2\n3"}).status_code == 422
    assert "15" in martin.post(path, data={"action": "coller", "collage": "15"}).text
    assert stored(site)[ada.id][0] == 8.25


def test_two_teachers_who_type_at_once_are_told(site: Site, term: Term, martin: TestClient, href: str) -> None:
    ada, alan = pupils(term)
    roy = person(site, Role.teacher, "M. Roy")
    seat(site.database, term.made, roy.account, "teacher")
    path = column_path(martin, href)
    hers, his = fields_of(martin, path), fields_of(roy.browser(site), path)
    assert martin.post(path, data={**hers, f"n-{ada.id}": "8"}).status_code == 303
    other = roy.browser(site).post(path, data={**his, f"n-{alan.id}": "6"})
    assert other.status_code == 303, "another student's mark is no conflict"
    assert {mark[0] for mark in stored(site).values()} == {8.0, 6.0}
    clash = roy.browser(site).post(path, data={**his, f"n-{ada.id}": "3"})
    assert clash.status_code == 409
    assert all(said in clash.text for said in ("Ada Lovelace", ">8</td>", ">3</td>"))
    assert stored(site)[ada.id][0] == 8.0
    again = dict(re.findall(r'<input type="hidden" name="([^"]+)" value="([^"]*)">', clash.text))
    assert roy.browser(site).post(path, data=again).status_code == 303
    assert stored(site)[ada.id][0] == 3.0
    assert stored(site)[alan.id][0] == 6.0


def test_a_column_is_set_moved_deleted_and_restored(site: Site, term: Term, martin: TestClient, href: str) -> None:
    pupils(term)
    first, second = column_path(martin, href, titre="Premier"), column_path(martin, href, titre="Second")
    listing = f"{href}/colonnes"
    assert martin.post(second, data={"action": "avant"}).headers["location"] == listing
    page = text_of(martin, listing)
    assert page.index("Second") < page.index("Premier")
    settings = {"action": "regler", "titre": "Exposé", "sur": "20", "date": "2026-03-16", "coefficient": "0,5"}
    assert martin.post(first, data=settings).status_code == 303
    assert "16/03/2026" in text_of(martin, first)
    stale = martin.post(first, data={**settings, "titre": "Autre", "version": "vieille"})
    assert stale.status_code == 409
    assert "Exposé" in stale.text
    wrong = martin.post(first, data={**settings, "sur": "beaucoup", "coefficient": "-1", "date": "hier"})
    assert wrong.status_code == 422
    assert 'value="beaucoup"' in wrong.text
    assert martin.post(f"{listing}", data={"titre": " "}).status_code == 422
    assert martin.post(first, data={"action": "supprimer"}).status_code == 303
    assert "Exposé" not in text_of(martin, href)
    assert "Rétablir" in text_of(martin, listing)
    assert martin.post(first, data={"action": "retablir"}).status_code == 303
    assert "Exposé" in text_of(martin, href)
    assert martin.post(first, data={"action": "zut"}).status_code == 404
    text_of(martin, f"{listing}/zut", 404)
    log = text_of(martin, f"/classes/{term.made.id}/journal")
    assert all(word in log for word in ("colonne créée", "colonne modifiée", "colonne supprimée", "colonne rétablie"))


def test_assistants_read_columns_and_type_nothing(site: Site, term: Term, martin: TestClient, href: str) -> None:
    ada, _ = pupils(term)
    path = column_path(martin, href)
    martin.post(path, data={f"n-{ada.id}": "7"})
    helper: Person = person(site)
    seat(site.database, term.made, helper.account, "assistant")
    shown = text_of(helper.browser(site), path)
    assert ">7</td>" in shown
    assert 'name="n-' not in shown
    assert helper.browser(site).post(path, data={f"n-{ada.id}": "9"}).status_code == 403
    own = person(site, account=ada).browser(site)
    assert own.get(path).status_code == 403


def test_the_gradebook_of_an_older_class_says_what_counts(
    site: Site, term: Term, martin: TestClient, href: str
) -> None:
    term.assignment(exercises={POSES: 1.0})
    ada, _ = pupils(term)
    with site.database.write() as db:
        rules = dict.fromkeys(("not_handed_in", "late_refused", "absent", "unanswered"), "zero")
        db.add(MarkingPolicy(class_id=term.made.id, **rules))
    told = "ce qui n’est pas rendu compte encore 0"
    assert told in text_of(martin, href)
    assert "(compte 0)" in text_of(martin, href)
    settings = f"/classes/{term.made.id}/reglages"
    choice = {"non_rendu": "ignore", "retard": "ignore", "absence": "zero", "sans_reponse": "zero"}
    assert martin.post(f"{settings}/moyenne", data={**choice, "absence": "zut"}).status_code == 422
    assert martin.post(f"{settings}/moyenne", data={**choice, "version": "1"}).status_code == 303
    assert told not in text_of(martin, href)
    assert martin.post(f"{settings}/moyenne", data={**choice, "version": "1"}).status_code == 409
    path = f"{href}/{ada.id}/"
    with site.database.read() as db:
        assert db.query(ManualColumn).all() == []
    given = re.search(rf"{path}([0-9a-f-]+)\"", martin.get(href).text)
    assert given
    assert (
        martin.post(f"{path}{given[1]}", data={"action": "decider", "etat": "absent", "motif": "3 mars"}).status_code
        == 303
    )
    assert ">absent</a>" in text_of(martin, href)
    own = text_of(person(site, account=ada).browser(site), f"/classes/{term.made.id}")
    assert "Votre enseignant vous a marqué absent. 3 mars" in own
    assert "absent (compte 0 dans la moyenne)" in own
    assert martin.post(f"{path}{given[1]}", data={"action": "decider", "etat": "malade"}).status_code == 422
    assert martin.post(f"{path}{given[1]}", data={"action": "annuler"}).status_code == 303
    assert ">non rendu</a>" in text_of(martin, href)
