"""Comments and questions on the pages: forms without script, what is told to whom, what hostile text does to them."""

from __future__ import annotations

import html
import re
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

import pytest

from server.classes.models import ClassRole, SchoolClass
from server.comments import notes
from server.identity.models import Role
from server.pages import comments
from tests.support.classes import Person, new_class, person, seat
from tests.support.client import TestClient
from tests.support.counting import Counted
from tests.support.service import EXERCISE, Site

PAGE = f"/l20/exercices/{EXERCISE.partition('/')[2]}"
CODE = "import numpy\n\ndef f(x):\n    return x + 1  # outcome: wrong_answer\n"
HOSTILE = '<script>alert(1)</script> <img src=x onerror="alert(2)"> [x](javascript:alert(3)) {{ 7*7 }} \u202e'


@dataclass
class School:
    site: Site
    made: SchoolClass
    ada: Person
    teacher: Person
    other: Person

    def __post_init__(self) -> None:
        self.student, self.staff = self.ada.browser(self.site), self.teacher.browser(self.site)

    def send(self, code: str = CODE) -> str:
        """The address of the attempt's page."""
        answer = self.student.post(f"{PAGE}/soumissions", data={"code": code})
        assert self.site.worker.run_one()
        return str(answer.headers["location"])

    def say(self, browser: TestClient, page: str, status: int = 303, **fields: str) -> str:
        """Where the thread stands, or the page on which it was refused."""
        answer = browser.post(f"{page}/commentaires", data={"texte": "Pourquoi ?", **fields})
        assert answer.status_code == status, answer.text
        return answer.headers["location"] if status == 303 else answer.text


@pytest.fixture
def school(site: Site) -> School:
    teacher, other = (person(site, Role.teacher, name) for name in ("Mme Martin", "M. Autre"))
    ada = person(site, name="Ada")
    made = new_class(site.database, teacher.account)
    seat(site.database, made, ada.account, given_name="Ada", family_name="Lovelace")
    new_class(site.database, other.account)
    return School(site, made, ada, teacher, other)


def get(browser: TestClient, path: str, status: int = 200) -> str:
    answer = browser.get(path)
    assert answer.status_code == status, answer.text
    return answer.text


def thread_of(location: str) -> str:
    return location.partition("#fil-")[2]


def test_a_question_on_a_check_is_answered_and_told(school: School) -> None:
    page = school.send()
    link = re.search(r'href="([^"]+)">Je ne comprends pas cette vérification', get(school.student, PAGE))
    assert link
    asked = get(school.student, html.unescape(link[1]).partition("#")[0])
    assert '<option value="b" selected>' in asked
    assert "Je ne comprends pas cette vérification.</textarea>" in asked
    assert "Je ne comprends pas cette vérification</a>" not in get(school.staff, page)
    location = school.say(school.student, page, verification="b", texte="Pourquoi 3 ?")
    assert '<span class="badge badge-soft">ouvert</span>' in get(school.staff, page)
    thread = thread_of(location)
    back = {"texte": "Voyez `x`.", "retour": page}
    assert school.staff.post(f"/fils/{thread}", data=back).headers["location"] == f"{page}#fil-{thread}"
    told = get(school.student, PAGE)
    assert f'href="/fils/{thread}"' in told
    assert "Voyez `x`." in told
    read = get(school.student, page)
    assert "<p>Voyez <code>x</code>.</p>" in read
    assert '<span class="badge">nouveau</span>' in read
    assert '<span class="badge">nouveau</span>' not in get(school.student, page)
    assert f'href="/fils/{thread}"' not in get(school.student, PAGE)
    settled = school.student.post(f"/fils/{thread}/etat", data={"regle": "oui", "retour": page})
    assert settled.headers["location"] == f"{page}#fil-{thread}"
    assert '<span class="badge badge-soft">réglé</span>' in get(school.staff, page)
    assert school.student.post(f"/fils/{thread}", data={"texte": "Et si…"}).status_code == 303
    assert '<span class="badge badge-soft">ouvert</span>' in get(school.staff, f"/fils/{thread}")


