"""The rays of l20/lidar, simplest first: the map, the start, the direction and the range of each.

None of the maps is the kit's, none is square, and only some have walls around them. What is drawn is drawn again until
it is judged: see `judged`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Arguments, Floats
from graders.l20 import world
from reference.world.raycast import cast_rays

Grid = NDArray[np.bool_]
Rng = np.random.Generator
Drawing = Callable[[Rng], Iterator[Arguments]]

#: How far from a wall's corner a ray must pass to be judged: a march of steps of 0.1 sees all other corners.
GRAZING = 0.06
#: How far a start must be from the lines of the grid: in which cell it is then leaves no doubt.
INSIDE = 0.06
#: How far beyond what it reads a ray is looked at, since a march ends beyond the wall.
BEYOND = 0.15
QUARTER = math.pi / 2
#: Draws that are the same in every grading come first: all known mistakes that some draws miss fail on these.
TELLING = 5


def plan(drawing: str) -> Grid:
    """A map (H, W) drawn with `#` for walls; True where free."""
    return np.array([[cell != "#" for cell in line] for line in drawing.split()])


#: Surrounded by walls.
ROOM = plan("""
##########
#........#
#..#.....#
#........#
#.....#..#
#........#
##########
""")
#: Wide, and open on all sides: a row or a column left by one end is free at the other end too.
WIDE = plan("""
.........
..#......
.....#...
.........
#......#.
.........
""")
#: Tall, and open on all sides.
TALL = plan("""
.....
.....
..#..
.....
.....
...#.
.....
.....
""")
#: Open on all sides, by a part of each: there too, the cells across are free.
NOTCHED = plan("""
..#......
.........
#...#....
........#
.........
......#..
""")
#: Rays (x, y, angle) that cut a corner of a wall of `ROOM`, and go through it for a fifth or two fifths of a cell.
CUT = ((1.2, 3.94, -QUARTER / 2), (1.2, 4.08, -QUARTER / 2), (5.3, 2.18, QUARTER / 2))
#: Rays that meet their first wall so squarely that steps of half a cell do not jump it.
NEAR_WALLS = (
    (2.3, 3.7, 0.0), (2.3, 3.7, QUARTER), (5.8, 1.4, math.pi), (7.6, 4.8, -QUARTER), (4.4, 3.3, 2.0), (4.4, 3.3, -0.3),
    (1.7, 4.6, 1.2), (7.3, 1.6, -1.1), (8.6, 4.8, 2.8), (8.6, 4.8, -2.2),
)  # fmt: skip
#: A corridor longer than any range that is asked, and than the kit's map is wide.
CORRIDOR = np.pad(np.ones((2, 30), dtype=bool), 1)
#: A hall without a wall: across it, as many lines of the grid are met as can be.
HALL = np.ones((9, 10), dtype=bool)


def distance(libres: Grid, x: float, y: float, angle: float, portee_max: float) -> float:
    """The right answer; kept, since most rays are the same in every grading."""
    return _distance(libres.shape, libres.tobytes(), x, y, angle, portee_max)


@lru_cache(maxsize=1024)
def _distance(shape: tuple[int, int], free: bytes, x: float, y: float, angle: float, portee_max: float) -> float:
    libres = np.frombuffer(free, dtype=np.bool_).reshape(shape)
    return float(cast_rays(libres, [[x, y]], [angle], portee_max)[0])


@lru_cache(maxsize=64)
def _corners(shape: tuple[int, int], walls: bytes) -> Floats:
    """The corners (n, 2) = (x, y) of all the cells of wall, those around the grid included."""
    height, width = shape
    framed = np.pad(np.frombuffer(walls, dtype=np.bool_).reshape(shape), 1, constant_values=True)
    touched = np.zeros((height + 3, width + 3), dtype=np.bool_)
    for down in (0, 1):
        for right in (0, 1):
            touched[down : down + height + 2, right : right + width + 2] |= framed
    return np.asarray(np.argwhere(touched)[:, ::-1] - 1.0, dtype=np.float64)


def judged(args: Arguments) -> bool:
    """Does the ray start in a free cell, off the grid's lines, and pass all corners of walls at more than `GRAZING`?"""
    libres, x, y, angle, portee_max = args
    height, width = libres.shape
    if not (0.0 < x < width and 0.0 < y < height and libres[math.floor(y), math.floor(x)] and portee_max > 0.0):
        return False
    if any(abs(value - round(value)) < INSIDE for value in (x, y)):
        return False
    length = distance(*args) + BEYOND
    away = _corners(libres.shape, (~libres).tobytes()) - (x, y)
    heading = np.array([math.cos(angle), math.sin(angle)])
    along = np.clip(away @ heading, 0.0, length)
    gaps = np.linalg.norm(away - along[:, None] * heading, axis=1)
    return bool(gaps.min() > GRAZING)


