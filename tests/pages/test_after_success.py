"""The page of remarks on a program that passes: for its author, and never against what a teacher holds back."""

from __future__ import annotations

from dataclasses import replace

import pytest

from server.assignments import feedback
from server.assignments.feedback import FeedbackHold, FeedbackHolds
from server.base.app_services import add_services, get_service
from server.hunts.protocol import HuntQuestion, HuntReply, ProgramRemark, ProgramReview
from server.hunts.service import HuntService
from tests.pages.test_notebook import Pupil
from tests.support.client import TestClient
from tests.support.service import Site

REMARK = ProgramRemark(line=3, sentence="`sum` est cachée.", before="sum = <1>", after="somme = <1>", gain=2.5)


async def review(question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
    assert "x = 2" in HuntQuestion.model_validate_json(question).model_dump_json()
    return HuntReply(review=ProgramReview(remarks=(REMARK,), ratio=3.25)).model_dump_json().encode()


@pytest.fixture
def pupil(site: Site) -> Pupil:
    add_services(site.app, replace(get_service(site.app, HuntService), ask=review))
    return Pupil(site, site.client)


def test_a_program_that_passes_is_told_what_to_write_otherwise(pupil: Pupil, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = pupil.send("poses", "x = 1  # rotation_oubliee\n")
    assert "/apres" not in pupil.read(wrong)
    assert pupil.client.get(f"{wrong}/apres").headers["location"] == wrong
    passed = pupil.send("poses", "x = 2\n")
    assert f'href="{passed}/apres"' in pupil.read(passed)
    page = pupil.read(f"{passed}/apres")
    assert "environ 3,2&nbsp;fois le temps de la référence" in page
    assert "2,5&nbsp;fois plus vite" in page
    assert "somme = &lt;1&gt;" in page
    assert page.count("Autrement") == 2, "two other ways"
    stranger = TestClient(pupil.site.app, follow_redirects=False)
    assert stranger.get(f"{passed}/apres").status_code == 404
    held = FeedbackHolds(solution=FeedbackHold("DM", None))
    monkeypatch.setattr(feedback, "load_holds", lambda db, account, exercise: held)
    assert "La référence" not in pupil.read(f"{passed}/apres"), "the solution is held back"