def test_a_line_is_commented_in_its_place_and_the_comment_follows_it(school: School) -> None:
    page = school.send()
    form = get(school.staff, f"{page}?ligne=4")
    assert form.index('id="L4"') < form.index('name="ligne" value="4"')
    assert 'href="' + page + '?ligne=2#ecrire"' in form
    school.say(school.staff, page, ligne="4", texte="Et pour un tableau ?")
    shown = get(school.student, page)
    assert shown.index('id="L4"') < shown.index("Et pour un tableau ?")
    assert "remarque" in shown
    later = get(school.student, school.send("# mieux\n" + CODE))
    assert later.index('id="L5"') < later.index("Et pour un tableau ?")
    assert "essai n° 1" in later
    changed = get(school.student, school.send(CODE.replace("x + 1", "x + 2")))
    assert "la ligne a changé depuis" in changed
    gone = get(school.student, school.send("# outcome: wrong_answer"))
    assert "ligne" in gone


def test_hostile_text_is_shown_and_does_nothing(school: School) -> None:
    page = school.send(f"x = '''{HOSTILE}'''\n")
    school.say(school.student, page, texte=HOSTILE)
    thread = thread_of(school.say(school.student, page, ligne="1", texte=HOSTILE))
    for read in (get(school.staff, page), get(school.staff, f"/fils/{thread}")):
        assert not re.search(r"<script>alert|<img src=x|href=\"javascript", read.partition("<main")[2])
        assert "{{ 7*7 }}" in read
        assert "⟦U+202E⟧" in read


#: What is sent, and what is said of it.
REFUSED = [
    ({"texte": "x" * 4001, "ligne": "3"}, "trop long"),
    ({"texte": " "}, "Écrivez d’abord"),
    ({"ligne": "99"}, "de 1 à 4"),
    ({"ligne": "4", "derniere": "2"}, "de 1 à 4"),
    ({"ligne": "zut"}, "par son numéro"),
    ({"ligne": "9" * 5000}, "par son numéro"),
    ({"verification": "zut"}, "pas cette vérification"),
]


def test_what_is_refused_says_why_and_loses_nothing(school: School) -> None:
    page = school.send()
    for fields, said in REFUSED:
        refused = school.say(school.student, page, 422, **fields)
        assert said in refused
        assert fields.get("texte", "Pourquoi ?").strip() in refused
    school.site.tighten(comment_burst=1, comment_refill_seconds=1000.0)
    school.say(school.student, page)
    assert "prochain est possible dans" in school.say(school.student, page, 429, texte="Encore")


def test_what_concerns_somebody_else_is_not_there(school: School) -> None:
    bob = seat(school.site.database, school.made, person(school.site, name="Bob").account)
    page = school.send()
    thread = thread_of(school.say(school.student, page))
    for stranger in (person(school.site, account=bob), school.other):
        browser = stranger.browser(school.site)
        school.say(browser, page, 404)
        for path in (f"/fils/{thread}", f"/fils/{thread}/etat"):
            assert browser.post(path, data={"texte": "Bonjour"}).status_code == 404
        get(browser, f"/fils/{thread}", 404)
        assert browser.post(f"/mots/{uuid4()}/lu").status_code == 404
    nobody = TestClient(school.site.app, follow_redirects=False)
    school.say(nobody, page, 401)
    assert nobody.get(f"/fils/{thread}").headers["location"] == f"/connexion?suite=/fils/{thread}"
    for away in ("//evil.example", "https://evil.example", "javascript:alert(1)"):
        answer = school.student.post(f"/fils/{thread}", data={"texte": "Bien", "retour": away})
        assert answer.headers["location"] == f"/#fil-{thread}"


def test_without_a_class_nobody_would_read_a_question(school: School) -> None:
    alone = person(school.site, name="Seule").browser(school.site)
    answer = alone.post(f"{PAGE}/soumissions", data={"code": CODE})
    assert school.site.worker.run_one()
    for path in (PAGE, answer.headers["location"]):
        read = get(alone, path)
        assert "Je ne comprends pas" not in read
        assert "/commentaires" not in read
        assert "/questions" not in read
    refused = alone.post(f"{PAGE}/questions", data={"texte": "Bonjour"})
    assert (refused.status_code, "rejoignez d’abord la classe" in refused.text) == (409, True)


