"""A robot among three beacons: each correction starts from what the student's own function gave for the one before."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Arguments, Floats
from graders.l19.etendu.pictures import STATE, drawn_reading
from graders.l19.etendu.truth import right_correction
from graders.l19.matrices import matrix, vector
from graders.l19.pairs import SamePair, read_pair

NAMES = ("x", "P", "z", "balise", "r")
#: A derivative by small differences stays within 4e-7 over both walks; roundings to four decimals do not, at any seed.
SAME = SamePair(STATE, tolerance=1e-5)
BEACONS = (vector(-1, 6), vector(8, 5), vector(5, -2))


class Walk(NamedTuple):
    """Displacements (n, 2), each followed by a reading of every beacon, (n, 3)."""

    start: Floats
    doubt: Floats
    moves: Floats
    readings: Floats
    noise: float
    r: float


def by_hand() -> Walk:
    return Walk(
        vector(0.5, 1.0),
        matrix((4, 1), (1, 2)),
        matrix((1, 0.5), (1.5, 0.25), (0.5, 1)),
        matrix((4.9, 7.1, 4.3), (5.6, 5.4, 4.6), (5.4, 4.7, 5.1)),
        0.05,
        0.3,
    )


def drawn(rng: np.random.Generator) -> Walk:
    """A robot that is at first believed about a metre away from where it is."""
    moves = np.round(rng.uniform(0.2, 1.0, (4, 2)), 2)
    true = vector(1, 0.5) + np.cumsum(moves, axis=0)
    ranges = np.linalg.norm(true[:, None, :] - np.array(BEACONS)[None], axis=2)
    readings = np.round(ranges + 0.2 * rng.normal(size=ranges.shape), 2)
    start = np.round(vector(1, 0.5) + rng.uniform(-0.7, 0.7, 2), 2)
    return Walk(start, matrix((1, 0.2), (0.2, 0.8)), moves, readings, 0.02, 0.04)


def walk_on(bench: Bench) -> None:
    """A walk by hand, then one that is drawn."""
    _follow(bench, by_hand())
    _follow(bench, drawn(bench.rng))


def _follow(bench: Bench, walk: Walk) -> None:
    """Raises Rejection at the first correction after which the robot is not believed where it should."""
    believed = right = (walk.start, walk.doubt)
    calls = 0
    for move, readings in zip(walk.moves, walk.readings.tolist(), strict=True):
        more = walk.noise * np.eye(2)
        believed, right = (believed[0] + move, believed[1] + more), (right[0] + move, right[1] + more)
        for beacon, z in zip(BEACONS, readings, strict=True):
            args: Arguments = (*believed, z, beacon, walk.r)
            right = right_correction(*right, z, beacon, walk.r)
            got = bench.call("corriger_distance", *args)
            mismatch = SAME(right, got)
            bench.observe("corriger_distance", got, ok=mismatch is None)
            if mismatch is not None:
                raise Rejection(
                    f"{_place(calls)} {mismatch.message}",
                    inputs=dict(zip(NAMES, args, strict=True)),
                    expected=right,
                    got=got,
                    slip=mismatch.slip,
                    cause=mismatch.cause,
                    figure=drawn_reading(args, right, got),
                )
            x, P = read_pair(got, STATE)
            believed, calls = (x, P), calls + 1


def _place(calls: int) -> str:
    """How far all was well."""
    if calls == 0:
        return "Dès la première balise."
    before = "La première correction est juste" if calls == 1 else f"Les {calls} premières corrections sont justes"
    return f"{before}, pas la suivante."
