"""The guide for teachers: its steps are followed in the service, in the order of its chapters."""

from __future__ import annotations

import html
import re
from urllib.parse import parse_qsl

import pytest
from sqlalchemy import select

from server.desk.guide.chapters import CHAPTERS_OF_TABS, FOLDER, TITLES, chapter_href
from server.desk.tabs import STAFF_TABS
from server.identity.models import Account, Role
from tests.support.classes import new_class, person, seat
from tests.support.client import TestClient
from tests.support.service import EXERCISE, Site

#: A step, or words that the page of the last step shows.
TOKEN = re.compile(r"<!-- (voir|faire|valider) ?(.*?) -->|\*\*(.+?)\*\*", re.DOTALL)


def plain(text: str) -> str:
    return " ".join(html.unescape(text).replace("\u00a0", " ").replace("\u202f", " ").split())


def shown(page: str) -> str:
    return plain(re.sub(r"<[^>]*>", " ", re.sub(r"<(script|style)\b.*?</\1>", " ", page, flags=re.DOTALL)))


class Follower:
    """Somebody who does what the guide says: what it names before a step is on the page where the step leads to, or
    was done."""

    def __init__(self, client: TestClient) -> None:
        self.client, self.places, self.page = client, dict[str, str](), ""
        self.places["exercices"] = f"exercice={EXERCISE}"
        self.places["exercices_seance"] = f"exercice={EXERCISE}"
        self.named: list[str] = []

    def follow(self, chapter: str) -> int:
        """Follow a chapter, and return how many steps it had."""
        steps = 0
        self.named = []
        for step, argument, words in TOKEN.findall((FOLDER / f"{chapter}.md").read_text(encoding="utf-8")):
            if words:
                self.named.append(plain(words))
                continue
            steps += 1
            where = argument
            for name, place in self.places.items():
                where = where.replace(f"{{{name}}}", place)
            getattr(self, f"_{step}")(where)
        self._check(self.page)
        return steps

    def _check(self, page: str) -> None:
        """What was named since the last step is there: on the page before, or on this one."""
        both = shown(self.page) + shown(page)
        missing = [words for words in self.named if words.casefold() not in both.casefold()]
        assert not missing, missing
        self.named = []

    def _voir(self, path: str) -> None:
        answer = self.client.get(path, follow_redirects=True)
        assert answer.status_code == 200, (path, answer.status_code)
        self._check(answer.text)
        self.page = answer.text

    def _faire(self, argument: str) -> None:
        path, _, fields = argument.partition(" ")
        data: dict[str, list[str]] = {}
        for name, value in parse_qsl(fields):
            data.setdefault(name, []).append(value)
        answer = self.client.post(path, data=data)
        assert answer.status_code in {200, 303}, (path, answer.text)
        where = answer.headers.get("location", "")
        if found := re.match(r"/mes-exercices/[0-9a-f-]{36}", where):
            self.places["exercice"] = found[0]
        if found := re.fullmatch(r"/classes/[0-9a-f-]{36}", where):
            self.places["classe"] = found[0]
        if found := re.fullmatch(r"/classes/[0-9a-f-]{36}/devoirs/[0-9a-f-]{36}", where):
            self.places["devoir"] = found[0]
        page = answer.text or self.client.get(where, follow_redirects=True).text
        self._check(page)
        self.page = page

    def _valider(self, button: str) -> None:
        assert plain(button) in shown(self.page), button
        action = f"{self.places['classe']}/liste"
        text = re.search(r"<textarea[^>]*name=\"texte\"[^>]*>(.*?)</textarea>", self.page, re.DOTALL)
        digest = re.search(r'name="attendu" value="([^"]*)"', self.page)
        assert text is not None
        assert digest is not None
        self._check(self.page)
        self.client.post(action, data={"texte": html.unescape(text[1]).strip(), "attendu": digest[1]})
        self.page = self.client.get(f"{self.places['classe']}/eleves").text
        assert "Lovelace" in self.page


def test_the_steps_of_the_guide_lead_where_it_says(site: Site) -> None:
    follower = Follower(person(site, Role.teacher, "Claire").browser(site))
    steps = {}
    for chapter in TITLES:
        steps[chapter] = follower.follow(chapter)
        if chapter == "commencer":  # there is something to mark
            with site.database.read() as db:
                ada = db.execute(select(Account).where(Account.name.contains("Lovelace"))).scalar_one()
            site.submit(person(site, account=ada).headers)
    assert all(steps.values()), steps


@pytest.mark.parametrize("chapter", ["", *TITLES])
def test_each_chapter_is_read_by_anybody(site: Site, chapter: str) -> None:
    page = site.client.get(f"/enseignants/{chapter}".rstrip("/"))
    assert page.status_code == 200
    assert "&lt;!--" not in page.text
    assert "**" not in page.text
    for slug in re.findall(r'href="/enseignants/(\w+)"', page.text):
        assert slug in TITLES


def test_each_page_of_a_class_leads_to_the_chapter_about_it(site: Site) -> None:
    assert {path for _, _, path in STAFF_TABS} == set(CHAPTERS_OF_TABS)
    assert site.client.get("/enseignants/ailleurs").status_code == 404
    teacher = person(site, Role.teacher, "Claire")
    made = new_class(site.database, teacher.account)
    for _, _, path in STAFF_TABS:
        page = teacher.browser(site).get(f"/classes/{made.id}{path}", follow_redirects=True)
        assert f'href="{chapter_href(path)}"' in page.text, path


def test_students_are_found_by_any_part_of_their_name_and_shown_by_pages(site: Site) -> None:
    teacher = person(site, Role.teacher, "Claire")
    made = new_class(site.database, teacher.account)
    names = [f"Élève {number:02d}" for number in range(21)]
    for name in names:
        seat(site.database, made, person(site, name=name).account, groups=["TP1"] if name.endswith("7") else [])
    browser, home = teacher.browser(site), f"/classes/{made.id}/eleves"

    def found(query: str) -> list[str]:
        page = browser.get(f"{home}{query}").text
        return [name for name in names if f">{name}<" in page]

    assert found("") == names[:18]
    assert found("?page=2") == names[18:]
    assert found("?q=ELEVE+03") == [names[3]]
    assert found("?q=tp1") == found("?groupe=TP1") == names[7::10]
    assert "Aucun élève ne correspond" in browser.get(f"{home}?q=personne").text
