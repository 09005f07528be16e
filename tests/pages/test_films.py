"""What one's program did is answered to who may see the attempt, to nobody else, and never while a test holds it."""

from __future__ import annotations

import gzip
import json
import re
from dataclasses import replace
from typing import Any

import pytest
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from server.assignments.models import Mode
from server.base.app_services import get_service
from server.base.helpers import HelperError
from server.database import utc_now
from server.figures.service import FigureService
from server.gradebook import service as gradebook
from server.gradebook.models import Grading
from server.gradebook.schemas import GradingResult
from server.grading.grading_task import GradingInput
from server.identity.models import Role
from server.submissions.models import Submission
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.service import EXERCISE, Site, fake_verdict

FILM = {"kind": "walk", "at": [1, 2]}
SOURCE = re.compile(r'data-source="([^"]+)"')
ANSWER = b'{"frames": []}'
JSON = {"Accept": "application/json"}


class Drawer:
    """Answers a scene, and counts; or fails, as a film that is malformed does."""

    def __init__(self, *, fails: bool = False) -> None:
        self.fails, self.asked = fails, []

    async def ask(self, question: bytes) -> bytes:
        self.asked.append(json.loads(question))
        if self.fails:
            raise HelperError
        return gzip.compress(ANSWER)

    async def close(self) -> None: ...


def draws(site: Site, **options: bool) -> Drawer:
    drawer = Drawer(**options)
    get_service(site.app, FigureService).pictures._drawer = drawer  # type: ignore[assignment]
    return drawer


def judged(sent: GradingInput) -> Judgement:
    verdict = replace(fake_verdict(sent.source.decode(), sent.seed), exercise=sent.exercise)
    return Judgement(verdict, {}, {"b": FILM, "zz": {"kind": "odd"}})


def sends(site: Site, who: Person, code: str = "x = 1  # outcome: wrong_answer") -> str:
    """The address of the attempt's page, once it is graded."""
    answer = site.client.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": code}, headers=who.headers)
    assert answer.status_code == 202, answer.text
    assert site.worker_with(judged).run_one()
    return f"/soumissions/{answer.json()['id']}"


def test_a_film_is_made_once_for_who_may_see_the_attempt_and_is_not_there_for_anybody_else(site: Site) -> None:
    drawer = draws(site)
    ada, stranger = person(site), person(site)
    teacher, admin = person(site, Role.teacher), person(site, Role.administrator)
    seat(site.database, new_class(site.database, teacher.account), ada.account)
    path = f"{sends(site, ada)}/rejeux/b"
    assert drawer.asked == []
    for who in (ada, teacher, admin):
        answer = who.browser(site).get(path, headers=JSON)
        assert (answer.status_code, answer.content) == (200, ANSWER)
        assert (answer.headers["content-type"], answer.headers["content-encoding"]) == ("application/json", "gzip")
        assert answer.headers["cache-control"] == "private, no-cache"
    assert drawer.asked == [{"kind": "film", "exercise": EXERCISE, "data": FILM, "title": "Seconde"}]
    refused = stranger.browser(site).get(path, headers=JSON)
    assert (refused.status_code, refused.headers["content-type"]) == (404, "application/problem+json")
    assert site.client.get(path).status_code == 404
    assert ada.browser(site).get(f"{path}?x=1", headers={"Accept-Encoding": "identity"}).content == ANSWER
    for name in ("a", "zut", "%2e%2e"):
        assert ada.browser(site).get(f"{path[:-1]}{name}").status_code == 404


def test_each_grading_keeps_its_own_and_none_of_another_attempt_is_told(site: Site) -> None:
    drawer, ada = draws(site), person(site)
    first, second = sends(site, ada), sends(site, ada, "x = 2")
    with site.database.write() as db:
        sent = db.execute(select(Submission).where(Submission.account_id == ada.id)).scalars().all()
        mine = next(one for one in sent if str(one.id) in first)
        again = Judgement(fake_verdict("x = 1", 1), {}, {"a": {"kind": "again"}})
        regraded = gradebook.add_uncounted_grading(db, mine.id, GradingResult(again, utc_now()))
        assert db.get(Grading, regraded).filmed == ["a"]
    browser = ada.browser(site)
    answer = browser.get(f"{first}/rejeux/a?correction={regraded}")
    assert (answer.status_code, answer.headers["cache-control"]) == (200, "private, max-age=31536000, immutable")
    assert drawer.asked[-1]["data"] == {"kind": "again"}
    for path in (
        f"{first}/rejeux/a",
        f"{first}/rejeux/b?correction={regraded}",
        f"{second}/rejeux/a?correction={regraded}",
    ):
        assert browser.get(path).status_code == 404, path


