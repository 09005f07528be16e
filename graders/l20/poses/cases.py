"""The poses that `composer`, `inverse` and `relatif` are asked, simplest first."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graders.core.contract.rows import Rows
from graders.core.contract.values import Arguments, Floats

QUARTER = math.pi / 2
PAIR = ("a", "b")
NAMES = {"composer": PAIR, "inverse": ("a",), "relatif": PAIR}


def by_hand(poses: Sequence[object]) -> Floats:
    """The same for every grading, so that nothing may be written there."""
    made = np.array(poses, dtype=np.float64)
    made.flags.writeable = False
    return made


SIMPLE = by_hand(
    (
        ((1, 2, QUARTER), (1, 0, 0)),
        ((0, 0, 0), (1, 2, QUARTER)),
        ((1, 2, 0), (3, 0, 0)),
        ((1, 2, QUARTER), (3, 1, -QUARTER)),
        ((0, 0, -QUARTER), (1, 2, 0)),
    )
)
TURNED = by_hand((((1.5, -2.25, 1.2), (0.75, 2.5, 0.9)), ((-3.5, 1.25, -0.8), (2.75, -1.5, -1.3))))
WRAPPING = by_hand(
    (
        ((0, 0, QUARTER), (0, 0, 3 * math.pi / 4)),
        ((1, 0, -QUARTER), (0, 1, -3 * math.pi / 4)),
        ((0, 0, math.pi), (1, 0, math.pi)),
        ((2, 1, QUARTER), (1, 0, QUARTER)),
        ((2, 1, -QUARTER), (1, 0, -QUARTER)),
    )
)
SENSES = by_hand(((1,), (-1,), (1,), (-1,)))
SINGLE = by_hand(
    ((1, 0, QUARTER), (0, 0, 0), (1, 2, 0), (0, 0, QUARTER), (2, 1, -QUARTER), (1, 2, math.pi), (2, 1, -3.12))
)
NEAR = by_hand(
    (
        ((1, 2, QUARTER), (1, 3, QUARTER)),
        ((1, 2, 0), (1, 2, 0)),
        ((1, 2, QUARTER), (1, 2, QUARTER)),
        ((1, 2, 0), (3, 5, QUARTER)),
        ((2, 1, -QUARTER), (0, 1, 0)),
        ((2, 1, -QUARTER), (0, 1, QUARTER)),
    )
)
FAR_ROUND = by_hand((((1, 1, 3.0), (-2, 4, -3.0)), ((1, 1, -3.0), (-2, 4, 3.0))))


def pose(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def random_poses(rng: np.random.Generator, count: int, reach: float = 10.0) -> Floats:
    """Poses (count, 3) with x, y in [-reach, reach] and theta in [-pi, pi]."""
    return _within(rng.random((count, 3)), reach)


def _within(drawn: Floats, reach: float) -> Floats:
    """What is drawn in [0, 1[ (…, 3), as poses."""
    limits = pose(reach, reach, math.pi)
    return np.asarray(-limits + 2.0 * limits * drawn)


def random_pose(rng: np.random.Generator, reach: float = 10.0) -> Floats:
    return np.asarray(random_poses(rng, 1, reach)[0])


def simple_pairs(rng: np.random.Generator) -> Rows:
    """Whole numbers and quarter turns whose sum stays within half a turn.

    The first call turns: a program that keeps its first rotation would otherwise look like one that forgets it.
    """
    drawn = []
    for _ in range(4):
        x1, y1, x2, y2 = rng.integers(-4, 5, 4).tolist()
        drawn.append(((x1, y1, -QUARTER), (x2 or 1, y2 or 2, (0.0, QUARTER)[rng.integers(2)])))
    return _pairs(SIMPLE, np.array(drawn))


def random_pairs(rng: np.random.Generator) -> Rows:
    """Any two poses whose angles add up, and subtract, to less than half a turn: first to more than a quarter.

    Those that never change and whose angles add up to more come last: what is judged there is the position.
    """
    drawn = random_poses(rng, 24)
    drawn[:, 2] /= 2.1
    return _pairs(TURNED, drawn.reshape(12, 2, 3), WRAPPING)


def wrapping_pairs(rng: np.random.Generator) -> Rows:
    """Poses whose angles add up to more than half a turn, in both senses."""
    drawn = rng.random((4, 8))  # of each pair, two poses and the angles that they get
    pairs = _within(drawn[:, :6].reshape(4, 2, 3), 10.0)
    pairs[:, :, 2] = SENSES * (1.7 + (3.1 - 1.7) * drawn[:, 6:])
    return _pairs(WRAPPING, pairs)


def single_poses(rng: np.random.Generator) -> Rows:
    return Rows(np.concatenate((SINGLE, random_poses(rng, 10))))


def relative_pairs(rng: np.random.Generator) -> Rows:
    return _pairs(NEAR, random_poses(rng, 20).reshape(10, 2, 3), FAR_ROUND)


def _pairs(*pairs: Floats) -> Rows:
    """The calls of all these pairs of poses (n, 2, 3)."""
    both = np.concatenate(pairs)
    return Rows(both[:, 0], both[:, 1])


def wraps(args: Arguments) -> bool:
    """Does the sum of the angles leave ]-pi, pi]?"""
    return bool(abs(args[0][2] + args[1][2]) > math.pi + 1e-6)


def stays(args: Arguments) -> bool:
    return not wraps(args)
