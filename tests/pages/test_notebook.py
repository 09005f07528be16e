"""The notebook of mistakes, and a mistake met again in another exercise."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import timedelta
from uuid import uuid4

import pytest

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict
from server.assignments import feedback
from server.assignments.feedback import FeedbackHold, FeedbackHolds
from server.database import utc_now
from server.gradebook.histories import GradedAttempt
from server.gradebook.mistakes import iter_past_mistakes
from server.grading.grading_task import GradingInput
from tests.support.client import TestClient
from tests.support.service import Site

NOTEBOOK = "/compte/carnet-d-erreurs"


def graded(sent: GradingInput) -> Judgement:
    """A program says which mistake it makes (`# mistake`), and is right where it says none."""
    mistake = re.search(r"# (\w+)", sent.source.decode())
    outcome = Outcome.WRONG_ANSWER if mistake else Outcome.OK
    check = CheckResult("a", "Première", mistake is None, 0 if mistake else 20, 20)
    named = Diagnosis(mistake[1], "L’erreur", "Pourquoi.") if mistake else None
    return Judgement(Verdict(sent.exercise, "v1", outcome, sent.seed, [check], diagnosis=named))


@dataclass
class Pupil:
    site: Site
    client: TestClient

    def send(self, exercise: str, code: str) -> str:
        """Send a program and have it graded; return the address of the attempt."""
        address = f"/l20/exercices/{exercise}/soumissions"
        sent = self.client.post(address, data={"code": code}, headers={"Accept": "application/json"}).json()
        assert self.site.worker_with(graded).run_one()
        return str(sent["page"])

    def read(self, path: str) -> str:
        answer = self.client.get(path)
        assert answer.status_code == 200, answer.text
        return re.sub(r"\s+", " ", answer.text)


@pytest.fixture
def pupil(site: Site) -> Pupil:
    return Pupil(site, site.client)


def test_a_mistake_met_again_leads_to_its_correction(pupil: Pupil) -> None:
    wrong = pupil.send("odometrie", "cap = cap + delta  # angle_jamais_ramene\n")
    assert "voir votre correction" not in pupil.read(pupil.send("poses", "1  # angle_jamais_ramene\n")), (
        "not mended yet"
    )
    pupil.send("odometrie", "cap = ramener(cap + delta)\n")
    again = pupil.read(pupil.send("slam_graphe", "2  # erreur_non_ramenee\n"))
    assert "Vous aviez déjà rencontré cette erreur" in again
    assert f'href="{wrong}/correction"' in again
    recalled = again.split('class="recalled"')[1]
    assert recalled.index("cap = cap + delta") < recalled.index("cap = ramener(cap + delta)"), "their own lines of then"
    page = pupil.read(f"{wrong}/correction")
    assert "De l’essai n° 1 à l’essai n° 2" in page
    assert "cap = cap + delta" in page
    assert "cap = ramener(cap + delta)" in page
    other = pupil.read(pupil.send("slam_graphe", "3  # jauge_libre\n"))
    assert "voir votre correction" not in other, "another family"


def test_nothing_to_compare_leads_to_the_attempt(pupil: Pupil) -> None:
    wrong = pupil.send("odometrie", "1  # angle_jamais_ramene\n")
    answer = pupil.client.get(f"{wrong}/correction")
    assert (answer.status_code, answer.headers["location"]) == (303, wrong)
    stranger = TestClient(pupil.site.app, follow_redirects=False)
    assert stranger.get(f"{wrong}/correction").status_code == 404


def test_the_notebook_lists_one_s_own_mistakes_by_family(pupil: Pupil) -> None:
    assert pupil.client.get(NOTEBOOK).headers["location"] == f"/connexion?suite={NOTEBOOK}"
    pupil.send("poses", "1\n")
    assert "Aucune erreur n’a été reconnue" in pupil.read(NOTEBOOK)
    first = pupil.send("odometrie", "cap = a  # angle_jamais_ramene\n")
    pupil.send("odometrie", "cap = ramener(a)\n")
    pupil.send("slam_graphe", "x = 1  # erreur_non_ramenee\n")
    pupil.send("slam_graphe", "x = 2  # jauge_libre\n")
    page = pupil.read(NOTEBOOK)
    assert "3 erreurs, dont 2 à corriger" in page
    assert page.count("Un angle n’est pas ramené dans") == 1, "one heading for both exercises"
    assert "cap = ramener(a)" in page
    assert f'href="{first}/correction"' in page
    assert "Mon carnet d’erreurs" in pupil.read("/")
    stranger = Pupil(pupil.site, TestClient(pupil.site.app, follow_redirects=False))
    stranger.send("poses", "1\n")
    assert "Aucune erreur" in stranger.read(NOTEBOOK)


@pytest.mark.parametrize("hold", [FeedbackHolds(diagnosis=FeedbackHold("DM", None))], ids=["diagnosis"])
def test_a_mistake_that_is_held_back_is_not_told(
    pupil: Pupil, monkeypatch: pytest.MonkeyPatch, hold: FeedbackHolds
) -> None:
    pupil.send("odometrie", "cap = a  # angle_jamais_ramene\n")
    pupil.send("odometrie", "cap = ramener(a)\n")
    monkeypatch.setattr(feedback, "load_holds_by_exercise", lambda db, account: {"l20/odometrie": hold})
    assert "Aucune erreur" in pupil.read(NOTEBOOK)
    assert "correction d’alors" not in pupil.read(pupil.send("poses", "1  # angle_jamais_ramene\n"))


def test_a_worse_attempt_mends_nothing() -> None:
    start, account = utc_now(), uuid4()
    scores = [(0.2, "a"), (0.0, None), (0.2, "b"), (0.5, None)]
    attempts = [
        GradedAttempt(uuid4(), start + timedelta(minutes=n), score, account, "e", "", "", name, uuid4())
        for n, (score, name) in enumerate(scores)
    ]
    mended = {mistake.misconception: mistake.mended for mistake in iter_past_mistakes(attempts)}
    assert mended == {"a": attempts[3], "b": attempts[3]}
    assert [mistake.mended for mistake in iter_past_mistakes(attempts[:3])] == [None, None]


@pytest.mark.parametrize("path", [NOTEBOOK, "/administration/journal"])
def test_the_number_of_a_page_is_refused_outside_its_bounds(site: Site, path: str) -> None:
    assert [site.client.get(f"{path}?page={number}").status_code for number in ("0", "1000001", "x")] == [422] * 3
    assert site.client.get(f"{path}?page=1000000").status_code < 400