def test_a_question_on_the_whole_and_a_word_to_several(school: School) -> None:
    asked = school.student.post(f"{PAGE}/questions", data={"texte": "Par où commencer ?"})
    assert asked.status_code == 303
    assert "Par où commencer ?" in get(school.student, PAGE)
    assert "Par où commencer ?" in get(school.staff, f"/fils/{thread_of(asked.headers['location'])}")
    with school.site.database.write() as db:
        args = (EXERCISE, None, "Relisez **tout** `a < b`.", "/l20/lire/localiser", school.site.settings)
        note, _ = notes.send_note_to_students(db, school.teacher.account, school.made, *args)
    told = get(school.student, PAGE)
    assert "Relisez **tout** <code>a &lt; b</code>." in told
    assert 'class="button" href="/l20/lire/localiser"' in told
    assert school.student.post(f"/mots/{note.id}/lu", data={"retour": PAGE}).headers["location"] == PAGE
    assert "1 mot déjà lu" in get(school.student, PAGE)


def test_phrases_are_kept_and_said_again(school: School) -> None:
    page = school.send()
    school.say(school.staff, page, texte="Relisez l’énoncé.", garder="oui")
    kept = re.search(r'<option value="([0-9a-f-]{36})">Relisez', get(school.staff, page))
    assert kept
    school.say(school.staff, page, texte="", phrase=kept[1])
    assert get(school.student, page).count("<p>Relisez l’énoncé.</p>") == 2
    assert "utilisée 1 fois" in get(school.staff, "/compte/phrases")
    for browser, phrase in ((school.staff, "zut"), (school.other.browser(school.site), kept[1])):
        assert browser.post(f"{page}/commentaires", data={"texte": "a", "phrase": phrase}).status_code == 404
    school.say(school.student, page, texte="Et moi ?", garder="oui", phrase=kept[1])
    assert "Aucune encore" in get(school.student, "/compte/phrases")
    assert school.staff.post(f"/compte/phrases/{kept[1]}/effacer").status_code == 303
    assert school.staff.post(f"/compte/phrases/{kept[1]}/effacer").status_code == 404


def test_a_page_asks_as_much_for_many_threads_as_for_one(school: School) -> None:
    school.site.tighten(comment_burst=1000)
    first = school.send()
    counts = []
    for times in (1, 4):
        for number in range(times):
            school.say(school.staff, first, ligne=str(1 + number % 4))
            school.say(school.staff, first)
        page = school.send(f"# {times}\n{CODE}")
        get(school.student, page)
        with Counted(school.site.database) as counted:
            get(school.student, page)
        counts.append(len(counted.statements))
    assert counts[0] == counts[1] <= 18


def test_a_file_of_a_great_many_lines_is_shown_whole_and_within_bounds(school: School) -> None:
    page = get(school.student, school.send("\n" * 60_000 + "fin"))
    assert len(re.findall(r'id="L\d+"', page)) == 1500
    assert len(page) < 1_000_000
    assert "fin" in page


def test_an_assistant_comments_and_an_archived_class_is_read_no_more(school: School) -> None:
    helper = person(school.site, name="Assistante")
    seat(school.site.database, school.made, helper.account, ClassRole.assistant)
    page = school.send()
    school.say(helper.browser(school.site), page, texte="Bien vu")
    assert school.staff.post(f"/classes/{school.made.id}/archiver", data={"archiver": "true"}).status_code == 303
    later = school.send("y = 2\n")
    assert "Pourquoi ?" in school.say(school.student, later, 409)
    school.say(school.staff, later, 404)
    assert "Bien vu" in get(school.staff, page)


def test_the_page_of_a_refusal_keeps_no_other_writer_waiting(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its rendering takes as long as a page: verdicts waited for it, fourteen times as long under a flood of these."""
    render, written = comments.render_attempt_page, list[int]()

    def render_beside_a_writer(*arguments: Any, **options: Any) -> Any:
        answer = render(*arguments, **options)
        with closing(sqlite3.connect(site.settings.data_dir / "balise.sqlite3", timeout=0)) as other:
            other.execute("BEGIN IMMEDIATE")
        written.append(1)
        return answer

    sent = site.client.post("/l20/exercices/poses/soumissions", data={"code": "x"})
    monkeypatch.setattr(comments, "render_attempt_page", render_beside_a_writer)
    answer = site.client.post(f"{sent.headers['location']}/commentaires", data={"texte": "Pourquoi ?"})
    assert (answer.status_code, "Pourquoi ?" in answer.text, written) == (409, True, [1])
