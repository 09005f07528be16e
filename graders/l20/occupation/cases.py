"""The scans of l20/occupation: one ray along an axis, aslant, at the range, at the bounds, over the edge; then many."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np

from graders.core.contract.local import initial_globals
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.occupation.judge import Integration, after

Rng = np.random.Generator
Draw = Callable[[Rng], Iterator[Integration]]

QUARTER = math.pi / 2
#: Where one ray is judged: its own map and range, which say nothing of the readings.
FREE = np.array([[cell == "." for cell in row] for row in (".....#..", "..#.....", "........", "#.....#.", "..#.....")])
KIT_RANGE = 4.0
FAR = 12.0
SHAPE = FREE.shape
SMALL = KitSettings(world.MODULE, {"libres": FREE, "portee_max": KIT_RANGE, "seed": 0})
#: Where whole scans are taken.
ROOM = np.array(
    [[cell == "." for cell in row] for row in (
        "###########", "#....#....#", "#.........#", "#....##...#", "#.#.......#", "#.....#...#", "###########",
    )]
)  # fmt: skip
ROOM_KIT = KitSettings(world.MODULE, {"libres": ROOM, "portee_max": FAR, "seed": 0})
#: Draws that are the same in every grading come first, so that what is caught does not depend on the seed.
TELLING = 1


def at(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def one_ray(pose: Floats, z: float, portee_max: float = FAR, l: Floats | None = None) -> Integration:  # noqa: E741
    """A single ray straight ahead, on an empty grid unless given."""
    return Integration(np.zeros(SHAPE) if l is None else l, pose, np.array([z]), portee_max)


def along_axes(rng: Rng) -> Iterator[Integration]:
    """To the four sides, up to a face, then into a cell."""
    yield one_ray(at(1.5, 2.5, 0.0), 3.5)
    yield one_ray(at(6.5, 2.5, math.pi), 3.5)
    yield one_ray(at(3.5, 0.5, QUARTER), 2.5)
    yield one_ray(at(3.5, 4.5, -QUARTER), 2.5)
    yield one_ray(at(5.75, 3.25, -math.pi), 2.75)
    yield one_ray(at(0.25, 1.75, 0.0), 4.75)
    yield one_ray(at(6.25, 4.75, -QUARTER), 3.75)
    yield one_ray(at(1.5, 3.5, 0.0), 4.0)
    for _ in range(3):
        y, first, last = int(rng.integers(5)), int(rng.integers(2)), int(rng.integers(5, 8))
        yield one_ray(at(first + 0.5, y + 0.5, 0.0), last - first - 0.5)
        yield one_ray(at(last + 0.5, y + 0.5, math.pi), last - first - 0.5)


def aslant(rng: Rng) -> Iterator[Integration]:
    """Triangles 3-4-5 in the four quarters, then any heading."""
    slope = math.atan2(3.0, 4.0)
    yield one_ray(at(0.5, 0.5, slope), 4.375)
    yield one_ray(at(7.5, 0.5, math.pi - slope), 4.375)
    yield one_ray(at(0.5, 4.5, -slope), 4.375)
    yield one_ray(at(7.5, 4.5, slope - math.pi), 4.375)
    yield one_ray(at(1.5, 0.25, QUARTER - slope / 2.0), 2.5)
    yield one_ray(at(0.5, 1.2, slope), 4.375)
    yield one_ray(at(7.5, 4.25, -3.1), 6.5 / math.cos(math.pi - 3.1))
    yield one_ray(at(7.5, 0.75, 3.1), 6.5 / math.cos(math.pi - 3.1))
    for source, count in ((np.random.default_rng(TELLING), 8), (rng, 3)):
        for _ in range(count):
            yield _up_to_a_face(source, FAR)


def _up_to_a_face(rng: Rng, portee_max: float) -> Integration:
    """A ray that stops at the face of a cell, well beyond its start and well before the cell's end."""
    while True:
        pose = at(rng.uniform(0.2, 7.8), rng.uniform(0.2, 4.8), rng.uniform(-math.pi, math.pi))
        start, slope, lines = (0, math.cos(pose[2]), 8) if rng.random() < 0.5 else (1, math.sin(pose[2]), 5)
        z = (float(rng.integers(1, lines)) - pose[start]) / slope
        if z < 2.0:
            continue
        case = one_ray(pose, z, portee_max)
        seen = case.told
        if seen.stopped.sum() == 1 and seen.crossed.sum() >= 2:
            return case


def at_the_range(rng: Rng) -> Iterator[Integration]:
    """Readings of the range and beyond, which end in one cell; just below; ranges other than the kit's."""
    yield one_ray(at(1.5, 2.5, 0.0), 3.0, 3.0)
    yield one_ray(at(6.5, 1.5, math.pi), 3.25, 3.0)
    yield one_ray(at(2.5, 0.5, QUARTER), 3.0, 3.0)
    yield one_ray(at(1.5, 2.5, 0.0), 2.5, 3.0)
    yield one_ray(at(1.5, 2.5, 0.0), KIT_RANGE, KIT_RANGE)
    yield one_ray(at(0.5, 2.5, 0.0), 5.5, 6.0)
    yield one_ray(at(0.5, 1.5, 0.0), 4.5, FAR)
    yield one_ray(at(0.5, 4.5, -math.atan2(3.0, 4.0)), 5.0, 5.0)
    yield one_ray(at(1.5, 3.5, 0.0), 5.25, 2.0)
    for _ in range(2):
        y, portee_max = int(rng.integers(5)), float(rng.integers(2, 6))
        yield one_ray(at(1.5, y + 0.5, 0.0), portee_max, portee_max)


