"""Who may hunt, what is asked of the process, and what is stored."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import pytest
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.assignments import feedback
from server.assignments.feedback import FeedbackHolds, WithholdingTest
from server.base.app_services import add_services, get_service
from server.course import Course
from server.grading.grading_task import GradingInput
from server.hunts.protocol import (
    HuntArgument,
    HuntName,
    HuntQuestion,
    HuntReply,
    HuntTrialOutcome,
    OfferedHunt,
    OfferRequest,
)
from server.hunts.service import HuntService, may_have_hunts
from server.recall.models import RecallAnswer
from tests.support.service import Site

HUNT = "/l20/exercices/poses/chasse"
ROTATION = HuntName(exercise="l20/poses", misconception="rotation_oubliee", function="composer")
OFFER = OfferedHunt(
    index=0, hunt=ROTATION, title="Rotation", program="def composer(a, b):\n    return a\n",
    arguments=(HuntArgument(name="a", words="une pose (3,)", witness="[0, 0, pi/2]"),), numbers=3, nonzero=1,
    predictable=True, returns="une pose (3,)",
)  # fmt: skip
TYPED = {"erreur": "rotation_oubliee", "fonction": "composer", "valeur": ["[1, 2, 3]"]}


@dataclass
class Process:
    """Runs nothing: offers one hunt, and judges as `outcome` says."""

    outcome: HuntTrialOutcome = field(default_factory=lambda: HuntTrialOutcome(is_right=True, expected="1", got="2"))
    asked: list[HuntQuestion] = field(default_factory=list)

    async def __call__(self, question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        self.asked.append(HuntQuestion.model_validate_json(question))
        is_offer = isinstance(self.asked[-1].hunts, OfferRequest)
        reply = HuntReply(offer=OFFER) if is_offer else HuntReply(outcome=self.outcome)
        return reply.model_dump_json().encode()


@pytest.fixture
def process(site: Site) -> Process:
    fake = Process()
    add_services(site.app, replace(get_service(site.app, HuntService), ask=fake))
    return fake


def right(sent: GradingInput) -> Judgement:
    check = CheckResult("a", "Première", True, 20, 20)
    return Judgement(Verdict(sent.exercise, "v1", Outcome.OK, sent.seed, [check]))


def solve(site: Site) -> None:
    site.client.post("/l20/exercices/poses/soumissions", data={"code": "x = 1\n"})
    worker = site.worker_with(right)
    while worker.run_one():
        pass


def test_a_hunt_opens_once_the_exercise_is_solved(site: Site, process: Process) -> None:
    assert site.client.get(HUNT).headers["location"].startswith("/connexion")
    site.client.post("/l20/exercices/odometrie/soumissions", data={"code": "x = 1\n"})  # a guest from here on
    refused = site.client.get(HUNT)
    assert refused.status_code == 403
    assert "Réussissez d’abord" in refused.text
    solve(site)
    page = site.client.get(HUNT).text
    assert "Trouvez une entrée qui le montre" in page
    assert "Rotation" not in page, "its mistake is not named before it is found"


def test_an_answer_is_stored_once_it_is_one(site: Site, process: Process) -> None:
    solve(site)
    process.outcome = HuntTrialOutcome(refusal="a : il manque un crochet", argument="a")
    page = site.client.post(HUNT, data=TYPED).text
    assert "il manque un crochet" in page
    assert 'value="[1, 2, 3]"' in page, "nothing typed is lost"
    process.outcome = HuntTrialOutcome(is_right=False, expected="1", got="1")
    assert "Pas encore" in site.client.post(HUNT, data=TYPED).text
    assert answers(site) == []
    process.outcome = HuntTrialOutcome(is_right=True, expected="1", got="2", small=True)
    page = site.client.post(HUNT, data=TYPED).text
    assert "aussi petite" in page
    assert re.search(r"La rotation", page), "its mistake is named once it is found"
    site.client.post(HUNT, data={**TYPED, "action": "abandonner"})
    process.outcome = HuntTrialOutcome(is_right=False, expected="1", got="2")
    site.client.post(HUNT, data={**TYPED, "question": "prevision"})
    assert answers(site) == [("hunt", True), ("hunt", False), ("prediction", False)]


def answers(site: Site) -> list[tuple[str, bool]]:
    with site.database.read() as db:
        rows = db.execute(select(RecallAnswer).order_by(RecallAnswer.answered_at)).scalars()
        return [(row.kind, row.is_right) for row in rows]


def test_no_hunt_during_a_test(site: Site, process: Process, monkeypatch: pytest.MonkeyPatch) -> None:
    solve(site)
    holding = WithholdingTest.__new__(WithholdingTest)
    object.__setattr__(holding, "title", "Contrôle 1")
    monkeypatch.setattr(feedback, "load_holds", lambda *_: FeedbackHolds(tests=(holding,)))
    for answer in (site.client.get(HUNT), site.client.post(HUNT, data=TYPED)):
        assert answer.status_code == 409
        assert "Contrôle 1" in answer.text
    assert process.asked == [], "no program ran"


def test_an_exercise_may_switch_its_hunts_off(course: Course) -> None:
    poses = course.exercises["l20/poses"]
    assert may_have_hunts(course, poses)
    assert not may_have_hunts(course, replace(poses, hunts="never"))
    assert not may_have_hunts(course, course.exercises["l20/association"])
    assert not may_have_hunts(course, course.exercises["l20/calcul_odometrie"])


@pytest.mark.parametrize("question", ["ligne", "prevision"])
def test_a_question_that_a_hunt_has_not_leads_to_that_for_an_input(site: Site, question: str) -> None:
    plain = OFFER.model_copy(update={"predictable": False})

    async def offer(_question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        return HuntReply(offer=plain).model_dump_json().encode()

    add_services(site.app, replace(get_service(site.app, HuntService), ask=offer))
    solve(site)
    assert "Trouvez une entrée qui le montre" in site.client.get(f"{HUNT}?question={question}").text
