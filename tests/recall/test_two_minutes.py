"""« Deux minutes »: proposed when something is due, answered, and off at a click."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import pytest
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from server.base.app_services import add_services, get_service
from server.grading.grading_task import GradingInput
from server.hunts.service import HuntService
from server.submissions.models import Submission
from tests.hunts.test_service import TYPED, Process, answers
from tests.pages.test_notebook import graded
from tests.support.service import Site

PATH = "/deux-minutes"
DUE = {**TYPED, "exercice": "l20/poses"}


def confuse_and_mend(site: Site, exercise: str = "poses", mistake: str = "rotation_oubliee") -> None:
    for code in (f"x = 1  # {mistake}\n", "x = 2\n"):
        site.client.post(f"/l20/exercices/{exercise}/soumissions", data={"code": code})
        assert site.worker_with(judge).run_one()


def judge(sent: GradingInput) -> Judgement:
    return graded(sent)


def age(site: Site, days: float) -> None:
    with site.database.write() as db:
        for sent in db.execute(select(Submission)).scalars():
            sent.created_at -= timedelta(days=days)


@pytest.fixture
def process(site: Site) -> Process:
    fake = Process()
    add_services(site.app, replace(get_service(site.app, HuntService), ask=fake))
    return fake


def test_what_was_confused_comes_back_after_a_day_and_goes_once_answered(site: Site, process: Process) -> None:
    assert site.client.get(PATH).headers["location"].startswith("/connexion")
    confuse_and_mend(site)
    assert "Deux minutes" not in site.client.get("/").text
    assert "Rien à revoir" in site.client.get(PATH).text
    age(site, 2)
    assert "Pas encore vérifiée depuis" in site.client.get("/compte/carnet-d-erreurs").text
    assert "1 question" in site.client.get("/").text.replace("\u202f", " ").replace("\xa0", " ")
    assert "Trouvez une entrée qui le montre" in site.client.get(PATH).text
    page = site.client.post(PATH, data=DUE).text
    assert "Terminer" in page
    assert answers(site) == [("hunt", True)]
    assert "Vérifiée pour la dernière fois" in site.client.get("/compte/carnet-d-erreurs").text
    assert "C’est tout pour aujourd’hui" in site.client.get(PATH).text
    assert 'id="deux-minutes"' not in site.client.get("/").text


def test_reminders_go_at_a_click_and_come_back(site: Site, process: Process) -> None:
    confuse_and_mend(site)
    age(site, 2)
    site.client.post(f"{PATH}/rappels", data={"rappels": "non"})
    assert 'id="deux-minutes"' not in site.client.get("/").text
    assert "Trouvez une entrée" in site.client.get(PATH).text, "the page itself stays"
    site.client.post(f"{PATH}/rappels", data={"rappels": "oui"})
    assert 'id="deux-minutes"' in site.client.get("/").text


def test_what_is_not_mended_yet_or_cannot_be_asked_does_not_come_back(site: Site, process: Process) -> None:
    confuse_and_mend(site, "association", "bruit_oublie")
    age(site, 5)
    assert 'id="deux-minutes"' not in site.client.get("/").text
