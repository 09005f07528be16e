"""The steps that submissions are graded on: first by hand, so that known mistakes fail whatever is drawn, then drawn.

No step turns by half a turn or more, as the statement promises: a single turn taken off or added brings the heading
back, and the middle of two headings has a meaning.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice

import numpy as np

from graders.core.contract.values import Arguments, Floats

QUARTER = math.pi / 2
#: Radians: the largest turn of one step.
LARGEST_TURN = 2.9


def pose(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def turn(args: Arguments) -> float:
    _, left, right, track = args
    return float((right - left) / track)


def wraps(args: Arguments) -> bool:
    """Is it a step whose heading leaves ]-pi, pi]?"""
    return is_step(args) and bool(abs(args[0][2] + turn(args)) > math.pi + 1e-6)


def stays(args: Arguments) -> bool:
    """Is it a step whose heading stays in there?"""
    return is_step(args) and bool(abs(args[0][2] + turn(args)) < math.pi - 1e-6)


def is_step(args: Arguments) -> bool:
    return bool(args[3] > 0.0) and abs(turn(args)) <= LARGEST_TURN


def is_spread(args: Arguments) -> bool:
    """Is it a pair of standard deviations, and a track?"""
    left, right, track = args
    return bool(left >= 0.0 and right >= 0.0 and track > 0.0)


def simple_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    """Straight ahead, on the spot, then both at once, with few digits.

    The first call turns: a program that keeps its first heading would otherwise look like one that forgets it.
    """
    yield pose(1, 2, QUARTER), 0.35, 0.45, 0.5
    yield pose(0, 0, 0), 1.0, 1.0, 0.5
    yield pose(1, 2, -QUARTER), 2.0, 2.0, 0.4
    yield pose(3, -1, 0), -0.1, 0.1, 0.4
    yield pose(3, -1, QUARTER / 2), 0.0, 0.0, 0.4
    yield pose(0, 1, -QUARTER / 2), 0.8, 0.2, 0.4
    yield pose(2, 1, 2 * QUARTER / 3), 0.2, 0.9, 0.5
    for _ in range(4):
        yield _step(rng, digits=1)


def any_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    """Whatever a robot does in a step, backwards too: by hand in all quarters, and in both senses."""
    yield pose(1.5, -2.25, 1.2), 0.31, 0.83, 0.6
    yield pose(-3.5, 1.25, -0.8), 0.94, 0.27, 0.45
    yield pose(2.5, 0.75, 0.4), -0.52, -0.88, 0.7
    yield pose(-1.75, -0.5, 2.6), -0.71, -0.64, 0.35
    yield pose(0.25, 3.5, -2.1), 0.44, -0.16, 0.8
    yield pose(-1.5, 2.25, -1.4), -0.2, 1.2, 0.5
    yield pose(300.0, -250.0, 1.4), 1.2, -0.2, 0.5
    for _ in range(10):
        yield _step(rng, digits=2)


def steps_all_round(rng: np.random.Generator) -> Iterator[Arguments]:
    """Those, then some beyond half a turn, where the position too must be right."""
    yield from any_steps(rng)
    yield from islice(turning_steps(rng), 6)


def turning_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    """Steps whose heading goes beyond half a turn, on both sides, first on the spot."""
    yield pose(0, 0, 3 * QUARTER / 2), -0.2, 0.2, 0.4
    yield pose(0, 0, -3 * QUARTER / 2), 0.2, -0.2, 0.4
    yield pose(1, 0, QUARTER), 0.4, 1.4, 0.5
    yield pose(-1, 2, -2.8), 0.9, 0.5, 0.5
    yield pose(2, 1, math.pi), 0.3, 0.5, 0.5
    yield pose(2, 1, 3.1), -0.5, -0.3, 0.4
    for sign in (1.0, -1.0, 1.0, -1.0):
        yield _beyond(rng, sign)


def _step(rng: np.random.Generator, *, digits: int) -> Arguments:
    """A step whose heading stays within half a turn, of numbers of so many decimals."""
    while True:
        x, y = np.round(rng.uniform(-5.0, 5.0, 2), digits) + 0.0
        left, right = np.round(rng.uniform(-1.0, 1.0, 2), digits) + 0.0
        args = (
            pose(x, y, round(float(rng.uniform(-3.0, 3.0)), digits)),
            float(left),
            float(right),
            round(float(rng.uniform(0.3, 1.2)), digits),
        )
        if stays(args) and abs(turn(args)) > 0.05:
            return args


def _beyond(rng: np.random.Generator, sign: float) -> Arguments:
    while True:
        start, left, right, track = _step(rng, digits=2)
        start[2] = sign * round(float(rng.uniform(1.0, 3.1)), 2)
        if wraps((start, left, right, track)):
            return start, left, right, track


def simple_spreads(rng: np.random.Generator) -> Iterator[Arguments]:
    """Right triangles 3-4-5 and 5-12-13, whose roots are whole."""
    yield 0.003, 0.004, 0.5
    yield 0.04, 0.03, 0.25
    yield 0.05, 0.12, 2.0
    yield 0.3, 0.0, 0.6


def any_spreads(rng: np.random.Generator) -> Iterator[Arguments]:
    yield 0.012, 0.031, 0.37
    yield 0.17, 0.08, 1.6
    yield 0.0, 0.02, 0.45
    yield 0.25, 0.25, 0.31
    yield 0.002, 0.003, 0.05
    for _ in range(6):
        left, right = rng.uniform(0.001, 0.4, 2)
        yield round(float(left), 3), round(float(right), 3), round(float(rng.uniform(0.2, 2.5)), 2)
