"""Empty rectangles of a grid: how far one can go from each cell, in each direction, without meeting a wall.

They are distance maps that look ahead only: the side of the largest empty square that has a cell for corner is the
chessboard distance to the walls of one quadrant. Such a square is then stretched along one axis as far as it stays
empty, so that a ray along a wall is not held back by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Grid = NDArray[np.bool_]
Integers = NDArray[np.int32]


def empty_squares(wall: Grid) -> Integers:
    """The side (m, H, W) of the largest square of empty cells whose least corner is each cell of `wall` (m, H, W).

    k(y, x) = 0 on a wall, else 1 + min(k(y, x + 1), k(y + 1, x), k(y + 1, x + 1)): a classic of dynamic programming.
    Along a row, with a(x) = 1 + min(k(y + 1, x), k(y + 1, x + 1)), or 0 on a wall, it unrolls into

        k(x) = min over j >= x of a(j) + j - x                                                                  (1)

    a running minimum, taken for all the rows `y` of the m grids at once. Outside of the grids, all is wall.
    """
    maps, height, width = wall.shape
    sides = np.zeros((height + 1, maps, width + 1), dtype=np.int32)
    column = np.arange(width, dtype=np.int32)
    empty = (~wall).transpose(1, 0, 2).astype(np.int32)
    for y in range(height - 1, -1, -1):
        below = sides[y + 1]
        ends = (np.minimum(below[:, :-1], below[:, 1:]) + 1) * empty[y] + column
        sides[y, :, :-1] = np.minimum.accumulate(ends[:, ::-1], axis=1)[:, ::-1] - column
    return np.ascontiguousarray(sides[:-1, :, :-1].transpose(1, 0, 2))


def stretched_widths(wall: Grid, sides: Integers) -> Integers:
    """The width (m, H, W) of the widest empty rectangle of height `sides` with each cell for least corner.

    It is the least, over `sides` rows, of the free run that starts in the cell's column. Minima over 2^p rows are
    made from those over 2^(p - 1); two of them, overlapping, cover any number of rows.
    """
    runs = _free_runs(wall)
    found, flat, stride = np.zeros(runs.size, dtype=np.int32), sides.ravel(), wall.shape[2]
    rows = 1
    while True:
        chosen = np.flatnonzero((flat >= rows) & (flat < 2 * rows))
        level = runs.ravel()
        found[chosen] = np.minimum(level[chosen], level[chosen + (flat[chosen] - rows) * stride])
        if not np.any(flat >= 2 * rows):
            return found.reshape(runs.shape)
        runs = runs.copy()
        runs[:, :-rows] = np.minimum(runs[:, :-rows], runs[:, rows:])
        rows *= 2


def _free_runs(wall: Grid) -> Integers:
    """How many empty cells (m, H, W) follow one another along x, from each cell on."""
    column = np.arange(wall.shape[2], dtype=np.int32)
    ends = np.where(wall, column, np.int32(wall.shape[2]))
    return np.asarray(np.minimum.accumulate(ends[:, :, ::-1], axis=2)[:, :, ::-1] - column)
