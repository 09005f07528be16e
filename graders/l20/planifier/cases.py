"""The maps that submissions are graded on: drawn in characters, one for each edge of the statement, then at random.

No radius comes within MARGIN of a distance between two cells, and no best path is told from a wrong one by rounding.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Arguments, Floats
from graders.l20.planifier.truth import FREE, UNKNOWN, WALL, Cell, Grid, best_path

#: Of a radius, from all distances between cells, in cells.
MARGIN = 1e-3
#: Widest side of a map.
WIDEST = 20
#: Seed of the maps that never change.
TELLING = 20
SIGNS = {".": FREE, "#": WALL, "?": UNKNOWN}

_SIDES = np.arange(WIDEST + 2)
DISTANCES = np.unique(np.hypot(_SIDES[:, None], _SIDES))


def grid(*rows: str) -> NDArray[np.int64]:
    """A map of free cells `.`, walls `#`, unknown cells `?`."""
    return np.array([[SIGNS[sign] for sign in row] for row in rows], dtype=np.int64)


def floor(*rows: str) -> Grid:
    """Cells that are permitted, `.`, or not, `#`."""
    return np.array([[sign == "." for sign in row] for row in rows])


def no_cost(permitted: Grid) -> Floats:
    return np.zeros(permitted.shape)


def is_radius(args: Arguments) -> bool:
    """Is there a wall, and is the radius clear of every distance between two cells?"""
    cells, radius, resolution = args
    clear = radius == 0.0 or float(np.min(np.abs(DISTANCES - radius / resolution))) > MARGIN
    return bool(np.any(cells == WALL) and clear and radius >= 0.0 and resolution > 0.0)


def inflations_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """One wall in a row, the example of the statement, no radius, a wall in a corner, unknown cells, two walls."""
    yield grid("#...."), 0.12, 0.05
    yield grid("....#", ".?...", "....."), 0.08, 0.05
    yield grid("....#", ".?...", "....."), 0.07, 0.05
    yield grid("#.?", "..."), 0.0, 0.05
    yield grid("#....", ".....", "....."), 0.5, 0.3
    yield grid("..#", "..."), 1.7, 0.5
    yield grid("?....", ".....", "....#"), 1.5, 1.0
    yield grid("#......", ".......", ".......", "......#"), 0.27, 0.1


def inflations(rng: np.random.Generator) -> Iterator[Arguments]:
    """Radii from less than a cell to several, cells of all sizes, a map that is taller than wide, one that is full."""
    yield grid(".....", ".....", "..#..", ".....", "....."), 0.45, 0.2
    yield grid("...", "...", "...", "...", "#..", "...", "..."), 3.1, 1.0
    yield grid("##", "?#"), 0.25, 0.1
    telling = np.random.default_rng(TELLING)
    for source, count in ((telling, 4), (rng, 4)):
        yield from (_inflation(source) for _ in range(count))


def _inflation(rng: np.random.Generator) -> Arguments:
    while True:
        shape = tuple(int(n) for n in rng.integers(4, 15, 2))
        cells = rng.choice([FREE, WALL, UNKNOWN], shape, p=[0.88, 0.06, 0.06])
        resolution = float(rng.choice([0.05, 0.1, 0.25, 2.0]))
        radius = float(np.round(resolution * rng.uniform(0.6, 4.0), 4))
        if is_radius((cells, radius, resolution)):
            return cells, radius, resolution


def paths_to_price(rng: np.random.Generator) -> Iterator[Arguments]:
    """One cell, a straight step, a diagonal one, the same with costs, a way there and back, then drawn ones."""
    flat = np.zeros((3, 4))
    hill = np.array([[0.0, 1.0, 0.0, 4.0], [2.0, 0.0, 0.0, 3.0], [0.0, 0.5, 6.0, 0.0]])
    yield [(1, 2)], hill
    yield [(0, 0), (0, 1)], flat
    yield [(0, 0), (1, 1)], flat
    yield [(0, 0), (0, 1)], hill
    yield [(0, 1), (1, 0)], hill
    yield [(0, 0), (0, 1), (1, 2), (2, 2), (2, 3)], hill
    yield [(2, 0), (2, 1), (2, 2), (2, 1)], hill
    yield [(2, 3), (1, 3), (0, 2)], hill
    yield [(0, 0), (1, 1), (1, 2)], np.array([[0.0, 0.0, 0.0], [0.0, 400.0, 90.0]])
    for length in (4, 9):
        costs = np.round(rng.uniform(0.0, 6.0, (6, 7)), 1)
        yield _walk(rng, costs, length), costs


def _walk(rng: np.random.Generator, costs: Floats, length: int) -> list[Cell]:
    """Steps to neighbours, wherever they lead."""
    (height, width), path = costs.shape, [(2, 3)]
    while len(path) < length:
        i, j = path[-1][0] + int(rng.integers(-1, 2)), path[-1][1] + int(rng.integers(-1, 2))
        if 0 <= i < height and 0 <= j < width and (i, j) != path[-1]:
            path.append((i, j))
    return path


CORNER = floor("..", "#.")
PILLAR = floor("...", ".#.", "...")
DETOUR = floor("...#..", ".#.#..", ".#...#", ".###..", "......")
#: The nearest cell to the goal is the bottom of a bag.
BAG = floor(".......", ".####..", "....#..", ".####..", ".......")
OPEN = floor("......", "......", "......", "......")
TALL = floor("...", "...", "##.", "...", ".##", "...", "...")
#: Where a distance that counts a diagonal for two, or a multiple of the distance, opens a longer way first.
HASTY = floor(".###", "...#", ".#..", "....")
TWO_WALLS = floor("...#..", ".#....", "......")
#: The same for a distance in which one axis stands twice.
WINDING = floor(".....", "#.#..", "#....", "..##.", ".#...", "..##.", ".#...")
FOLDED = floor("...#", ".#..", "....", "....", "....")
#: Where |di| + |dj|, which counts a diagonal for two, goes left of a wall that is passed on the right.
FORKED = floor(".....", "..#..", ".#...", ".....", "#....")


def shortest(rng: np.random.Generator) -> Iterator[Arguments]:
    """No costs: corners that must not be cut, bags, ways back, diagonals, maps without a border."""
    for permitted, start, goal in (
        (floor("..."), (0, 0), (0, 2)),
        (floor("..", ".."), (0, 0), (1, 1)),
        (CORNER, (0, 0), (1, 1)),
        (PILLAR, (0, 1), (2, 1)),
        (OPEN, (0, 0), (3, 5)),
        (OPEN, (3, 4), (1, 0)),
        (TALL, (0, 0), (6, 0)),
        (DETOUR, (0, 5), (2, 2)),
        (BAG, (2, 0), (2, 6)),
        (HASTY, (2, 0), (2, 3)),
        (TWO_WALLS, (1, 0), (1, 5)),
        (HASTY[::-1].copy(), (1, 0), (1, 3)),
        (HASTY[:, ::-1].copy(), (2, 3), (2, 0)),
        (TWO_WALLS[::-1, ::-1].copy(), (1, 5), (1, 0)),
        (TWO_WALLS.T.copy(), (0, 1), (5, 1)),
        (FOLDED, (4, 3), (0, 0)),
        (WINDING, (4, 2), (0, 1)),
        (FORKED, (0, 2), (4, 1)),
    ):
        yield permitted, no_cost(permitted), start, goal
    for permitted, _, start, goal in (*_always()[:3], _maze(rng), _maze(rng)):
        yield permitted, no_cost(permitted), start, goal


#: By how much a corridor is dearer that an estimate a hundredth too large prefers.
DEARER = 0.1


def _ridge() -> Floats:
    costs = np.zeros((5, 7))
    costs[1:4, 3] = 5.0
    return costs


def _slope() -> Floats:
    """Dear above, cheap below: the way that starts worse ends better."""
    costs = np.zeros((4, 6))
    costs[0], costs[1] = [0.0, 0.2, 0.4, 3.0, 3.0, 0.0], [0.0, 1.0, 1.0, 1.0, 3.0, 0.0]
    return costs


def nearing_corridors() -> Arguments:
    """Two corridors around a block; the one that comes first into the columns near the goal is dearer by `DEARER`."""
    permitted = floor("." * 15, "." + 13 * "#" + ".", "." * 15)
    costs = np.zeros(permitted.shape)
    costs[2, 12:14] = DEARER / 2
    return permitted, costs, (2, 0), (0, 14)


def cheapest(rng: np.random.Generator) -> Iterator[Arguments]:
    """A ridge to go around, or to cross; the example of the statement; costs of the first, and of the last cell."""
    stated = floor("...##", ".#.##", ".....")
    dear = np.zeros((3, 5))
    dear[1, 0] = 1.0
    yield stated, dear, (0, 0), (2, 4)
    yield floor("...", "...", "..."), np.array([[0.0, 0, 0], [0, 9, 0], [0, 0, 0]]), (0, 0), (2, 2)
    yield floor("....", "...."), np.array([[0.0, 0.3, 0.3, 0.0], [0.2, 0.2, 0.2, 0.2]]), (0, 0), (0, 3)
    yield np.ones((5, 7), dtype=bool), _ridge(), (2, 0), (2, 6)
    yield np.ones((4, 6), dtype=bool), _slope(), (0, 0), (0, 5)
    yield np.ones((5, 7), dtype=bool), 0.1 * _ridge(), (2, 0), (2, 6)
    # Two diagonals around a cell, 2.83, are cheaper than two straight steps through it, 3.
    yield floor("....", "...."), np.array([[0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]), (1, 3), (1, 1)
    yield nearing_corridors()
    yield from _always()
    yield _maze(rng)
    yield _maze(rng)


def without_a_path(rng: np.random.Generator) -> Iterator[Arguments]:
    """A closed room, start or goal in a wall, one cell alone, start and goal at one place, corners that touch."""
    shut = floor("..#..", "..#..")
    yield shut, no_cost(shut), (0, 0), (0, 4)
    yield floor("..."), np.zeros((1, 3)), (0, 1), (0, 1)
    yield floor("."), np.array([[2.0]]), (0, 0), (0, 0)
    yield floor("#."), np.zeros((1, 2)), (0, 0), (0, 1)
    yield floor(".#"), np.zeros((1, 2)), (0, 0), (0, 1)
    yield floor("#"), np.zeros((1, 1)), (0, 0), (0, 0)
    yield floor(".#", "#."), np.zeros((2, 2)), (0, 0), (1, 1)
    yield floor("#.", ".."), np.zeros((2, 2)), (0, 0), (1, 1)
    yield floor("..", ".#"), np.zeros((2, 2)), (0, 0), (1, 1)
    wrapped = floor(".###.", ".###.")
    yield wrapped, no_cost(wrapped), (0, 0), (0, 4)


@lru_cache(maxsize=1)
def _always() -> tuple[Arguments, ...]:
    telling = np.random.default_rng(TELLING)
    return tuple(_maze(telling) for _ in range(8))


def _maze(rng: np.random.Generator) -> Arguments:
    """A map with costs, and a way of six cells at least from start to goal."""
    while True:
        height, width = (int(n) for n in rng.integers(6, 12, 2))
        permitted = rng.random((height, width)) > 0.25
        costs = np.round(rng.uniform(0.0, 2.0, (height, width)) ** 3, 1)
        cells = np.argwhere(permitted)
        start, goal = ((int(i), int(j)) for i, j in rng.choice(cells, 2, replace=False))
        if len(best_path(permitted, costs, start, goal)) >= 6:
            return permitted, costs, start, goal
