"""What is kept of a verdict as it was shown: the same page as if it were laid out anew, whoever asks."""

from __future__ import annotations

import pytest

from server.identity.models import Role
from server.pages import rendered_verdict
from tests.support.classes import new_class, person, seat
from tests.support.service import EXERCISE, Site

WRONG = "x = 1  # outcome: wrong_answer"
PAGE, ASK = "/l20/exercices/poses", "Je ne comprends pas cette vérification"


def send(site: Site, headers: dict[str, str], code: str) -> str:
    answer = site.client.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": code}, headers=headers)
    assert answer.status_code == 202, answer.text
    assert site.worker.run_one()
    return f"/soumissions/{answer.json()['id']}"


def test_it_is_laid_out_once_and_anew_for_what_else_is_said(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    laid_out: list[object] = []
    view = rendered_verdict._verdict_view

    def counted(*arguments: object) -> object:
        laid_out.append(arguments)
        return view(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(rendered_verdict, "_verdict_view", counted)
    ada, teacher = person(site), person(site, Role.teacher)
    own = ada.browser(site)
    path = send(site, ada.headers, WRONG)
    pages = {own.get(path).text for _ in range(3)}
    assert len(laid_out) == 1
    rendered_verdict._KEPT.clear()
    pages.add(own.get(path).text)
    assert len(pages) == 1, "what is kept is what would be written"
    assert len(laid_out) == 2
    assert ASK not in pages.pop()
    seat(site.database, new_class(site.database, teacher.account), ada.account)
    assert ASK in own.get(path).text, "somebody would read the question now"
    assert len(laid_out) == 3
    assert ASK not in teacher.browser(site).get(path).text
    other = send(site, ada.headers, WRONG.replace("x = 1", "x = 2"))
    assert "Essai n° 2" in own.get(other).text
    assert "Essai n° 1" in own.get(path).text
    assert "Essai n° 2" in own.get(PAGE).text
