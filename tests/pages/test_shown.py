"""A verdict on the pages of its attempt and of its exercise, for each reader."""

from __future__ import annotations

from server.identity.models import Role
from tests.support.classes import new_class, person, seat
from tests.support.service import EXERCISE, Site

WRONG = "x = 1  # outcome: wrong_answer"
PAGE, ASK = "/l20/exercices/poses", "Je ne comprends pas cette vérification"


def send(site: Site, headers: dict[str, str], code: str) -> str:
    answer = site.client.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": code}, headers=headers)
    assert answer.status_code == 202, answer.text
    assert site.worker.run_one()
    return f"/soumissions/{answer.json()['id']}"


def test_a_verdict_is_rendered_for_its_reader_and_its_attempt(site: Site) -> None:
    ada, teacher = person(site), person(site, Role.teacher)
    own = ada.browser(site)
    path = send(site, ada.headers, WRONG)
    assert ASK not in own.get(path).text
    seat(site.database, new_class(site.database, teacher.account), ada.account)
    assert ASK in own.get(path).text, "somebody would read the question now"
    assert ASK not in teacher.browser(site).get(path).text
    other = send(site, ada.headers, WRONG.replace("x = 1", "x = 2"))
    assert "Essai n° 2" in own.get(other).text
    assert "Essai n° 1" in own.get(path).text
    assert "Essai n° 2" in own.get(PAGE).text
