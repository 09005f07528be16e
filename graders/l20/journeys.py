"""Robots that wander on a map of module L20: where they really are, what their wheels say, what their lidar reads."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache

import numpy as np

from graders.core.contract.local import initial_globals
from graders.core.contract.values import Floats
from graders.l20 import world
from reference.se2 import compose, relative
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar

STRIDE = 0.9
BEAMS = 36
#: Standard deviations of what the lidar reads, in cells, and of the three numbers of a measured move. The statements
#: of l20/mcl and l20/defi_kidnappe tell them.
SCAN_NOISE = 0.1
MOVE_NOISE = (0.05, 0.05, 0.03)

#: How far a robot sees free before it goes, on the way and a little to both sides.
ROOM, SIDES = STRIDE + 0.35, np.linspace(-0.3, 0.3, 5)
USUAL_TURN, TRIES = 0.35, 8
ON_THE_SPOT = np.array([0.6, 0.9, 1.2, 1.5])

LIDAR = SimulatedLidar.full_turn(BEAMS, world.RANGE, SCAN_NOISE)


@dataclass(frozen=True, eq=False)
class Journey:
    """n steps of a robot: `truth` (n + 1, 3), the measured `moves` (n, 3) between, and a scan (n, 36) after each."""

    map: GridMap
    truth: Floats
    moves: Floats
    scans: Floats

    def __len__(self) -> int:
        return len(self.moves)


@cache
def module_map() -> GridMap:
    """The map that the kit holds."""
    return GridMap.from_free(initial_globals(world.STILL)["libres"])


def wander(grid: GridMap, steps: int, rng: np.random.Generator, start: Floats | None = None) -> Journey:
    """A journey from `start`, or from anywhere."""
    truth = [roomy_pose(grid, rng) if start is None else np.asarray(start, dtype=np.float64)]
    for _ in range(steps):
        truth.append(compose(truth[-1], _chosen(grid, truth[-1], rng)))
    exact = np.array([relative(before, after) for before, after in itertools.pairwise(truth)])
    moves = exact + np.array(MOVE_NOISE) * rng.standard_normal(exact.shape)
    return Journey(grid, np.array(truth), moves, read(grid, np.array(truth[1:]), rng))


def read(grid: GridMap, poses: Floats, rng: np.random.Generator) -> Floats:
    """What the noisy lidar reads from poses (m, 3): (m, 36)."""
    return LIDAR.measure_ranges(grid, poses, rng)


def _chosen(grid: GridMap, pose: Floats, rng: np.random.Generator) -> Floats:
    """The next move: a stride while turning a little, where there is room; else a turn on the spot towards some."""
    for turn in rng.normal(0.0, USUAL_TURN, TRIES):
        if _clear(grid, pose, turn / 2.0):
            return np.array([STRIDE * np.cos(turn / 2.0), STRIDE * np.sin(turn / 2.0), turn])
    turns = rng.choice((-1.0, 1.0)) * rng.permutation(ON_THE_SPOT)
    return np.array([0.0, 0.0, next((turn for turn in (*turns, *-turns) if _clear(grid, pose, turn)), turns[0])])


def _clear(grid: GridMap, pose: Floats, way: float) -> bool:
    """Is there room for a stride that way from the heading?"""
    return bool(grid.cast_scans([pose], way + SIDES, world.RANGE).min() > ROOM)


def roomy_pose(grid: GridMap, rng: np.random.Generator) -> Floats:
    """A pose on a free cell, not against a wall."""
    while True:
        pose = scattered(grid, 1, rng)[0]
        if grid.cast_scans([pose], np.linspace(0.0, 2.0 * np.pi, 16), world.RANGE).min() > 0.3:
            return np.asarray(pose)


def scattered(grid: GridMap, count: int, rng: np.random.Generator) -> Floats:
    """Poses (count, 3) anywhere on the free cells."""
    y, x = np.argwhere(grid.free)[rng.integers(np.count_nonzero(grid.free), size=count)].T
    headings = rng.uniform(-np.pi, np.pi, count)
    return np.column_stack([x + rng.random(count), y + rng.random(count), headings])


def around(pose: Floats, count: int, spread: tuple[float, float], rng: np.random.Generator) -> Floats:
    """Poses (count, 3) near one; `spread`: standard deviations of the places, in cells, and of the headings."""
    return np.asarray(pose + np.array([spread[0], spread[0], spread[1]]) * rng.standard_normal((count, 3)))


def away(poses: Floats, truth: Floats) -> tuple[Floats, Floats]:
    """How far poses (…, 3) are from the truth (3,): in cells, and in radians between 0 and pi."""
    gap = np.asarray(poses, dtype=np.float64) - truth
    turn: Floats = np.abs(np.remainder(gap[..., 2] + np.pi, 2.0 * np.pi) - np.pi)
    return np.hypot(gap[..., 0], gap[..., 1]), turn
