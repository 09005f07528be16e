"""What is right in l20/planifier, from `reference`: inflated cells, the price of a path, the least price of all."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import hypot

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Floats
from reference.planning import PlanningError, SearchGrid, UnreachableError
from reference.world.distance_map import distances_to_cells

Cell = tuple[int, int]
Grid = NDArray[np.bool_]

FREE, WALL, UNKNOWN = 0, 100, -1


def right_permitted(grid: NDArray[np.int64], radius: float, resolution: float) -> Grid:
    """The free cells farther than `radius` metres from every wall. Outside of the grid, nothing is a wall."""
    return np.asarray((grid == FREE) & (resolution * distances_to_cells(grid == WALL) > radius))


def right_price(path: Sequence[Cell], costs: Floats) -> float:
    """The length of each step, in cells, times one plus the mean cost of its two cells."""
    return float(sum(hypot(a[0] - b[0], a[1] - b[1]) * (1.0 + (costs[a] + costs[b]) / 2.0) for a, b in pairwise(path)))


def best_path(permitted: Grid, costs: Floats, start: Cell, goal: Cell) -> list[Cell]:
    """A cheapest path, from start to goal; empty where there is none."""
    return list(_best(permitted.tobytes(), costs.tobytes(), permitted.shape, start, goal))


@lru_cache(maxsize=512)
def _best(permitted: bytes, costs: bytes, shape: tuple[int, int], start: Cell, goal: Cell) -> Sequence[Cell]:
    free, prices = np.frombuffer(permitted, bool).reshape(shape), np.frombuffer(costs).reshape(shape)
    try:
        cells = SearchGrid(free, np.where(free, prices, 0.0)).astar(start, goal).cells
    except (UnreachableError, PlanningError):
        return ()
    return tuple((int(y), int(x)) for y, x in cells)