def test_what_a_test_holds_back_is_not_shown_whichever_grading_is_named(site: Site) -> None:
    draws(site)
    ada, teacher = person(site), person(site, Role.teacher)
    made = new_class(site.database, teacher.account)
    seat(site.database, made, ada.account)
    test = assign(site.database, made, EXERCISE, mode=Mode.test, duration_minutes=60)
    sitting = f"/classes/{made.id}/devoirs/{test.id}"
    assert ada.browser(site).post(f"{sitting}/commencer").status_code == 303
    href = sends(site, ada)
    with site.database.read() as db:
        grading = db.execute(select(Grading.id)).scalar_one()
    paths = (f"{href}/rejeux/b", f"{href}/rejeux/b?correction={grading}")
    for path in (*paths, f"{href}/figures/b.svg?correction={grading}"):
        assert ada.browser(site).get(path).status_code == 404, path
    for path in paths:
        assert teacher.browser(site).get(path).content == ANSWER
    assert ada.browser(site).post(f"{sitting}/rendre").status_code == 303
    assert teacher.browser(site).post(f"{sitting}/publier").status_code == 303
    assert ada.browser(site).get(paths[0]).content == ANSWER


def test_a_film_that_cannot_be_made_is_our_error_and_is_said_kindly(site: Site) -> None:
    drawer, ada = draws(site, fails=True), person(site)
    path = f"{sends(site, ada)}/rejeux/b"
    for _ in range(2):
        answer = ada.browser(site).get(path, headers=JSON)
        assert answer.status_code == 500
        assert "de notre côté" in answer.json()["detail"]
        assert "votre note n’en dépend pas" in answer.json()["detail"]
    assert len(drawer.asked) == 2, "a failure is not remembered"


@pytest.mark.parametrize("films", [{}, {"b": FILM}])
def test_a_grading_says_of_which_checks_there_are_films(site: Site, films: dict[str, Any]) -> None:
    ada = person(site)
    href = sends(site, ada)
    with site.database.write() as db:
        submission = db.execute(select(Submission)).scalar_one()
        gradebook.record_grading(
            db, submission.id, GradingResult(Judgement(fake_verdict("x = 1", 1), {}, films), utc_now())
        )
    with site.database.read() as db:
        grading = gradebook.find_attempt(db, ada.account, href.rsplit("/", 1)[1]).grading
        assert grading is not None
        assert (grading.filmed, "films" in vars(grading)) == (list(films) or None, False)


def test_a_verdict_shows_what_can_be_watched_what_failed_first(site: Site) -> None:
    draws(site)
    ada, teacher = person(site), person(site, Role.teacher)
    seat(site.database, new_class(site.database, teacher.account), ada.account)
    href = sends(site, ada)
    with site.database.write() as db:
        submission = db.execute(select(Submission)).scalar_one()
        films = {"a": FILM, "b": FILM}
        gradebook.record_grading(
            db, submission.id, GradingResult(Judgement(fake_verdict("outcome: timeout", 1), {}, films), utc_now())
        )
        db.refresh(submission)
        ending = f"?correction={submission.grading_id}"
    own = (href, f"{href}/verdict", f"/{EXERCISE.replace('/', '/exercices/')}")
    for who, paths in ((ada, own), (teacher, (href,))):
        for path in paths:
            page = who.browser(site).get(path).text
            assert SOURCE.findall(page) == [f"{href}/rejeux/{name}{ending}" for name in "ba"], path
            assert page.index('id="film-b"') < page.index('id="film-a"')
            assert page.count('href="#film-b"') == 1, "a failed check leads to its own"
            assert 'href="#film-a"' not in page
            assert page.count('<p class="without-script">Cette animation se joue avec JavaScript') == 2
    for source in SOURCE.findall(ada.browser(site).get(href).text):
        assert ada.browser(site).get(source, headers=JSON).content == ANSWER


def test_a_verdict_without_films_speaks_of_none(site: Site) -> None:
    ada = person(site)
    href = sends(site, ada)
    with site.database.write() as db:
        submission = db.execute(select(Submission)).scalar_one()
        gradebook.record_grading(db, submission.id, GradingResult(Judgement(fake_verdict("x = 1", 1)), utc_now()))
    page = ada.browser(site).get(href).text
    assert "Revoir ce que votre code a fait" not in page
    assert "data-source" not in page
