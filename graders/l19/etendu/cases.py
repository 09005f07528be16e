"""Positions, beacons and readings that submissions are graded on: right triangles by hand first, then any.

No beacon by hand is at the origin, no displacement has equal components, and none is seen along an axis alone.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments, Floats
from graders.l19.matrices import drawn_covariance, is_covariance, matrix, vector

#: How near to a beacon a position is ever judged: there the distance has no derivative.
NEAREST = 0.5


def places_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    yield vector(4, 6), vector(1, 2)
    yield vector(1, 0), vector(13, 5)
    yield vector(-2, 1), vector(-6, 4)
    yield vector(2, -3), vector(2, -1)
    yield vector(0.36, 0.48), vector(0, 0)
    yield vector(250, -100), vector(10, -30)


def any_places(rng: np.random.Generator) -> Iterator[Arguments]:
    yield vector(1.25, -2.5), vector(3.75, 0.5)
    yield vector(-0.8, 4.1), vector(-2.3, 6.9)
    for _ in range(6):
        x = _place(rng)
        yield x, _beacon(rng, x)


def places(rng: np.random.Generator) -> Iterator[Arguments]:
    yield from places_by_hand(rng)
    yield from any_places(rng)


def readings(rng: np.random.Generator) -> Iterator[Arguments]:
    yield from readings_by_hand(rng)
    yield from any_readings(rng)


def readings_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Farther than believed, then nearer; a good sensor and a poor one; a doubt that leans."""
    yield vector(4, 6), matrix((4, 0), (0, 4)), 6.0, vector(1, 2), 1.0
    yield vector(1, 0), matrix((2, 1), (1, 3)), 11.0, vector(13, 5), 0.25
    yield vector(-2, 1), matrix((9, -2), (-2, 1)), 5.5, vector(-6, 4), 4.0
    yield vector(0, 2), matrix((1, 0.5), (0.5, 2)), 2.5, vector(3, -2), 0.5
    # Far from what was believed, farther and nearer; a beacon that is close; a sensor that is worth little.
    yield vector(4, 6), matrix((4, 1), (1, 3)), 20.0, vector(1, 2), 1.0
    yield vector(4, 6), matrix((4, 1), (1, 3)), 0.25, vector(1, 2), 1.0
    yield vector(0.36, 0.48), matrix((0.5, 0.1), (0.1, 0.25)), 1.5, vector(0, 0), 0.04
    yield vector(-2, 1), matrix((9, -2), (-2, 1)), 6.5, vector(-6, 4), 40.0


def any_readings(rng: np.random.Generator) -> Iterator[Arguments]:
    yield vector(1.25, -2.5), matrix((0.6, 0.2), (0.2, 1.5)), 4.4, vector(3.75, 0.5), 0.09
    yield vector(-3.2, 0.7), matrix((2.1, -0.9), (-0.9, 1.3)), 2.1, vector(-1.4, -1.9), 2.6
    for _ in range(6):
        x = _place(rng)
        balise = _beacon(rng, x)
        seen = np.linalg.norm(x - balise) + rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 0.9)
        P = drawn_covariance(rng, 2, 0.6)
        yield x, P, float(np.round(max(seen, 0.2), 2)), balise, float(np.round(rng.uniform(0.05, 3.0), 2))


def _place(rng: np.random.Generator) -> Floats:
    return np.asarray(np.round(rng.uniform(-6.0, 6.0, 2), 2) + 0.0)


def _beacon(rng: np.random.Generator, x: Floats) -> Floats:
    while True:
        beacon = _place(rng)
        if np.linalg.norm(x - beacon) > 2.0 * NEAREST:
            return beacon


def is_place(args: Arguments) -> bool:
    x, beacon = args
    return bool(np.linalg.norm(x - beacon) >= NEAREST)


def is_reading(args: Arguments) -> bool:
    """Is it a reading that the statement allows, and that says something new?"""
    x, P, z, beacon, r = args
    d = float(np.linalg.norm(x - beacon))
    return d >= NEAREST and z > 0.0 and r > 0.0 and abs(z - d) > 0.1 and is_covariance(P)
