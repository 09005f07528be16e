"""The pairs of trajectories that submissions are graded on: by hand, then of a fixed seed, then drawn.

No trajectory fits its truth exactly, so that who subtracts large squares loses nothing by it, and all of them spread in
the plane: the best rotation is one, and whether a mirror would fit better is not up to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from graders.core.compare.shrinking import reading_cost
from graders.core.contract.values import Arguments, Floats, Value
from graders.robotics.poses import angle_complexity
from reference.metrics import relative_pose_error
from reference.registration import RigidAlignment, kabsch
from reference.se2 import compose, wrap_angle

QUARTER = math.pi / 2
#: Seed of what never changes.
TELLING = 7
#: How far apart the singular values of the two clouds are, and from zero, as a share of the largest.
GAP = 0.15
#: Metres: the least error that is asked.
LEAST_ERROR = 0.01
#: Of a simplified trajectory.
SHORTEST_STEP = 0.4


def trajectory(*poses: Sequence[float]) -> Floats:
    return np.array(poses, dtype=np.float64)


def seen_from(frame: Sequence[float] | Floats, poses: Floats) -> Floats:
    """The trajectory (n, 3), given in a frame, in the one where the frame's pose is given; without negative zeros."""
    return compose(np.asarray(frame, dtype=np.float64), poses) + 0.0


def mirrored(poses: Floats) -> Floats:
    """The trajectory of who takes left for right."""
    return poses * (1.0, -1.0, -1.0) + 0.0


def alignment(estimate: Floats, truth: Floats) -> RigidAlignment:
    return kabsch(estimate[:, :2], truth[:, :2])


def right_ate(estimate: Floats, truth: Floats) -> float:
    return math.sqrt(alignment(estimate, truth).residual / len(truth))


def right_rpe(estimate: Floats, truth: Floats, delta: int) -> float:
    return relative_pose_error(truth, estimate, delta, overlapping=True).translation.rmse


def is_well_posed(estimate: Floats, truth: Floats) -> bool:
    """Do both spread in the plane, so that the best rotation is well known, and does it leave an error?"""
    found = alignment(estimate, truth)
    first, second = found.singular_values
    return bool(second > GAP * first and first - second > GAP * first and found.residual > len(truth) * LEAST_ERROR**2)


def turns_over(estimate: Floats, truth: Floats) -> bool:
    """Would a mirror fit better than any rotation?"""
    H = (estimate[:, :2] - estimate[:, :2].mean(axis=0)).T @ (truth[:, :2] - truth[:, :2].mean(axis=0))
    return bool(np.linalg.det(H) < 0.0)


def is_pair(args: Arguments) -> bool:
    """Are they well posed, without a mirror?"""
    return is_well_posed(*args) and not turns_over(*args)


def is_mirrored_pair(args: Arguments) -> bool:
    return is_well_posed(*args) and turns_over(*args)


def is_on_the_move(args: Arguments) -> bool:
    """Does the robot move from each pose to the next, in both trajectories?"""
    return all(bool(np.all(np.hypot(*np.diff(poses[:, :2], axis=0).T) > SHORTEST_STEP)) for poses in args[:2])


# A square of side 2 that the robot takes for a rectangle, 4 by 2, in a frame turned by a quarter.
SQUARE = trajectory((0, 0, 0), (2, 0, QUARTER), (2, 2, math.pi), (0, 2, -QUARTER))
RECTANGLE = trajectory((5, 1, QUARTER), (5, 5, math.pi), (3, 5, -QUARTER), (3, 1, 0))
# A corner whose second leg is too long, then one whose turn is forgotten.
CORNER = trajectory((0, 0, 0), (2, 0, 0), (4, 0, QUARTER), (4, 1, QUARTER), (4, 3, QUARTER))
LONG = trajectory((0, 0, 0), (2, 0, 0), (5, 0, QUARTER), (5, 1, QUARTER), (5, 4, QUARTER))
BENT = trajectory((0, 0, 0), (2, 0, 0), (4, 1, QUARTER), (4, 2, QUARTER), (3, 4, math.pi))
# Straight ahead; seen towards the north, with a last step that is too long.
AHEAD = trajectory((0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0))
STRETCHED = trajectory((0, 0, QUARTER), (0, 1, QUARTER), (0, 2, QUARTER), (0, 5, QUARTER))