def telling_then(rng: Rng) -> tuple[Rng, Rng]:
    """The generator of what is always drawn, then this one."""
    return np.random.default_rng(TELLING), rng


def near_walls(rng: Rng) -> Iterator[Arguments]:
    """Rays that enter their first wall for more than a coarse step, always the same ones."""
    for x, y, angle in NEAR_WALLS:
        yield ROOM, x, y, angle, 12.0


def along_x(rng: Rng) -> Iterator[Arguments]:
    return (args for args in along_axes(rng) if abs(math.cos(args[3])) > GRAZING)


def along_y(rng: Rng) -> Iterator[Arguments]:
    return (args for args in along_axes(rng) if abs(math.sin(args[3])) > GRAZING)


def along_axes(rng: Rng) -> Iterator[Arguments]:
    """Exactly along the axes, in the walled room; half a turn is asked as pi and as -pi."""
    for x, y in ((2.3, 3.7), (5.8, 1.4), (7.6, 4.8)):
        for angle in (0.0, QUARTER, math.pi, -QUARTER):
            yield ROOM, x, y, angle, 12.0
    for angle in (-math.pi, QUARTER, -QUARTER):  # by steps of a fifth, a wall is passed by more than what is accepted
        yield ROOM, 7.2, 3.35, angle, 12.0
    for source in telling_then(rng):
        for _ in range(3):
            yield _drawn(source, ROOM, 12.0, along_an_axis=True)


def oblique(rng: Rng) -> Iterator[Arguments]:
    """In every quarter of the plane, in the walled room: some rays nearer to the x axis, others to the y axis."""
    for corner in CUT:
        yield ROOM, *corner, 12.0
    for x, y in ((4.4, 3.3), (1.7, 4.6), (7.3, 1.6), (8.6, 4.8)):
        for angle in (0.4, 1.2, 2.0, 2.8, -0.3, -1.1, -2.2, -2.7):
            if judged((ROOM, x, y, angle, 12.0)):
                yield ROOM, x, y, angle, 12.0
    for source in telling_then(rng):
        for _ in range(4):
            yield _drawn(source, ROOM, 12.0)


def within_range(rng: Rng) -> Iterator[Arguments]:
    """Ranges shorter than the kit's: walls beyond, walls before, walls that a last step would just reach."""
    yield ROOM, 1.4, 5.5, 0.0, 4.0
    yield ROOM, 1.4, 5.5, 0.0, 9.0
    yield ROOM, 4.6, 3.3, math.pi, 2.7
    yield ROOM, 3.2, 5.5, math.pi, 4.0
    yield ROOM, 3.2, 4.8, -2.6, 5.0
    yield ROOM, 4.6, 3.3, -QUARTER, 0.45
    yield ROOM, 4.4, 5.3, -1.2, 3.15
    yield ROOM, 4.4, 5.3, -1.2, 5.0
    yield CORRIDOR, 1.3, 1.6, 0.0, 12.0
    yield CORRIDOR, 19.59, 1.6, 0.0, 12.0
    yield CORRIDOR, 18.85, 1.6, 0.0, 12.0
    yield CORRIDOR, 28.3, 2.3, math.pi, 11.9
    yield CORRIDOR, 2.25, 1.3, 0.03, 10.05
    yield CORRIDOR, 12.6, 1.4, 3.09, 10.33
    yield CORRIDOR, 27.2, 2.7, -3.1, 12.0
    yield CORRIDOR, 26.4, 2.7, -3.1, 8.0
    yield WIDE, 1.45, 5.5, -0.4, 2.62
    for source in telling_then(rng):
        for portee_max in (1.3, 2.45, 3.8, 5.27):
            yield _drawn(source, ROOM, portee_max)


