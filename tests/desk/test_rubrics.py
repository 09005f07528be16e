"""Copies are marked by hand, kept while one types, without names if wanted, and published together."""

from __future__ import annotations

import html
import re
from typing import Any

import pytest

from server.assignments.models import Assignment
from server.base.errors import Invalid
from server.classes.models import SchoolClass
from server.identity.models import Role
from server.marks import rubrics, rubrics_repository
from server.marks.rubric_items import parse_rubric_item
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.service import EXERCISE, Site

FORM = {
    "titre": "Rédaction",
    "coefficient": "0,5",
    "c-0-titre": "Clarté",
    "c-0-points": "4",
    "c-0-mots": "4 : très clair\n2 : lisible\n0 : illisible",
    "c-1-titre": "Explications",
    "c-1-points": "6",
}


class Desk:
    """A class with an assignment that two of its three students have answered, and its rubric."""

    def __init__(self, site: Site, **rubric: str) -> None:
        self.site = site
        self.teacher = person(site, Role.teacher, "Claire")
        self.students = {name: person(site, name=name) for name in ("Ada", "Bob", "Zoé")}
        self.made: SchoolClass = new_class(site.database, self.teacher.account, "MPSI")
        for student in self.students.values():
            seat(site.database, self.made, student.account)
        self.td: Assignment = assign(site.database, self.made, EXERCISE, title="TD 1")
        for name in ("Ada", "Bob"):
            site.submit(self.students[name].headers, code=f"nom = '{name.lower()}'\n")
            assert site.worker.run_one()
        self.home = f"/classes/{self.made.id}/devoirs/{self.td.id}"
        assert self.teacher.browser(site).post(f"{self.home}/bareme", data=FORM | rubric).status_code == 303
        with site.database.read() as db:
            self.rubric, self.column = rubrics.require_rubric(db, self.td)
            self.items = [item.id for item in rubrics_repository.read_rubric_items(self.rubric)]

    def page(self, path: str = "", who: Person | None = None) -> str:
        answer = (who or self.teacher).browser(self.site).get(f"{self.home}/noter{path}")
        assert answer.status_code == 200, answer.text
        return plain(answer.text)

    def copy(self, name: str) -> str:
        return f"/{rubrics.anonymous_copy_key(self.rubric, self.students[name].id)}"

    def send(self, path: str, **fields: str) -> Any:
        return self.teacher.browser(self.site).post(f"{self.home}/noter{path}", data=fields)

    def mark(self, name: str, first: str, second: str, **fields: str) -> Any:
        given = {f"n-{self.items[0]}": first, f"p-{self.items[1]}": second, "action": "terminer", **fields}
        return self.send(self.copy(name), **given)

    def own_page(self, name: str, path: str = "") -> str:
        return plain(self.students[name].browser(self.site).get(f"/classes/{self.made.id}{path}").text)


def plain(page: str) -> str:
    """Without the spaces of French typography."""
    return html.unescape(page).replace("\u00a0", " ").replace("\u202f", " ")


def test_marks_join_the_gradebook_together_when_they_are_published(site: Site) -> None:
    desk = Desk(site)
    answer = desk.mark("Ada", "2", "5,5", remarque="Relisez la fin.")
    assert answer.headers["location"] == f"{desk.home}/noter{desk.copy('Bob')}", "the next copy that was sent"
    assert desk.mark("Bob", "4", "6").headers["location"] == f"{desk.home}/noter", "all that was sent is marked"
    book = f"/classes/{desk.made.id}/carnet"
    csv = f"{book}/fichier?format=csv"
    browser = desk.teacher.browser(site)
    assert "7,5" not in browser.get(csv).text, "nothing counts before it is published"
    assert "« Rédaction », pas encore publiée" in desk.own_page("Ada")
    assert "Relisez" not in desk.own_page("Ada", f"/devoirs/{desk.td.id}/copie")
    assert desk.send("", action="publier").status_code == 303
    assert "7,5" in browser.get(csv).text
    assert "7,5 / 10" in desk.own_page("Ada")
    copy = desk.own_page("Ada", f"/devoirs/{desk.td.id}/copie")
    for told in ("lisible", "2 / 4", "5,5 / 6", "7,5 / 10", "Relisez la fin."):
        assert told in copy
    assert "10 / 10" in desk.own_page("Bob", f"/devoirs/{desk.td.id}/copie")
    desk.mark("Ada", "4", "5,5")
    assert "9,5 / 10" in desk.own_page("Ada"), "a copy marked again counts at once"


