"""A mistake of each exercise, as its verdict is shown: every shape that graders use has its place on the page."""

from __future__ import annotations

import json

import pytest

from graders.core.contract.local import LOCAL
from graders.core.contract.verdict import Verdict
from server.web import verdicts
from server.web.rendering import jinja_environment
from tests.support.quick import one_in
from tests.support.shipped import CODE

SHOW = '{% from "verdict.html" import show_verdict %}{{ show_verdict(verdict, 1) }}'


@pytest.mark.parametrize("exercise", one_in(3, CODE))
def test_a_named_mistake_is_shown_with_all_that_explains_it(exercise: str) -> None:
    grader = CODE[exercise]
    mistake = grader.misconceptions[0]
    grading = grader.grade(mistake.source.encode(), LOCAL, seed=1, version="0")
    stored = json.loads(json.dumps(grading.verdict.to_json(), allow_nan=False))
    verdict = verdicts.build_verdict_view(Verdict.from_json(stored), "/figures")
    html = jinja_environment().from_string(SHOW).render(verdict=verdict)
    assert verdict.diagnosis is not None
    assert len(verdict.diagnosis.paragraphs) >= 2
    assert any(check.counterexample for check in verdict.checks)
    assert {check.figure.light for check in verdict.checks if check.figure} == {
        f"/figures/{name}.svg?theme=light" for name in grading.figures
    }
    for heading in ("Donné", "Attendu", "Obtenu", "Erreur reconnue"):
        assert heading in html