def over_the_edge(rng: Rng) -> Iterator[Arguments]:
    """Out of maps that no wall surrounds, by their four sides, straight and slanted, then across all lines of one."""
    for libres, x, y in ((WIDE, 4.3, 3.6), (TALL, 1.6, 4.3), (WIDE, 7.8, 1.3)):
        for angle in (0.0, QUARTER, math.pi, -QUARTER, 0.35, 1.3, 1.9, 2.75, -0.45, -1.25, -1.85, -2.6):
            if judged((libres, x, y, angle, 12.0)):
                yield libres, x, y, angle, 12.0
    for angle in (0.0, QUARTER, math.pi, -QUARTER, 1.3, -1.85):
        yield NOTCHED, 3.4, 4.3, angle, 12.0
    yield HALL, 0.9, 0.9, math.atan2(8.1, 8.25), 12.0
    yield HALL, 9.1, 8.1, math.atan2(-8.1, -8.25), 12.0
    for source in telling_then(rng):
        for libres in (WIDE, TALL, WIDE):
            yield _drawn(source, libres, 12.0)


def anywhere(rng: Rng) -> Iterator[Arguments]:
    """Maps drawn at random, wide or tall, walled or open; any start, any direction, several ranges."""
    for source in telling_then(rng):
        for height, width in ((7, 11), (11, 6), (9, 14), (12, 8)):
            libres = world.random_map(source, height, width, fill=0.12)
            for free in (libres, np.ascontiguousarray(libres[1:-1, 1:-1])):
                yield _drawn(source, free, 12.0)
                yield _drawn(source, free, round(float(source.uniform(1.5, 7.0)), 2))


def _drawn(rng: Rng, libres: Grid, portee_max: float, *, along_an_axis: bool = False) -> Arguments:
    """A ray from anywhere in a map, to two decimals, that is judged."""
    cells = world.free_cells(libres)
    while True:
        y, x = cells[int(rng.integers(len(cells)))] + np.round(rng.uniform(0.1, 0.9, 2), 2)
        angle = round(float(rng.uniform(-math.pi, math.pi)), 2)
        if along_an_axis:
            angle = float(rng.choice([0.0, QUARTER, math.pi, -QUARTER]))
        args = (libres, round(float(x), 2), round(float(y), 2), angle, portee_max)
        if judged(args) and (angle or along_an_axis):
            return args


def keep_range(value: float) -> Iterator[float]:
    return iter(())


def shrink_map(value: Grid) -> Iterator[Grid]:
    """Without its obstacles, then without its last rows or columns: what lies at the origin stays there.

    A map that walls surround stays so: what fails there is not to be explained by a map that has none.
    """
    closed = not (value[[0, -1]].any() or value[:, [0, -1]].any())
    height, width = value.shape
    empty = _framed(height, width) if closed else np.ones_like(value)
    if not np.array_equal(value, empty):
        yield empty
    for rows, columns in ((height // 2, width // 2), (height // 2, width), (height, width // 2),
                          (height - 1, width), (height, width - 1)):  # fmt: skip
        if min(rows, columns) > 2 * closed and (rows, columns) != (height, width):
            kept = value[:rows, :columns]
            yield kept & _framed(rows, columns) if closed else np.ascontiguousarray(kept)


def _framed(height: int, width: int) -> Grid:
    return np.pad(np.ones((height - 2, width - 2), dtype=bool), 1)


def shrink_place(value: float) -> Iterator[float]:
    """To the middle of the cell, then to one decimal."""
    for candidate in (math.floor(value) + 0.5, round(value, 1)):
        if candidate != value and round(2 * value) != 2 * value:
            yield candidate


def shrink_angle(value: float) -> Iterator[float]:
    """To the axis that is nearest, then to half a quarter turn, then to one decimal."""
    axis = QUARTER * round(value / QUARTER)
    if value != axis:
        yield axis
        diagonal = QUARTER / 2 * round(value / (QUARTER / 2))
        if value != diagonal:
            yield diagonal
            if round(value, 1) != value:
                yield round(value, 1)
