"""On PostgreSQL: an exercise is made, published, done, given a new version, and regraded."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from server.base.app_services import get_service
from server.base.settings import Settings
from server.classes.models import ClassRole
from server.course import Course
from server.gradebook.models import Grading
from server.identity.models import Role
from server.regrades.service import RegradeService
from server.studio.service import find_own_exercise, read_draft
from tests.support.classes import new_class, person, seat
from tests.support.client import TestClient
from tests.support.quick import standing_app
from tests.support.service import Site, opened

from .conftest import MISTAKE, SOLUTION, Studio

pytestmark = pytest.mark.contract
ONCE = SOLUTION.replace("d.get(m, 0) + 1", "1")


@pytest.fixture
def site(settings: Settings, postgres_url: str, course: Course) -> Iterator[Site]:
    chosen = settings.model_copy(update={"database_url": postgres_url})
    for _ in opened(chosen):
        with TestClient(standing_app(chosen, course), follow_redirects=False) as client:
            yield Site(client.app, client, chosen)  # type: ignore[arg-type]


def test_the_life_of_an_exercise(studio: Studio) -> None:
    exercise = studio.publish(**MISTAKE)
    path = f"/mes-exercices/{exercise.id}"
    made = new_class(studio.site.database, studio.teacher.account)
    ada = person(studio.site, Role.student, "Ada")
    seat(studio.site.database, made, ada.account, ClassRole.student)
    given = studio.browser.post(
        f"/classes/{made.id}/devoirs",
        data={"titre": "DM", "exercice": exercise.name, "ouvre": "2020-01-01T08:00", "retard": "accept"},
    )
    assert given.status_code == 303, given.text
    browser = ada.browser(studio.site)
    sent = browser.post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": ONCE})
    studio.work()
    assert "Chaque mot compte une fois" in browser.get(sent.headers["location"]).text
    for action in ("partager", "banque", "classes"):
        studio.save(path, **MISTAKE, action=action)
    assert exercise.draft["title"] in studio.browser.get("/mes-exercices/banque", params={"q": "chaque mot"}).text
    assert f"/l20/exercices/{exercise.slug}" in browser.get("/l20").text
    studio.browser.post(f"{path}/essayer", data={"code": ONCE})
    studio.work()
    assert "Chaque mot compte une fois" in studio.browser.get(f"{path}/essayer").text
    studio.save(path, **MISTAKE, action="publier", enonce="Un autre énoncé.")
    regrades = get_service(studio.site.app, RegradeService)
    with studio.site.database.read() as db:
        assert list(regrades.load_outdated_exercises(db, made)) == []
    studio.save(path, **MISTAKE, action="publier", **{"v-0-c-3-appel": 'compter_mots("z z z")'})
    with studio.site.database.read() as db:
        assert [each.exercise for each in regrades.load_outdated_exercises(db, made)] == [exercise.name]
        assert [len(read_draft(find_own_exercise(db, studio.teacher.account, exercise.id)).checks[0].cases)] == [4]
    asked = studio.browser.post(f"/classes/{made.id}/recalculs", data={"exercice": exercise.name})
    assert asked.status_code == 303, asked.text
    studio.work()
    with studio.site.database.read() as db:
        versions = {grading.exercise_version for grading in db.query(Grading)}
    assert versions >= {studio.versions()[0].version}
    assert len(studio.versions()) == 3
