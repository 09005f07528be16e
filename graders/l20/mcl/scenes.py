"""Clouds made by hand, of which one step shows what a filter does: on the module's map, and in a long hall.

The hall sees little: with a range of 4, a robot near its upper wall reads that wall alone, so that places along it
cannot be told apart, but for those near the left end. What a scan teaches is known there, and what it cannot teach.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.program import KitSettings, StudentFault
from graders.core.contract.values import Arguments, Floats
from graders.l20 import journeys, world
from reference.se2 import compose
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar

HALL = np.pad(np.ones((11, 32), dtype=bool), 1)
HALL_RANGE = 4.0
HALL_KIT = KitSettings(world.MODULE, {"libres": HALL, "portee_max": HALL_RANGE, "seed": 0})
#: Small, no walls around it, neither square nor alike when its axes are exchanged.
SMALL = np.array([[cell == "." for cell in row] for row in (".....#...", "##...#...", ".....#...", "...#.....",
                                                            "...##....", ".........", "..####..#")])  # fmt: skip
SPREAD = (0.08, 0.05)
#: The same clouds in every grading: what is caught does not depend on the seed.
ALWAYS = 2026


@dataclass(frozen=True, eq=False)
class Step:
    """The arguments of one step of a filter, and where the robot is after it."""

    particles: Floats
    weights: Floats
    move: Floats
    scan: Floats
    truth: Floats

    @property
    def args(self) -> Arguments:
        return self.particles, self.weights, self.move, self.scan

    @property
    def inputs(self) -> dict[str, object]:
        names = ("particules", "poids", "u", "scan")
        return dict(zip(names, self.args, strict=True))


@cache
def hall() -> GridMap:
    return GridMap.from_free(HALL)


def scan_of(grid: GridMap, pose: Floats, reach: float, rng: np.random.Generator) -> Floats:
    """What the lidar reads from a pose: noisy, 36 rays."""
    lidar = SimulatedLidar.full_turn(journeys.BEAMS, reach, journeys.SCAN_NOISE)
    return np.asarray(lidar.measure_ranges(grid, [pose], rng)[0])


def step(
    rng: np.random.Generator,
    groups: Sequence[tuple[Sequence[float], int]],
    move: Sequence[float],
    *,
    in_hall: bool = False,
    spread: tuple[float, float] = SPREAD,
    weights: Sequence[float] | None = None,
) -> Step:
    """One step of a cloud made of groups (pose, count), the robot being in the first one.

    `weights`: of each group as a whole, as many as it has particles unless given.
    """
    grid, reach = (hall(), HALL_RANGE) if in_hall else (journeys.module_map(), world.RANGE)
    u = np.asarray(move, dtype=np.float64)
    truth = compose(groups[0][0], u)
    particles = np.vstack([journeys.around(np.asarray(pose), count, spread, rng) for pose, count in groups])
    sizes = np.array([count for _, count in groups])
    shares = sizes / sizes.sum() if weights is None else np.asarray(weights)
    return Step(particles, np.repeat(shares / sizes, sizes), u, scan_of(grid, truth, reach, rng), truth)


def share_near(particles: Floats, weights: Floats, pose: Sequence[float], reach: float = 1.5) -> float:
    """The weight of the particles within `reach` cells of a place."""
    gap = np.hypot(particles[:, 0] - pose[0], particles[:, 1] - pose[1])
    return float(weights[gap < reach].sum() / weights.sum())


def judged(bench: Bench, judge: Callable[[Bench], None], kit: Callable[[Bench], KitSettings] | None = None) -> None:
    """Judge a scene; what fails is judged once more by the file launched afresh.

    A filter may keep averages of what it sees, and take the next scene for a robot that was carried away.
    """
    try:
        judge(bench)
    except (Rejection, StudentFault) as found:
        if isinstance(found, StudentFault) and (found.fatal or found.exception is None):
            raise
        with bench.run_with_kit((kit or _module_kit)(bench)) as again:
            judge(again)


def _module_kit(bench: Bench) -> KitSettings:
    return world.kit(bench.rng)


def hall_kit(bench: Bench) -> KitSettings:
    """The settings of a program in the hall."""
    seed = int(bench.rng.integers(2**62))
    return KitSettings(world.MODULE, {"libres": HALL, "portee_max": HALL_RANGE, "seed": seed})


def in_the_hall(bench: Bench) -> AbstractContextManager[Bench]:
    """The program started in the hall."""
    return bench.run_with_kit(hall_kit(bench))
