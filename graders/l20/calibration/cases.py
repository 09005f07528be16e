"""What submissions are graded on: steps by hand, steps drawn with slip, and those of a real robot."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from graders.core.contract.values import Arguments, Floats
from graders.l19.matrices import matrix
from graders.l20.tp_slam.journeys import LOG, SCANS
from reference.calibration import StepCalibration, calibrate_steps
from reference.se2 import relative

#: Seed of the cases that never change.
STEADY = 54
#: Constants of robots, (gamma, beta, alpha).
ROBOTS = ((0.9, 1.2, 0.1), (1.1, 0.85, -0.15), (0.96, 0.98, 0.05))
#: An angle stays that far from half a turn, corrected or not.
SHORT_OF_A_HALF_TURN = 3.1


def right_ways(steps: Floats) -> Floats:
    half = steps[:, 2] / 2.0
    return np.asarray(steps[:, 0] * np.cos(half) + steps[:, 1] * np.sin(half))


def right_constants(steps: Floats, motions: Floats) -> Floats:
    """(gamma, beta, alpha)."""
    found = calibrate_steps(steps, motions)
    return np.array([found.stretch, found.turn, found.pull])


def right_steps(steps: Floats, gamma: float, beta: float, alpha: float) -> Floats:
    return StepCalibration(gamma, beta, alpha, 0.0, 0.0).correct(steps)


def along(*steps: tuple[float, float]) -> Floats:
    """Steps (n, 3) of arcs: the way along each chord, and the turn."""
    ways, turns = np.array(steps, dtype=np.float64).T
    return np.column_stack([ways * np.cos(turns / 2.0), ways * np.sin(turns / 2.0), turns])


def ways_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Ahead, back, on the spot, a quarter turn along an arc, then across the chord."""
    yield (matrix((1, 0, 0)),)
    yield (matrix((-2, 0, 0)),)
    yield (matrix((0, 0, 1)),)
    yield (matrix((1, 1, np.pi / 2)),)
    yield (matrix((1, -1, -np.pi / 2), (-1, -1, np.pi / 2)),)
    yield (matrix((0, 1, 0), (0.5, 0.25, 0)),)


def any_ways(rng: np.random.Generator) -> Iterator[Arguments]:
    for source in (np.random.default_rng(STEADY), rng):
        yield (drawn_steps(source, 5),)


def drawn_steps(rng: np.random.Generator, n: int) -> Floats:
    """Ahead and back, with turns of either side, and a slip across the chord."""
    ways = rng.uniform(0.2, 1.0, n) * np.where(np.arange(n) % 3 == 1, -1.0, 1.0)
    turns = rng.uniform(0.2, 1.2, n) * rng.choice([-1.0, 1.0], n)
    steps = along(*zip(ways.tolist(), turns.tolist(), strict=True))
    steps[:, :2] += rng.uniform(0.02, 0.15, (n, 2)) * rng.choice([-1.0, 1.0], (n, 2))
    return np.round(steps, 2)


def journeys_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """The statement's; each constant alone; nothing to correct; a robot that also turns while it goes."""
    stated = matrix((1, 0, 0), (0, 0, 1), (-1, 0, 0))
    yield stated, right_steps(stated, 0.9, 1.2, 0.1)
    yield stated, stated.copy()
    for gamma, beta, alpha in ((0.5, 1.0, 0.0), (1.0, 1.5, 0.0), (1.0, 1.0, 0.25)):
        yield stated, right_steps(stated, gamma, beta, alpha)
    curves = along((1, 0), (1, 0.5), (2, -0.5), (0, 1))
    for constants in ROBOTS:
        yield curves, right_steps(curves, *constants)
    # A step counted ahead that went back; steps from which the two constants are hard, but possible, to tell apart.
    yield along((1, 0.5), (0.5, -0.5), (2, 0)), along((-0.75, 0.5), (0.5, -0.75), (1.5, 0.25))
    yield along((1, 0.1), (1.1, 0.1), (0.9, 0.11)), along((0.9, 0.2), (1.2, 0.15), (1, 0.3))
    yield along((20, 0.1), (15, -0.08), (25, 0.05)), along((21, 0.2), (15.5, 0.05), (24, 0.2))


def slipping_journeys(rng: np.random.Generator) -> Iterator[Arguments]:
    """What no constants explain altogether."""
    for source in (np.random.default_rng(STEADY), rng):
        for n, constants in zip((3, 6, 9), ROBOTS, strict=True):
            yield drawn_journey(source, n, constants)


def drawn_journey(rng: np.random.Generator, n: int, constants: tuple[float, float, float]) -> Arguments:
    steps = drawn_steps(rng, n)
    return steps, np.round(right_steps(steps, *constants) + rng.uniform(-0.1, 0.1, steps.shape), 2)


def determines(args: Arguments) -> bool:
    """Do the steps tell all constants apart, by far?"""
    steps, motions = args
    if len(steps) < 3 or steps.shape != motions.shape or not stays_short(steps, motions):
        return False
    columns = np.column_stack([steps[:, 2], right_ways(steps)])
    size = np.linalg.norm(columns, axis=0)
    return bool(size.min() > 0.1 and np.linalg.svd(columns / size, compute_uv=False)[-1] > 0.05)


def corrections_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """The statement's; each constant alone, along a straight line, on the spot, and along an arc; a slip."""
    stated = matrix((1, 0, 0), (0, 0, 1), (-1, 0, 0))
    yield stated, 0.9, 1.2, 0.1
    quarter = matrix((1, 1, np.pi / 2))
    for steps in (matrix((2, 0, 0)), matrix((0, 0, -1)), quarter):
        yield steps, 1.0, 1.0, 0.0
        yield steps, 0.5, 1.0, 0.0
        yield steps, 1.0, 0.5, 0.0
        yield steps, 1.0, 1.0, 0.25
    yield matrix((0, 1, 0)), 1.0, 1.0, 0.5
    yield matrix((1, 0.5, 0)), 0.8, 1.0, 0.3
    yield along((1, 0.9), (-0.5, -1.1)), 1.25, 2.5, 0.25


def any_corrections(rng: np.random.Generator) -> Iterator[Arguments]:
    for source in (np.random.default_rng(STEADY), rng):
        for constants in ROBOTS:
            yield drawn_steps(source, 4), *constants


def can_be_corrected(args: Arguments) -> bool:
    steps, *constants = args
    return len(steps) > 0 and stays_short(steps, right_steps(steps, *constants))


def stays_short(*steps: Floats) -> bool:
    return all(bool(np.all(np.abs(rows[:, 2]) < SHORT_OF_A_HALF_TURN)) for rows in steps)


@cache
def laboratory() -> tuple[Floats, Floats, Floats]:
    """Of 120 scans of the laboratory: the robot's steps and those of its scans (119, 3), and the truth (120, 3)."""
    with np.load(LOG) as log:
        odometry, poses = (np.asarray(log[name][:SCANS], dtype=np.float64) for name in ("odometry", "poses"))
        return relative(odometry[:-1], odometry[1:]), np.asarray(log["first"], dtype=np.float64), poses
