"""The beliefs that submissions are graded on: first by hand, so that known mistakes fail whatever is drawn, then drawn.

No variance is 0 but q, as the statement says; none is 1 where a square or a root would then go unseen.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments, Floats

#: How far a drawn reading is from what was believed.
APART = 0.3


def moves_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    yield 2.0, 4.0, 3.0, 0.5
    yield 1.0, 0.25, -4.0, 9.0
    yield -3.0, 2.0, 1.0, 0.0
    yield 0.0, 9.0, 0.0, 16.0


def any_moves(rng: np.random.Generator) -> Iterator[Arguments]:
    yield -7.25, 0.36, 2.5, 1.69
    yield 12.5, 6.25, -0.75, 0.04
    yield -120.0, 1e-4, -75.0, 3e-4
    yield 900.0, 400.0, -1500.0, 2500.0
    for _ in range(8):
        m, u = np.round(rng.uniform(-9.0, 9.0, 2), 2) + 0.0
        v, q = np.round(rng.uniform(0.05, 8.0, 2), 2)
        yield float(m), float(v), float(u), float(q)


def readings_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """A good sensor, a poor one, two of the same worth, one that is much better than what was believed, one
    that reads what was believed."""
    yield 10.0, 4.0, 12.0, 1.0
    yield 10.0, 2.0, 18.0, 6.0
    yield -2.0, 3.0, 4.0, 3.0
    yield 5.0, 9.0, -1.0, 0.25
    yield 0.0, 0.5, 8.0, 4.5
    yield 3.0, 0.75, 3.0, 0.25


def any_readings(rng: np.random.Generator) -> Iterator[Arguments]:
    yield -4.5, 0.36, -3.25, 2.25
    yield 7.75, 5.29, 6.5, 0.09
    yield -120.0, 1e-4, 95.0, 3e-4
    yield 10.0, 900.0, -400.0, 1600.0
    for _ in range(8):
        m, z = _apart(rng)
        v, r = np.round(rng.uniform(0.05, 8.0, 2), 2)
        yield float(m), float(v), float(z), float(r)


def _apart(rng: np.random.Generator) -> Floats:
    """A mean and a reading that is well away from it: what happens near it is judged by hand."""
    while True:
        pair: Floats = np.round(rng.uniform(-9.0, 9.0, 2), 2) + 0.0
        if abs(pair[1] - pair[0]) > APART:
            return pair


def is_telling_move(args: Arguments) -> bool:
    """Is it a step that the statement allows, where something moves?"""
    return bool(args[1] > 0.0 and args[3] >= 0.0 and args[2] != 0.0)


def is_telling_reading(args: Arguments) -> bool:
    """Is it a reading that the statement allows, and that says something new?"""
    return bool(args[1] > 0.0 and args[3] > 0.0 and args[0] != args[2])
