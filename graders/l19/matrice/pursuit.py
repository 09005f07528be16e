"""A wagon on rails: each call starts from the belief that the student's own functions gave for the one before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Arguments, Floats
from graders.l19.matrice.pictures import drawn_pair
from graders.l19.matrices import matrix, vector
from graders.l19.pairs import SamePair, read_pair
from graders.l19.truth import Belief, corrected, predicted

NAMES = ("état", "covariance")
#: What steps may lose by rounding, each exact to 1e-9; one in single precision always loses more.
SAME = SamePair(NAMES, tolerance=2e-8)
ARGUMENTS = {"predire": ("x", "P", "F", "Q"), "corriger": ("x", "P", "z", "H", "R")}
START: Belief = (vector(0, 0), matrix((4, 0), (0, 9)))


class Rails(NamedTuple):
    """A wagon whose position alone is read, and what is read after each step, None where nothing is."""

    F: Floats
    Q: Floats
    H: Floats
    R: Floats
    read: Sequence[float | None]


def by_hand() -> Rails:
    return Rails(
        matrix((1, 0.5), (0, 1)), matrix((0.02, 0.04), (0.04, 0.1)), matrix((1, 0)), matrix((0.5,)),
        (0.4, 1.3, 1.1, None, None, 3.2, 3.4, 4.5, None, 5.1),
    )  # fmt: skip


def drawn(rng: np.random.Generator) -> Rails:
    step = float(np.round(rng.uniform(0.2, 1.0), 1))
    noise = np.round(rng.uniform(0.1, 0.6), 2)
    Q = noise * matrix((step**3 / 3.0, step**2 / 2.0), (step**2 / 2.0, step))
    read = np.round(np.cumsum(rng.normal(1.0, 0.5, 10)), 2).tolist()
    return Rails(
        matrix((1, step), (0, 1)), Q, matrix((1, 0)), matrix((float(np.round(rng.uniform(0.2, 2.0), 1)),)), read
    )


def follow(bench: Bench) -> None:
    """A wagon by hand, then one that is drawn."""
    _follow(bench, by_hand())
    _follow(bench, drawn(bench.rng))


def _follow(bench: Bench, rails: Rails) -> None:
    """Raises Rejection at the first call after which the wagon is not believed where it should."""
    believed, right, calls = START, START, 0
    for read in rails.read:
        for function in ("predire", "corriger")[: 1 if read is None else 2]:
            given = (rails.F, rails.Q) if function == "predire" else (np.array([read]), rails.H, rails.R)
            right = predicted(*right, *given) if function == "predire" else corrected(*right, *given)
            args: Arguments = (*believed, *given)
            got = bench.call(function, *args)
            mismatch = SAME(right, got)
            bench.observe(function, got, ok=mismatch is None)
            if mismatch is not None:
                raise Rejection(
                    f"{_place(calls, function)} {mismatch.message}",
                    inputs=dict(zip(ARGUMENTS[function], args, strict=True)),
                    expected=right,
                    got=got,
                    slip=mismatch.slip,
                    cause=mismatch.cause,
                    figure=drawn_pair(function, args, right, got),
                )
            x, P = read_pair(got, NAMES)
            believed, calls = (x, P), calls + 1


def _place(calls: int, function: str) -> str:
    """How far all was well."""
    if calls == 0:
        return f"Dès le premier appel, {function} se trompe."
    before = "Le premier appel est juste" if calls == 1 else f"Les {calls} premiers appels sont justes"
    return f"{before} ; le suivant, {function}, ne l'est pas."
