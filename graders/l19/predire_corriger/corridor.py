"""A robot in a corridor: each step starts from the belief that the student's own functions gave for the one before."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.drawable import to_drawable_array
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.values import Value
from graders.l19.pairs import SamePair, read_pair
from graders.l19.predire_corriger.cases import APART
from graders.l19.predire_corriger.pictures import MEASURED, MOVED, belief_figure
from graders.l19.truth import moved, seen

NAMES = ("moyenne", "variance")
#: What steps may lose by rounding; single precision, told by the other checks, passes here whatever is drawn.
SAME = SamePair(NAMES, tolerance=1e-6)
START = (0.0, 25.0)


class Step(NamedTuple):
    """One call: the function and its last two arguments, (u, q) or (z, r)."""

    function: str
    value: float
    variance: float


def walk_on(bench: Bench) -> None:
    """A corridor by hand, then one that is drawn."""
    _follow(bench, START, by_hand())
    start = (float(np.round(bench.rng.uniform(-5.0, 5.0), 1)), float(np.round(bench.rng.uniform(1.0, 9.0), 1)))
    _follow(bench, start, list(_drawn(bench.rng, start)))


def by_hand() -> list[Step]:
    """Forwards, two readings in a row, a step without any, backwards."""
    return [
        Step("corriger", 1.0, 4.0),
        Step("predire", 2.0, 0.5),
        Step("corriger", 3.5, 2.0),
        Step("corriger", 2.5, 0.5),
        Step("predire", 2.0, 0.25),
        Step("predire", -1.5, 0.75),
        Step("corriger", 3.0, 1.5),
    ]


def _drawn(rng: np.random.Generator, belief: tuple[float, float]) -> Iterator[Step]:
    """Steps whose readings are well away from what is believed then."""
    place = 0.0
    for _ in range(8):
        u, q, r = np.round((rng.uniform(-1.0, 2.0), rng.uniform(0.1, 1.0), rng.uniform(0.2, 3.0)), 2)
        place += u
        belief = moved(*belief, float(u), float(q))
        z = float(np.round(place + rng.normal(), 2))
        while abs(z - belief[0]) < APART:
            z = float(np.round(place + 2.0 * rng.normal(), 2))
        belief = seen(*belief, z, float(r))
        yield Step("predire", float(u), float(q))
        yield Step("corriger", z, float(r))


def _follow(bench: Bench, start: tuple[float, float], steps: Sequence[Step]) -> None:
    """Raises Rejection at the first step after which the robot is not believed where it should."""
    believed = right = start
    for count, (function, value, variance) in enumerate(steps):
        right = (moved if function == "predire" else seen)(*right, value, variance)
        got = bench.call(function, *believed, value, variance)
        mismatch = SAME(right, got)
        bench.observe(function, got, ok=mismatch is None)
        if mismatch is not None:
            names = ("m", "v", *(("u", "q") if function == "predire" else ("z", "r")))
            args = (*believed, value, variance)
            wanted, obtained = value_text_pair(right, got)
            raise Rejection(
                f"{_place(count)} {function} : on attend {wanted} et l'on reçoit {obtained}. {mismatch.message}",
                inputs=dict(zip(names, args, strict=True)),
                expected=right,
                got=got,
                slip=mismatch.slip,
                cause=mismatch.cause,
                figure=belief_figure(
                    MOVED if function == "predire" else MEASURED, args, right, to_drawable_array(got, (2,))
                ),
            )
        believed = _floats(got)


def _place(count: int) -> str:
    """How far all was well."""
    if count < 2:
        return ("Dès le premier appel,", "Après un appel juste,")[count]
    return f"Après {count} appels justes,"


def _floats(value: Value) -> tuple[float, float]:
    mean, variance = read_pair(value, NAMES)
    return float(mean.item()), float(variance.item())
