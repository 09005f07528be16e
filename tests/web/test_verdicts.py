"""Verdicts of the graders that are shipped, as they are shown: every shape that they use has its place on the page."""

from __future__ import annotations

import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.course import FunctionSpec
from server.web import verdicts
from server.web.rendering import jinja_environment
from tests.support.small_site import CHECK

SHOW = '{% from "verdict.html" import show_verdict %}{{ show_verdict(verdict, 1) }}'


PAIR = [FunctionSpec("kabsch", "kabsch(P, Q)", "", "", ("R", "t")), FunctionSpec("f", "f(x)", "", "")]


@pytest.mark.parametrize(
    ("inputs", "expected", "names"),
    [
        ({"P": [[1.0, 2.0]], "Q": [[1.0, 2.0]]}, [[[1.0, 0.0], [0.0, 1.0]], [3.0, 4.0]], ["R", "t"]),
        ({"P": [[1.0, 2.0]]}, [[1.0, 0.0], [0.0, 1.0]], []),
        ({"x": 1}, [[[1.0, 0.0], [0.0, 1.0]], [3.0, 4.0]], ["", ""]),
    ],
    ids=["a pair", "a matrix of two rows", "another function"],
)
def test_what_is_returned_together_is_named(inputs: dict[str, object], expected: object, names: list[str]) -> None:
    counterexample = {"inputs": inputs, "expected": expected, "got": expected}
    check = CheckResult.from_json({**CHECK, "counterexample": counterexample})
    view = verdicts.build_verdict_view(
        Verdict("m9/a", "abc", Outcome.WRONG_ANSWER, 1, [check]), "/figures", functions=PAIR
    )
    example = view.checks[0].counterexample
    assert example is not None
    for value in (example.expected, example.got):
        assert value is not None
        assert [name for name, _ in value.items] == names


@pytest.mark.parametrize(("which", "buttons"), [((), 0), ((CHECK["id"],), 1), (("another",), 0)])
def test_what_can_be_replayed_is_offered_under_its_counterexample(which: tuple[str, ...], buttons: int) -> None:
    check = CheckResult.from_json({**CHECK, "counterexample": {"inputs": {"x": 1}, "expected": 1, "got": 2}})
    verdict = Verdict("m9/a", "abc", Outcome.WRONG_ANSWER, 1, [check])
    view = verdicts.build_verdict_view(verdict, "/figures", replayed=("/soumissions/1/pas", which))
    html = jinja_environment().from_string(SHOW).render(verdict=view)
    assert html.count(f'data-steps="/soumissions/1/pas" data-check="{check.id}"') == buttons


def test_what_a_right_program_measured_is_read_without_a_click() -> None:
    check = CheckResult("a", "Le graphe", True, 20, 20, "L’ATE passe de 0,19 m à 0,10 m.")
    view = verdicts.build_verdict_view(Verdict("m9/a", "abc", Outcome.OK, 1, [check]), "/figures")
    html = jinja_environment().from_string(SHOW).render(verdict=view)
    assert '</div><p class="check-why small">L’ATE passe de' in html
