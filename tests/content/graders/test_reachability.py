"""What a function of a model reaches: what it answers depends on nothing else."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from graders.core.code.mutants import MutantAnswerCache
from graders.core.code.probes import ProbeAnswer, ProbeFault, Probes
from graders.core.code.reachability import PIECE_SEPARATOR, reachable_code_pieces
from graders.core.contract.local import call_function, initial_globals
from tests.support.quick import only
from tests.support.shipped import CODE


def test_what_is_mentioned_is_reached_however_deep() -> None:
    pieces = [
        "import math\nfrom os import path as chemin",
        "LIMIT = math.pi",
        "def wrap(angle):\n    return angle % LIMIT",
        "def alone(x):\n    return chemin",
        "def asked(xs, f=lambda x: (lambda y: wrap(y))(x)):\n    return [f(x) for x in xs]",
        "class Other:\n    def go(self):\n        return Base",
        "class Base:\n    pass",
    ]
    text = PIECE_SEPARATOR.join(pieces)
    kept = {
        name: [pieces.index(piece.text) for piece in reachable_code_pieces(text, name)]
        for name in ("asked", "alone", "Other")
    }
    assert kept == {"asked": [0, 1, 2, 4], "alone": [0, 1, 3], "Other": [5, 6]}, (
        "one too many: LIMIT mentions `math` too"
    )
    assert reachable_code_pieces(text, "nobody") == ()


def test_what_is_made_twice_is_kept_twice_in_its_order() -> None:
    text = PIECE_SEPARATOR.join(["def f(x):\n    return x", "right = f", "def f(x):\n    return -right(x)"])
    assert len(reachable_code_pieces(text, "f")) == 3


def _by_the_whole_text(text: str, probes: Probes) -> ProbeAnswer:
    names: dict[str, Any] = {"__name__": "mutant", **initial_globals(probes.kit), **probes.given}
    exec(compile(text, "<whole>", "exec", dont_inherit=True), names)
    args = probes.calls[0]
    try:
        value = call_function(names, probes.function, copy.deepcopy(args))
    except Exception as error:
        return ProbeFault(type(error).__name__)
    return probes.read(args, value)


#: One of each form: functions that call each other, the functions of a loop, a class, constants of a kit.
FORMS = ("l20/poses", "l20/slam_graphe", "l20/noeud_ros", "l20/predire2d")


@pytest.mark.parametrize("name", only(FORMS, CODE))
def test_the_whole_text_answers_as_what_is_reached_of_it(name: str) -> None:
    """The last of those that share their answers, which the first has given; of a few, that it costs little."""
    prober = CODE[name].prober
    if prober is None:
        pytest.skip("it has no prober")
    mutants = MutantAnswerCache(prober.model, prober.probes, ())
    for index, probes in enumerate(prober.probes):
        rows = [*mutants.mutants_with(index, 0), *mutants.mutants_with(index, 1)]
        first, last = ({row.stored: row for row in some} for some in (reversed(rows), rows))
        for told, row in list(first.items())[::40]:
            answer = mutants._answer_at(index, row, 0)
            assert probes.same(_by_the_whole_text(last[told].mutant.text, probes), answer), last[told].mutant.ids
