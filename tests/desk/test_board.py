"""The pages of a class's board, as its teacher, its students and strangers see them."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from datetime import timedelta
from html import unescape
from typing import Any

import pytest

from server.base.app_services import get_service
from server.board import service
from server.board.live import LiveClassViews
from server.board.schemas import Board
from server.classes.models import SchoolClass
from server.course import Course
from server.database import utc_now
from server.desk.board.changes import OpenBoard, board_events
from server.identity.models import Account, Role
from tests.desk.test_classes import text_of
from tests.support.caches import clear_caches
from tests.support.classes import Person, new_class, person, seat
from tests.support.counting import Counted
from tests.support.crowd import Sent, lessons, seated, store
from tests.support.service import EXERCISE, Site

WRONG = "rotation_oubliee"
CODE = '''import numpy as np
def composer(a, b):
    """De Ada Lovelace."""
    # Ada Lovelace, MPSI 2
    lovelace = a + b  # à moi
    print("Ada", 'Lovelace')
    return lovelace

def inverse(a):
    return a
'''


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


@pytest.fixture
def made(site: Site, martin: Person) -> SchoolClass:
    return new_class(site.database, martin.account)


def board_of(site: Site, course: Course, made: SchoolClass) -> Board:
    with site.database.read() as db:
        school_class = db.get(SchoolClass, made.id)
        assert school_class is not None
        return service.load_board(db, course, school_class, utc_now())


def test_the_board_of_a_class(site: Site, martin: Person, made: SchoolClass) -> None:
    browser, href = martin.browser(site), f"/classes/{made.id}"
    assert "Personne n’est encore dans la classe" in text_of(browser, href)
    ada, alan = seated(site.database, made, 2, utc_now())
    with site.database.write() as db:
        account = db.get(Account, ada)
        assert account is not None
        account.name = "<b>Ada</b> <script>alert(1)</script>"
    now = utc_now()
    store(site.database, [
        *(Sent(ada, EXERCISE, now - timedelta(minutes=10 - one), 0.25, WRONG, f"x = {one}") for one in range(3)),
        Sent(alan, EXERCISE, now, 0.5),
    ])  # fmt: skip
    text = text_of(browser, href)
    assert "<script>alert" not in text
    assert "&lt;b&gt;Ada&lt;/b&gt;" in text
    assert re.search(r"<strong>2</strong> sur 2 ont commencé", text)
    assert re.search(r">1</strong> est bloqué en ce moment", text)
    assert "deux essais ratés différents" in text
    assert f'class="spot spot-stuck" data-key="{ada} {EXERCISE}"' in text
    assert f"{href}/eleves/{ada}/{EXERCISE}" in text
    assert f"{href}/erreurs/{EXERCISE}/{WRONG}" in text
    unnamed = text.split('id="a-regarder"')[1].split("</section>")[0]
    assert str(alan) in unnamed
    assert str(ada) not in unnamed
    assert browser.get(href).headers["cache-control"] == "private, no-cache"


def names_of(text: str) -> list[str]:
    return re.findall(r'<tr data-key="[0-9a-f-]{36}"><th scope="row"><a [^>]*>([^<]+)</a>', text)


def test_students_are_sorted_filtered_and_paged(site: Site, martin: Person, made: SchoolClass) -> None:
    browser, href = martin.browser(site), f"/classes/{made.id}"
    now = utc_now()
    students = seated(site.database, made, 70, now)
    store(site.database, [
        Sent(students[69], EXERCISE, now, 1.0),
        *(Sent(students[68], EXERCISE, now - timedelta(minutes=5 * one), 0.0, None, f"x = {one}") for one in range(3)),
    ])  # fmt: skip
    everyone = names_of(text_of(browser, href)) + names_of(text_of(browser, f"{href}?page=2"))
    assert (len(everyone), len(set(everyone))) == (70, 70)
    assert names_of(text_of(browser, f"{href}?tri=-nom")) == everyone[::-1][:60]
    found = text_of(browser, f"{href}/tableau?q=GERMAIN+kurt&tri=bloques&erreurs=toutes")
    assert set(names_of(found)) == {name for name in everyone if name.startswith("Kurt Germain")}, (
        "accents and case aside"
    )
    assert '<input type="hidden" name="tri" value="bloques">' in found, "the order outlasts a search"
    assert "q=GERMAIN+kurt" in found.split('aria-label="Ordre des élèves"')[1].split("</nav>")[0]
    assert "Aucun élève ne correspond" in text_of(browser, f"{href}/tableau?q=personne")
    solved, stuck = "Hypatie Germain", "Kurt Germain"
    assert names_of(text_of(browser, f"{href}?tri=reussis"))[0] == solved
    assert names_of(text_of(browser, f"{href}?tri=bloques"))[0] == stuck
    by_exercise = (
        names_of(text_of(browser, f"{href}?tri={EXERCISE}")),
        names_of(text_of(browser, f"{href}?tri=-{EXERCISE}")),
    )
    assert (by_exercise[0][0], by_exercise[1][0]) == (stuck, solved)
    assert len(names_of(text_of(browser, f"{href}?groupe=TP1"))) == 35
    assert names_of(text_of(browser, f"{href}?groupe=rien")) == []
    assert names_of(text_of(browser, f"{href}?tri=zut&page=9")) == []
    assert text_of(browser, f"{href}?page=0", 422)
    assert 'aria-sort="ascending"' in text_of(browser, f"{href}?tri={EXERCISE}&groupe=TP1")


def mistake(site: Site, made: SchoolClass, count: int) -> tuple[str, Any]:
    """Has so many students make the same mistake, with a program of their own; the last has overcome it."""
    students, now = seated(site.database, made, count), utc_now()
    sent = [
        Sent(one, EXERCISE, now - timedelta(minutes=5), 0.25, WRONG, CODE.replace("a + b", f"a + b + {place}"))
        for place, one in enumerate(students)
    ]
    store(site.database, [*sent, Sent(students[-1], EXERCISE, now, 1.0)])
    return f"/classes/{made.id}/erreurs/{EXERCISE}/{WRONG}", students


def test_a_misconception_and_its_projection(site: Site, martin: Person, made: SchoolClass) -> None:
    browser = martin.browser(site)
    href, students = mistake(site, made, 5)
    text = text_of(browser, href)
    assert "4 élèves encore" in text
    assert "regardait toujours vers l’est" in text, "what the course says of it"
    assert "À relire" in text
    (word,) = re.findall(r'href="([^"]+)">Écrire aux élèves', text)
    assert "Envoyer à 4 élèves" in text_of(browser, unescape(word))
    assert text_of(browser, f"/classes/{made.id}/eleves/{students[0]}/{EXERCISE}")
    still, freed = text.split('id="encore"')[1].split('id="surmontee"')
    assert [str(one) in still for one in students] == [True] * 4 + [False]
    assert str(students[-1]) in freed
    shown = text_of(browser, f"{href}/projeter")
    for page in (shown, text.split('id="extraits"')[1].split("</section>")[0]):
        assert page.count('<pre class="code"') == (1 if page is shown else 2), "the right program has no such function"
        assert "composer" in page
        assert not re.search(r"\bAda\b|Lovelace|MPSI|à moi|inverse\(", page, re.I), "identities may hold an “ada”"
    assert "Hopper" not in shown
    assert str(students[0]) not in shown
    assert text_of(browser, f"/classes/{made.id}/erreurs/{EXERCISE}/mauvais_angle", 404)
    assert text_of(browser, f"/classes/{made.id}/erreurs/l20/rien/{WRONG}", 404)


def test_a_rare_misconception_is_projected_by_choice_and_without_extracts(
    site: Site, martin: Person, made: SchoolClass
) -> None:
    browser = martin.browser(site)
    href, _ = mistake(site, made, 4)
    asked = text_of(browser, f"{href}/projeter")
    assert "Projeter quand même" in asked
    assert "vers l’est" not in asked
    chosen = text_of(browser, f"{href}/projeter?choix=oui")
    assert "vers l’est" in chosen
    assert "<pre" not in chosen


def test_a_student_sees_their_own_page_and_no_board(site: Site, martin: Person, made: SchoolClass) -> None:
    href, _ = mistake(site, made, 5)
    ada, stranger = person(site), person(site, Role.teacher, "Autre")
    seat(site.database, made, ada.account)
    assert "Erreurs reconnues" not in text_of(ada.browser(site), f"/classes/{made.id}")
    for path in (href, f"{href}/projeter", f"/classes/{made.id}/evenements"):
        assert text_of(ada.browser(site), path, 403)
        assert text_of(stranger.browser(site), path, 404)
    assert text_of(stranger.browser(site), f"/classes/{made.id}", 404)


def test_the_page_asks_no_more_for_more_students(site: Site, martin: Person, made: SchoolClass) -> None:
    browser, href = martin.browser(site), f"/classes/{made.id}"

    def statements() -> int:
        clear_caches()
        with Counted(site.database) as counted:
            text_of(browser, href)
        return len(counted.statements)

    exercises = [EXERCISE, "l20/boucles"]
    mistakes = {name: ["a", WRONG] for name in exercises}
    store(site.database, lessons(seated(site.database, made, 1), exercises, mistakes, utc_now()))
    text_of(browser, href)
    few = statements()
    store(site.database, lessons(seated(site.database, made, 25), exercises, mistakes, utc_now()))
    assert statements() == few <= 12


def test_stream_events_hold_the_same_html_as_the_page(
    site: Site, martin: Person, made: SchoolClass, course: Course
) -> None:
    (ada,) = seated(site.database, made, 1)
    before = board_of(site, course, made)
    store(site.database, [Sent(ada, EXERCISE, utc_now(), 0.25, WRONG)])
    after = board_of(site, course, made)
    href = f"/classes/{made.id}"
    view = OpenBoard(course, href, before.version, everything=False)
    told = dict(re.findall(r"event: (\w+)\n((?:data: ?.*\n)+)", board_events(view, before, after)))
    assert told.keys() == {"cell", "counts", "misconceptions", "version"}
    assert after.version in told["version"]
    page = text_of(martin.browser(site), href)
    cell = json.loads(told["cell"].removeprefix("data: "))
    assert cell["key"] == f"{ada} {EXERCISE}"
    assert cell["html"] in page
    assert told["counts"].removeprefix("data: ").strip() in page
    assert f'data-version="{after.version}"' in page
    assert board_events(view, None, before).count("event:") == 1
    assert "event: outdated" in board_events(view, None, after)
    renamed = replace(after, students=(replace(after.students[0], name="Ada L."),))
    assert "event: outdated" in board_events(view, after, renamed)


def test_the_stream_begins_with_the_version_of_the_page(
    site: Site, martin: Person, made: SchoolClass, course: Course
) -> None:
    get_service(site.app, LiveClassViews).max_stream_seconds = 0.0
    version = board_of(site, course, made).version
    browser, path = martin.browser(site), f"/classes/{made.id}/evenements"
    answer = browser.get(path, params={"version": version})
    assert answer.headers["content-type"].startswith("text/event-stream")
    assert answer.text == f"id: {version}\nevent: version\ndata: {version}\n\n"
    assert "event: outdated" in browser.get(path, params={"version": "une autre"}).text
    again = browser.get(path, params={"version": "une autre"}, headers={"Last-Event-ID": version})
    assert "outdated" not in again.text
