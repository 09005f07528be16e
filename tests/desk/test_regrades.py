"""Pages and API of regrades: from the version that changed to what each student reads of it."""

from __future__ import annotations

import re
from html import unescape
from uuid import UUID, uuid4

import pytest

from server.base.app_services import get_service
from server.classes import service as classes
from server.course.models import Course
from server.figures.service import FigureService
from server.gradebook import service as gradebook
from server.marks.models import Override
from server.regrades import applying
from server.regrades.service import RegradeService
from tests.support.classes import Person, person
from tests.support.client import TestClient
from tests.support.regrades import Lesson
from tests.support.service import EXERCISE, Site


@pytest.fixture
def lesson(site: Site) -> Lesson:
    return Lesson(site.database, site.settings, get_service(site.app, RegradeService).queue)


@pytest.fixture
def martin(site: Site, lesson: Lesson) -> Person:
    return person(site, account=lesson.teacher)


def read(browser: TestClient, path: str, status: int = 200) -> str:
    answer = browser.get(path)
    assert answer.status_code == status, answer.text
    return " ".join(re.sub(r"<[^>]+>", " ", unescape(answer.text)).split()).replace("\u00a0", " ")


def test_from_the_offer_to_what_the_student_reads(site: Site, lesson: Lesson, martin: Person, course: Course) -> None:
    lesson.version = course.version_of_exercise(EXERCISE)
    lesson.arrive(3)
    names = [lesson.sent(student, 4, points) for student, points in zip(lesson.students, (14, 2, 4), strict=True)]
    browser, base = martin.browser(site), f"/classes/{lesson.made.id}/recalculs"
    assert "3 copies de 3 élèves ont été corrigées par une version plus ancienne." in read(browser, base)
    begun = browser.post(base, data={"exercice": EXERCISE, "regle": "replace"})
    href = begun.headers["location"]
    assert "0 sur 3 copies" in read(browser, href)
    assert "en cours" in browser.post(base, data={"exercice": EXERCISE}).text
    refused = browser.post(href, data={"action": "appliquer"})
    assert (refused.status_code, "encore 3 à faire" in refused.text) == (409, True)
    lesson.work()
    with browser.stream("GET", f"{href}/evenements") as stream:
        told = stream.read().decode()
    assert '"done": true, "graded": 3, "total": 3' in told
    page = read(browser, href)
    assert "1 élève perdrait des points Élève Avant Après Écart Pourquoi Élève 1 4 2 −2" in page
    assert "1 élève gagnerait des points Élève Avant Après Écart Pourquoi Élève 0 4 14 +10" in page
    assert "la vérification « La distance » passe de 0 à 4 sur 10" in page
    assert "1 élève aurait la même note" in page
    ada = person(site, account=lesson.students[0]).browser(site)
    attempt = f"/soumissions/{names[0]}"
    assert "Recorrigé" not in read(ada, attempt)
    for action, told_now, button in (("appliquer", True, "Annuler la rec"), ("annuler", False, "Appliquer de nouveau")):
        assert browser.post(href, data={"action": action}).headers["location"] == href
        assert button in read(browser, href)
        for path in (attempt, f"{attempt}/verdict", "/l20/exercices/poses"):
            shown = read(ada, path)
            assert ("La vérification « L’angle » passe de 4 à 10 sur 10." in shown) is told_now
            assert ("4 → devient 14" in shown) is told_now
    assert "plus ancienne" not in read(browser, base)
    assert browser.post(href, data={"action": "zut"}).status_code == 404


def test_a_mark_set_by_hand_is_said_to_stay(site: Site, lesson: Lesson, martin: Person) -> None:
    ada = lesson.arrive()
    lesson.sent(ada, 4, 8)
    values = {"class_id": lesson.made.id, "account_id": ada.id, "exercise": EXERCISE}
    with lesson.database.write() as db:
        db.add(Override(**values, points=15.0, reason="à l’oral", based_on=[], by=martin.id))
    page = read(martin.browser(site), f"/classes/{lesson.made.id}/recalculs/{lesson.prepared().id}")
    assert "note modifiée à la main : elle reste celle qui compte" in page


def test_a_choice_that_is_not_offered_is_told_in_the_form(site: Site, lesson: Lesson, martin: Person) -> None:
    browser, base = martin.browser(site), f"/classes/{lesson.made.id}/recalculs"
    for fields, said in (
        ({"exercice": EXERCISE}, "aucun essai corrigé"),
        ({"exercice": "l20/zut"}, "pas du module"),
        ({"exercice": EXERCISE, "regle": "zut"}, "pas proposé"),
        ({"exercice": EXERCISE, "eleve": "zut"}, "pas proposé"),
        ({"exercice": EXERCISE, "eleve": str(uuid4())}, "pas dans la classe"),
        ({"exercice": EXERCISE, "devoir": str(uuid4())}, "pas de cette classe"),
    ):
        answer = browser.post(base, data=fields)
        assert (answer.status_code in {404, 422}, said in answer.text) == (True, True), answer.text
    assert browser.get(f"{base}/{uuid4()}").status_code == browser.get(f"{base}/zut").status_code == 404
    lesson.sent(lesson.arrive(), 4, 8)
    regrade = lesson.prepared()
    with lesson.database.write() as db:
        classes.archive_class(db.merge(lesson.made))
    assert browser.post(base, data={"exercice": EXERCISE}).status_code == 409
    assert browser.post(f"{base}/{regrade.id}", data={"action": "appliquer"}).status_code == 409