def walk(rng: np.random.Generator, n: int, *, mirror: bool = False) -> tuple[Floats, Floats]:
    """An estimate and its truth, both (n, 3) to two decimals: noisy steps, told in a frame of their own."""
    while True:
        motions = np.column_stack(
            [rng.uniform(0.6, 2.2, n - 1), rng.normal(0.0, 0.1, n - 1), rng.normal(0.5, 0.7, n - 1)]
        )
        noise = rng.normal(0.0, (0.25, 0.2, 0.15), (n - 1, 3))
        truth, estimate = _chained(motions), _chained(motions + noise)
        frame = rng.uniform((-6.0, -6.0, 0.7), (6.0, 6.0, 2.4)) * (1.0, 1.0, rng.choice([-1.0, 1.0]))
        estimate = seen_from(frame, mirrored(estimate) if mirror else estimate)
        estimate, truth = _readable(estimate), _readable(truth)
        if is_well_posed(estimate, truth) and turns_over(estimate, truth) == mirror:
            return estimate, truth


def _chained(motions: Floats) -> Floats:
    poses = [np.zeros(3)]
    for motion in motions:
        poses.append(compose(poses[-1], motion))
    return np.array(poses)


def _readable(poses: Floats) -> Floats:
    """Two decimals, headings that stay in [-pi, pi]."""
    rounded = np.round(poses, 2) + 0.0
    rounded[:, 2] = wrap_angle(rounded[:, 2])
    return rounded


def walks(
    rng: np.random.Generator, fixed: Sequence[int], drawn: int, *, mirror: bool = False
) -> Iterator[tuple[Floats, Floats]]:
    """Walks of so many poses, the same at every seed, then some that are drawn."""
    telling = np.random.default_rng(TELLING)
    for n in fixed:
        yield walk(telling, n, mirror=mirror)
    for _ in range(drawn):
        yield walk(rng, int(rng.integers(5, 9)), mirror=mirror)


def small_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Whole numbers: first gaps that are all equal, then unequal ones."""
    yield RECTANGLE, SQUARE
    yield LONG, CORNER
    yield seen_from((1, -2, -QUARTER), BENT), CORNER
    yield seen_from((-3, 2, math.pi), LONG), BENT


def any_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    return walks(rng, (4, 5, 6, 8), 5)


def mirrored_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    """A robot that takes left for right: the best rotation is no mirror."""
    yield mirrored(CORNER), CORNER
    yield seen_from((2, 1, QUARTER), mirrored(LONG)), CORNER
    yield from walks(rng, (4, 5, 7), 3, mirror=True)


def single_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    yield STRETCHED, AHEAD, 1
    yield RECTANGLE, SQUARE, 1
    yield seen_from((1, -2, -QUARTER), BENT), CORNER, 1
    for pair in walks(rng, (4, 6, 8, 60), 4):
        yield (*pair, 1)


def longer_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    """Motions over two poses or more, of which there are at least two; then the only one from the first to the last."""
    yield STRETCHED, AHEAD, 2
    yield RECTANGLE, SQUARE, 2
    yield seen_from((1, -2, -QUARTER), BENT), CORNER, 3
    yield LONG, BENT, 4
    deltas = (2, 2, 3, 4, 5)
    for k, pair in enumerate(walks(rng, (4, 5, 6, 8, 8), 5)):
        yield (*pair, deltas[k] if k < len(deltas) else int(rng.integers(2, len(pair[0]) - 1)))


def shrink_trajectory(value: Value) -> Iterator[Value]:
    """Whole coordinates and quarter turns, then one decimal: it must still look like what a robot does."""
    poses = np.asarray(value, dtype=np.float64)
    whole = np.round(poses[:, :2])
    simpler = (
        np.column_stack([whole, np.round(poses[:, 2] / QUARTER) * QUARTER]),
        np.column_stack([whole, poses[:, 2]]),
        np.round(poses, 1),
    )
    for candidate in simpler:
        if complexity_of(candidate) < complexity_of(poses):
            yield candidate + 0.0


def shrink_positions(value: Value) -> Iterator[Value]:
    """The same where headings do not count: first all of them to the east."""
    poses = np.asarray(value, dtype=np.float64)
    if np.any(poses[:, 2]):
        yield poses * (1.0, 1.0, 0.0) + 0.0
    yield from shrink_trajectory(value)


def complexity_of(poses: Floats) -> float:
    """How much there is to read."""
    return sum(map(reading_cost, poses[:, :2].ravel().tolist())) + sum(map(angle_complexity, poses[:, 2].tolist()))
