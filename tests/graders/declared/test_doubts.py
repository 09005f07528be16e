"""What a proposed case has that no example has: asked of its author, or never proposed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing

import pytest

from graders.core.declared.brackets import DOUBT, find_bracket
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import read_declaration
from graders.core.declared.doubts import find_doubt, has_other_shape
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.playing import PlayedScenario, Player
from graders.core.declared.scenarios import Scenario
from graders.core.declared.tried_inputs import TriedInputs
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import Sandbox

from .conftest import POLICY
from .kinds import declare

BISECTION = """def f(g, a, b, eps):
    while b - a > eps:
        m = (a + b) / 2
        if g(a) * g(m) <= 0:
            b = m
        else:
            a = m
    return (a + b) / 2
"""
BISECTED = ("f(lambda x: x * x - 2, 0, 2, 1e-6)", "f(lambda x: x - 1, 0, 3, 1e-3)", "f(lambda x: x**3 - 5, 1, 2, 1e-6)")


def read(*texts: str) -> list[Scenario]:
    return [Scenario(parse_scenario(text, ["f"])) for text in texts]


@pytest.mark.parametrize(
    ("examples", "case", "words"),
    [
        (("f(1)", "f(2)"), "f(0)", "n n’est jamais nul"),
        (("f(-1)", "f(2)"), "f(0)", ""),
        (("f(1)", "f(2)"), "f(-1)", "n n’est jamais négatif"),
        (("f([1, 2])", "f([3])"), "f([-1, 0])", "n n’a jamais de nombre négatif"),
        (("f([-1])", "f([3])"), "f([-3, 0])", ""),
        (("f([[1, 2], [3, 4]])", "f([[1]])"), "f([[1, 2]])", "n est toujours un tableau carré"),
        (("f([[1, 2], [3, 4]])", "f([[1, 2]])"), "f([[1], [2]])", ""),
        (("f(lambda x: x, lambda x: 1)",) * 2, "f(lambda x: x, lambda x: 1)", ""),
        (("f(lambda x: x, lambda x: 1)",) * 2, "f(lambda x: x, lambda x: 2)", "ne donne n et p ensemble"),
    ],
)
def test_what_no_example_has_is_asked(examples: tuple[str, ...], case: str, words: str) -> None:
    doubt = find_doubt(read(case)[0], read(*examples), ("n", "p"))
    assert words in doubt
    assert bool(doubt) is bool(words)


@pytest.mark.parametrize(
    ("examples", "case", "is_other"),
    [
        (("f([1, 2])", "f([])"), "f([[1, 2], [3, 4]])", True),
        (("f([1, 2])", "f([])"), "f([3])", False),
        (("f([[1, 2], [3, 4]])", "f([[1, 2, 3]])"), "f([[1], [3, 4]])", True),
        (("f([[1, 2], [3]])", "f([[1]])"), "f([[1], [3, 4]])", False),
        (("f([[1, 2]])",), "f([1])", False),
    ],
)
def test_a_case_of_another_shape_is_none(examples: tuple[str, ...], case: str, is_other: bool) -> None:
    assert has_other_shape(read(case)[0], read(*examples)) is is_other


@pytest.mark.parametrize(
    ("examples", "found"),
    [
        (BISECTED, (0, 1, 2)),
        (BISECTED[:1], None),
        (("f(1, 2)", "f(2, 3)"), None),
        ((*BISECTED, "f(lambda x: x, 3, 1, 1e-3)"), None),
    ],
)
def test_a_function_and_an_interval_are_found(examples: tuple[str, ...], found: tuple[int, int, int] | None) -> None:
    bracket = find_bracket(read(*examples), ("g", "a", "b", "eps"))
    assert (bracket and (bracket.function, bracket.low, bracket.high)) == found


@pytest.mark.parametrize(
    ("last", "asks"), [("f(lambda x: x - 7, 6, 9, 1e-3)", True), ("f(lambda x: x, 1, 2, 1e-3)", False)]
)
def test_a_bisection_is_proposed_where_its_function_changes_sign(sandbox: Sandbox, last: str, asks: bool) -> None:
    """An interval elsewhere is as good, whatever its signs; without a change of sign, its author is asked."""
    grader = DeclaredGrader("essai/un", read_declaration(declare("f", BISECTION, *BISECTED, last)))

    def play(tried: DeclaredGrader, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        with closing(Player(SandboxPrograms(sandbox, POLICY), tried.solution.encode(), tried.kit(1))) as player:
            return player.play(scenarios)

    inputs = TriedInputs(grader, play, play)
    doubts = {
        case.scenario.text(): inputs.describe_case(at, case, right).doubt for at, case, right in inputs.near_cases
    }
    words = DOUBT.format(function="g", low="a", high="b")
    assert (words in doubts.values()) is asks
    assert any("-3, -1" in text and not doubt for text, doubt in doubts.items()) is asks