def test_a_draft_is_kept_and_gives_no_mark(site: Site) -> None:
    desk = Desk(site)
    partial = {f"n-{desk.items[0]}": "2", f"r-{desk.items[1]}": "à revoir"}
    browser = desk.teacher.browser(site)
    answer = browser.post(
        f"{desk.home}/noter{desk.copy('Ada')}",
        data={**partial, "version": "0", "action": "brouillon"},
        headers={"Accept": "application/json"},
    )
    assert answer.json()["version"] == "1"
    page = desk.page(desk.copy("Ada"))
    assert re.search(r'value="2" checked', page)
    assert "à revoir" in page
    refused = desk.send(desk.copy("Ada"), **partial, action="terminer")
    assert refused.status_code == 422
    assert "Il manque : Explications" in refused.text
    assert "à revoir" in refused.text, "nothing typed is lost"
    desk.send("", action="publier")
    assert "/ 10" not in desk.own_page("Ada")


def test_two_markers_do_not_overwrite_each_other(site: Site) -> None:
    desk = Desk(site)
    desk.mark("Ada", "2", "3", version="0")
    refused = desk.mark("Ada", "4", "6", version="0")
    assert refused.status_code == 409
    assert "Enregistrer ma version" in refused.text
    assert desk.mark("Ada", "4", "6", version="1").status_code == 303


def test_names_are_hidden_until_publication(site: Site) -> None:
    desk = Desk(site, anonyme="oui")
    for path in ("", desk.copy("Ada"), desk.copy("Bob")):
        page = desk.page(path)
        assert not re.search(r"\bAda\b|\bBob\b", page), path
    desk.mark("Ada", "2", "3")
    desk.send("", action="publier")
    page = desk.page()
    assert page.index("Ada</a>") < page.index("Bob</a>") < page.index("Zoé</a>")


def test_a_criterion_in_use_keeps_the_points_that_were_given(site: Site) -> None:
    desk = Desk(site)
    desk.mark("Ada", "4", "5")
    browser = desk.teacher.browser(site)
    ids = {f"c-{number}-id": item for number, item in enumerate(desk.items)}
    lowered = browser.post(f"{desk.home}/bareme", data={**FORM, **ids, "c-1-points": "4"})
    assert lowered.status_code == 422
    assert "« Explications » a déjà des points" in lowered.text
    renamed = browser.post(f"{desk.home}/bareme", data={**FORM, **ids, "c-1-titre": "Raisons", "c-1-points": "8"})
    assert renamed.status_code == 303
    assert "9 / 12" in desk.page()


@pytest.mark.parametrize(
    ("points", "words", "problem"),
    [
        ("", "", "donnez des points"),
        ("0", "", "donnez des points"),
        ("4", "très clair", "« très clair »"),
        ("4", "5 : trop", "plus de points"),
        ("4", "\n".join(["1 : a"] * 11), "10 lignes"),
        ("4", "2 : a\n2 : b", "deux fois"),
    ],
)
def test_a_wrong_criterion_is_told_with_its_line(points: str, words: str, problem: str) -> None:
    with pytest.raises(Invalid, match=problem):
        parse_rubric_item("", "Clarté", points, words)


def test_a_rubric_needs_a_criterion_and_says_so(site: Site) -> None:
    desk = Desk(site)
    browser = desk.teacher.browser(site)
    assert "au moins un critère" not in browser.get(f"{desk.home}/bareme").text
    empty = browser.post(f"{desk.home}/bareme", data={"titre": "Rédaction"})
    assert (empty.status_code, "au moins un critère" in empty.text) == (422, True)


def test_a_copy_has_what_counts_and_no_more(site: Site) -> None:
    desk = Desk(site)
    copy = desk.teacher.browser(site).get(f"{desk.home}/copies/{desk.students['Ada'].id}")
    assert "ada" in copy.text
    assert "plus bas" not in copy.text, "a copy has no solution below it"
    assert desk.students["Bob"].browser(site).get(f"{desk.home}/copies/{desk.students['Ada'].id}").status_code == 403
    assert "Aucun essai retenu" in desk.own_page("Zoé", f"/devoirs/{desk.td.id}/copie")
