"""The poses that `composer`, `inverse` and `relatif` are asked, simplest first."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments, Floats

QUARTER = math.pi / 2
PAIR = ("a", "b")
NAMES = {"composer": PAIR, "inverse": ("a",), "relatif": PAIR}


def pose(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def random_poses(rng: np.random.Generator, count: int, reach: float = 10.0) -> Floats:
    """Poses (count, 3) with x, y in [-reach, reach] and theta in [-pi, pi]."""
    limits = pose(reach, reach, math.pi)
    return np.asarray(-limits + 2.0 * limits * rng.random((count, 3)))


def random_pose(rng: np.random.Generator, reach: float = 10.0) -> Floats:
    return np.asarray(random_poses(rng, 1, reach)[0])


def simple_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Whole numbers and quarter turns whose sum stays within half a turn.

    The first call turns: a program that keeps its first rotation would otherwise look like one that forgets it.
    """
    yield pose(1, 2, QUARTER), pose(1, 0, 0)
    yield pose(0, 0, 0), pose(1, 2, QUARTER)
    yield pose(1, 2, 0), pose(3, 0, 0)
    yield pose(1, 2, QUARTER), pose(3, 1, -QUARTER)
    yield pose(0, 0, -QUARTER), pose(1, 2, 0)
    for _ in range(4):
        x1, y1, x2, y2 = rng.integers(-4, 5, 4)
        yield pose(x1, y1, -QUARTER), pose(x2 or 1, y2 or 2, (0.0, QUARTER)[rng.integers(2)])


def random_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Any two poses whose angles add up, and subtract, to less than half a turn: first to more than a quarter."""
    yield pose(1.5, -2.25, 1.2), pose(0.75, 2.5, 0.9)
    yield pose(-3.5, 1.25, -0.8), pose(2.75, -1.5, -1.3)
    drawn = random_poses(rng, 24)
    drawn[:, 2] /= 2.1
    yield from zip(drawn[::2], drawn[1::2], strict=True)


def wrapping_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Poses whose angles add up to more than half a turn, in both senses."""
    yield pose(0, 0, QUARTER), pose(0, 0, 3 * math.pi / 4)
    yield pose(1, 0, -QUARTER), pose(0, 1, -3 * math.pi / 4)
    yield pose(0, 0, math.pi), pose(1, 0, math.pi)
    for sign in (1, -1, 1, -1):
        a, b = random_pose(rng), random_pose(rng)
        a[2], b[2] = sign * rng.uniform(1.7, 3.1), sign * rng.uniform(1.7, 3.1)
        yield a, b


def single_poses(rng: np.random.Generator) -> Iterator[Arguments]:
    yield (pose(1, 0, QUARTER),)
    yield (pose(0, 0, 0),)
    yield (pose(1, 2, 0),)
    yield (pose(0, 0, QUARTER),)
    yield (pose(2, 1, -QUARTER),)
    yield (pose(1, 2, math.pi),)
    yield from ((drawn,) for drawn in random_poses(rng, 10))


def relative_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    yield pose(1, 2, QUARTER), pose(1, 3, QUARTER)
    yield pose(1, 2, 0), pose(1, 2, 0)
    yield pose(1, 2, 0), pose(3, 5, QUARTER)
    yield pose(2, 1, -QUARTER), pose(0, 1, 0)
    drawn = random_poses(rng, 20)
    yield from zip(drawn[::2], drawn[1::2], strict=True)
    for sign in (1, -1):
        yield pose(1, 1, 3.0 * sign), pose(-2, 4, -3.0 * sign)


def wraps(args: Arguments) -> bool:
    """Does the sum of the angles leave ]-pi, pi]?"""
    return bool(abs(args[0][2] + args[1][2]) > math.pi + 1e-6)


def stays(args: Arguments) -> bool:
    return not wraps(args)