def test_a_regrade_is_of_its_class_alone(site: Site, lesson: Lesson) -> None:
    lesson.sent(lesson.arrive(), 4, 8)
    regrade = lesson.prepared()
    other = Lesson(site.database, site.settings)
    elsewhere = person(site, account=other.teacher)
    for made in (other.made, lesson.made):
        assert elsewhere.browser(site).get(f"/classes/{made.id}/recalculs/{regrade.id}").status_code == 404
        for end in ("apply", "undo"):
            url = f"/api/v1/classes/{made.id}/regrades/{regrade.id}/{end}"
            assert site.client.post(url, headers=elsewhere.headers).status_code == 404


def test_the_api_says_whose_mark_changes_and_why(site: Site, lesson: Lesson, martin: Person) -> None:
    lesson.arrive(2)
    ada, bob = lesson.students
    lesson.sent(ada, 4, 10)
    lesson.sent(bob, 4, 2)
    url, headers = f"/api/v1/classes/{lesson.made.id}/regrades", martin.headers
    begun = site.client.post(url, json={"exercise": EXERCISE, "policy": "keep_best"}, headers=headers)
    assert (begun.status_code, set(begun.json())) == (202, {"id"})
    url = f"{url}/{begun.json()['id']}"
    found = site.client.get(url, headers=headers).json()
    assert (found["state"], found["progress"], found["changes"]) == ("running", {"done": 0, "total": 2}, [])
    assert site.client.post(f"{url}/apply", headers=headers).status_code == 409
    lesson.work()
    found = site.client.get(url, headers=headers).json()
    why = "la vérification « L’angle » passe de 4 à 10 sur 10"
    assert found["changes"] == [{"student": str(ada.id), "before": 4.0, "after": 10.0, "why": why}]
    assert found["students"] == {"gains": 1, "loses": 0, "kept": 1, "same": 0}
    for _ in range(2):
        assert site.client.post(f"{url}/apply", headers=headers).json()["state"] == "applied"
    for _ in range(2):
        assert site.client.post(f"{url}/undo", headers=headers).json()["state"] == "undone"
    for body, status in (({"exercise": EXERCISE, "policy": "zut"}, 422), ({"exercise": "l20/zut"}, 404)):
        assert site.client.post(url.rsplit("/", 1)[0], json=body, headers=headers).status_code == status


class Drawer:
    """Draws nothing, and notes what it was asked."""

    def __init__(self) -> None:
        self.asked: list[bytes] = []

    async def ask(self, question: bytes) -> bytes:
        self.asked.append(question)
        return b"<svg/>"

    async def close(self) -> None: ...


def test_figures_are_those_of_the_grading_that_a_page_shows(site: Site, lesson: Lesson, martin: Person) -> None:
    drawer = Drawer()
    get_service(site.app, FigureService).pictures._drawer = drawer  # type: ignore[assignment]
    ada = person(site, account=lesson.arrive())
    name, other = lesson.sent(ada.account, 4, 8), lesson.sent(ada.account, 4, 8)
    regrade, browser = lesson.prepared(), ada.browser(site)
    figure = f"/soumissions/{name}/figures/b.svg"
    assert browser.get(figure).status_code == 404, "the old grading has none"
    gradings = [_counting(lesson, ada, name)]
    with lesson.database.write() as db:
        applying.apply_regrade(db, lesson.course, regrade.id, lesson.teacher.id)
    gradings.append(_counting(lesson, ada, name))
    plain = browser.get(figure)
    assert (plain.status_code, plain.headers["cache-control"]) == (200, "private, no-cache")
    named = browser.get(figure, params={"correction": str(gradings[1])})
    assert (named.status_code, "immutable" in named.headers["cache-control"]) == (200, True)
    for grading in (gradings[0], _counting(lesson, ada, other), uuid4()):
        assert browser.get(figure, params={"correction": str(grading)}).status_code == 404
    assert b"anew" in drawer.asked[0]


def _counting(lesson: Lesson, who: Person, name: UUID) -> UUID:
    with lesson.database.read() as db:
        grading = gradebook.find_attempt(db, who.account, name).grading
    assert grading is not None
    return grading.id
