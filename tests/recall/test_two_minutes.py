"""« Deux minutes »: proposed when something is due, answered, and off at a click."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import pytest
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from server.base.app_services import add_services, get_service
from server.grading.grading_task import GradingInput
from server.hunts.protocol import HuntTrialOutcome, LineTrial
from server.hunts.service import HuntService, choose_question_kind
from server.recall import retrievals
from server.recall.models import RecallAnswer
from server.submissions.models import Submission
from tests.hunts.test_service import OFFER, TYPED, Process, answers
from tests.pages.test_notebook import graded
from tests.support.classes import person
from tests.support.quick import the_course
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


def test_a_missed_question_of_a_lesson_comes_back_with_other_numbers(site: Site) -> None:
    ada, module, day = person(site), the_course().modules["l20"], retrievals.today_at_school()
    browser = ada.browser(site)
    for name, reply in (("localiser/cap", "-3"), ("localiser/copies", None)):
        right = retrievals.draw_retrieval(module, name, ada.account, day).question.answer
        form = {"question": name, "jour": day.isoformat(), "reponse": str(right) if reply is None else reply}
        browser.post("/l20/rappels", data=form, headers={"Accept": "application/json"})
    assert 'id="deux-minutes"' not in browser.get("/").text, "not on the day itself"
    with site.database.write() as db:
        for stored in db.execute(select(RecallAnswer)).scalars():
            stored.answered_at -= timedelta(days=2)
    assert 'id="deux-minutes"' in browser.get("/").text, "with no exercise solved"
    own = browser.get("/l20/objectifs").text.replace("\u202f", " ").replace("\xa0", " ")
    assert "1 question" in own
    assert "vous aviez manqué une question d’une séance" in own, "nothing was mended"
    assert 'value="localiser/cap"' in browser.get(PATH).text, "the right answer does not come back"
    form = {"question": "localiser/cap", "jour": day.isoformat()}
    refused = browser.post(f"{PATH}/questions/l20", data={**form, "reponse": "douze"})
    assert 'value="douze"' in refused.text
    assert "Vérifier" in refused.text
    right = retrievals.draw_retrieval(module, "localiser/cap", ada.account, day).question.answer
    page = browser.post(f"{PATH}/questions/l20", data={**form, "reponse": str(right)}).text
    assert "✓ Juste." in page
    assert "Terminer" in page
    assert answers(site)[-1] == ("calculation", True)
    assert 'id="deux-minutes"' not in browser.get("/").text
    assert "C’est tout pour aujourd’hui" in browser.get(PATH).text


def test_questions_about_a_mistake_are_of_each_possible_kind_in_turn() -> None:
    offer = OFFER.model_copy(update={"wrong_lines": 1})
    assert [choose_question_kind(offer, turn) for turn in range(4)] == ["hunt", "prediction", "line", "hunt"]
    alone = OFFER.model_copy(update={"predictable": False})
    assert [choose_question_kind(alone, turn) for turn in range(2)] == ["hunt", "hunt"]


def test_a_wrong_line_is_an_answer_and_giving_up_shows_the_lines(site: Site, process: Process) -> None:
    confuse_and_mend(site)
    age(site, 2)
    process.outcome = HuntTrialOutcome(expected="return a + b", got="return a - b")
    shown = site.client.post(PATH, data=DUE | {"question": "ligne", "valeur": ["1"]}).text
    assert "Ce n’est pas là" in shown
    assert answers(site) == [("line", False)]
    trial = process.asked[-1].hunts
    assert isinstance(trial, LineTrial)
    assert trial.line == 1
    site.client.post(PATH, data=DUE | {"question": "ligne", "valeur": ["1"], "action": "abandonner"})
    given_up = process.asked[-1].hunts
    assert isinstance(given_up, LineTrial)
    assert given_up.line == 0
    process.outcome = HuntTrialOutcome(refusal="Choisissez une ligne du programme.")
    assert "Choisissez une ligne" in site.client.post(PATH, data=DUE | {"question": "ligne", "valeur": ["x"]}).text
    assert answers(site) == [("line", False)] * 2