def at_the_bounds(rng: Rng) -> Iterator[Integration]:
    """Grids that are no longer empty: the same scan again, cells near the bounds and at them."""
    first = one_ray(at(1.5, 2.5, 0.0), 3.5)
    yield first._replace(l=after(first))
    worn = np.zeros(SHAPE)
    worn[2] = (1.5, -2.0, -4.8, 5.0, -5.0, 4.9, 5.0, -5.0)
    worn[1] = (-5.0, 3.2, 0.847, 4.153, -4.9, -1.3, 5.0, 2.1)
    yield one_ray(at(1.5, 2.5, 0.0), 3.5, FAR, worn)
    yield one_ray(at(5.5, 2.5, math.pi), 2.5, FAR, -worn)
    yield one_ray(at(5.5, 1.5, math.pi), 4.5, FAR, worn)
    yield one_ray(at(4.5, 4.5, -QUARTER), 2.5, FAR, -worn)
    yield one_ray(at(1.5, 1.5, 0.0), 5.0, 5.0, worn)
    yield one_ray(at(0.5, 1.2, math.atan2(3.0, 4.0)), 4.375, FAR, -worn)
    for source, count in ((np.random.default_rng(TELLING), 8), (rng, 3)):
        for _ in range(count):
            values = np.round(source.uniform(-5.0, 5.0, SHAPE), 1)
            yield _up_to_a_face(source, FAR)._replace(l=values)


def over_the_edge(rng: Rng) -> Iterator[Integration]:
    """Through each side of the grid: what stops the ray is outside, at once or a little further."""
    for z in (1.5, 1.8):
        yield one_ray(at(6.5, 2.5, 0.0), z)
        yield one_ray(at(3.5, 3.5, QUARTER), z)
        yield one_ray(at(1.5, 2.5, math.pi), z)
        yield one_ray(at(3.5, 1.5, -QUARTER), z)
    for x, y, theta in ((1.5, 1.4, 1.5), (6.5, 1.4, 0.5), (1.4, 1.5, -0.5), (1.4, 3.5, 0.5)):
        # Out through one cell, and stopped in its neighbour: neither is on the grid.
        yield one_ray(at(x, y, theta * QUARTER), 2.5)
    yield one_ray(at(1.5, 1.25, -math.pi + 0.4), 1.5 / math.cos(0.4))
    yield one_ray(at(5.5, 3.25, 0.3), 2.5 / math.cos(0.3))
    y = int(rng.integers(5))
    yield one_ray(at(2.5, y + 0.5, math.pi), 2.5)
    yield one_ray(at(5.5, y + 0.5, 0.0), 2.75)


@lru_cache(maxsize=1)
def _lidar() -> Callable[[Floats, int], Floats]:
    lidar: Callable[[Floats, int], Floats] = initial_globals(ROOM_KIT)["lidar"]
    return lidar


def seen_from(pose: Floats, rays: int, portee_max: float, l: Floats | None = None) -> Integration:  # noqa: E741
    """The noiseless scan of the room; a ray that goes beyond the range reads it."""
    scan = np.minimum(_lidar()(pose, rays), portee_max)
    return Integration(np.zeros(ROOM.shape) if l is None else l, pose, scan, portee_max)


def whole_scans(rng: Rng) -> Iterator[Integration]:
    """Few rays, then many, from a room with pillars; twice on a grid that is no longer empty."""
    yield seen_from(at(2.5, 2.5, 0.0), 2, FAR)
    yield seen_from(at(2.5, 2.5, QUARTER), 4, FAR)
    yield seen_from(at(7.4, 2.3, 0.4), 3, FAR)
    yield seen_from(at(3.4, 4.6, -2.5), 5, FAR)
    yield seen_from(at(8.3, 4.4, 1.3), 7, 3.3)
    yield seen_from(at(2.5, 2.5, 0.0), 4, 1.4)
    for source in (np.random.default_rng(TELLING), rng):
        for rays, portee_max in ((36, FAR), (36, 4.0), (11, FAR)):
            y, x = source.choice(np.argwhere(ROOM)) + source.uniform(0.15, 0.85, 2)
            pose = at(x, y, source.uniform(-math.pi, math.pi))
            grid = np.round(source.uniform(-4.0, 4.0, ROOM.shape), 1) if rays == 11 else None
            yield seen_from(pose, rays, portee_max, grid)


def to_keep(rng: Rng, shape: tuple[int, int]) -> Integration:
    """Arguments for a program on a map of that shape."""
    grid = np.round(rng.uniform(-3.0, 3.0, shape), 2)
    return Integration(grid, at(4.3, 4.6, rng.uniform(-3.0, 3.0)), rng.uniform(1.0, 3.0, 9), FAR)
