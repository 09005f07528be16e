"""Clear cones of a grid: how many columns a ray can cross from each cell, within a range of slopes, and meet no wall.

They are distance maps that look ahead only, and no wider than the rays that they are asked about: where a disc or a
square must be empty to grant a leap, here only the cone must be that all rays of such a slope, from anywhere on the
side of the cell by which they come in, may sweep.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Grid = NDArray[np.bool_]
Counts = NDArray[np.uint8]

# Counts are bytes: a longer way is crossed in several leaps.
MOST = 255


def clear_leap_lengths(wall: Grid, sectors: int) -> Counts:
    """How far rays may leap, (m, sectors, L, R, 2), on maps `wall` (m, L, R) framed by walls, at most MOST.

    A ray comes into column `i` by row `r` and goes towards greater columns and rows, with a slope, in rows a column, of
    [k / sectors, (k + 1) / sectors] for sector k. Element (k, i, r, c) is the number of columns, column `i` included,
    that hold no wall on its way, where c tells whether it leaves the column by row r + 1 or by row r: 0 if and only if
    the ray meets a wall in column `i` itself.
    """
    free = np.pad(~wall, ((0, 0), (0, 1), (0, 1))).view(np.uint8)
    columns, rows = wall.shape[1:]
    found = np.empty((len(wall), sectors, columns, rows, 2), dtype=np.uint8)
    own = free[:, :-1, :-1]
    for k in range(sectors):
        beyond = clear_cone_lengths(wall, k, sectors)[:, 1:] + np.uint8(1)
        np.multiply(own, beyond[:, :, :-1], out=found[:, k, :, :, 0])
        np.multiply(own & free[:, :-1, 1:], beyond[:, :, 1:], out=found[:, k, :, :, 1])
    return found


def clear_cone_lengths(wall: Grid, k: int, sectors: int) -> Counts:
    """How many columns are empty in each cell's cone, (m, L + 1, R + 1), on maps `wall` (m, L, R), at most MOST - 1.

    The cone of (i, r) holds what rays may touch that come into column i within row r, with a slope of sector k. After
    n = `sectors` columns they are in row r + k or r + k + 1, so that with a(i, r) for how many of these n columns are
    empty in the cone,

        N(i, r) = a(i, r) if a(i, r) < n, else n + min(N(i + n, r + k), N(i + n, r + k + 1))                   (1)

    which is taken for n columns at a time, from the last ones on. Outside of the maps all is wall.
    """
    maps, columns, rows = wall.shape
    padded = -columns % sectors + columns
    free = np.zeros((maps, padded + sectors, rows + k + 2), dtype=np.uint8)
    free[:, :columns, :rows] = ~wall
    clear = np.ones((maps, padded, rows), dtype=np.uint8)
    ahead = np.zeros_like(clear)
    for j in range(sectors):
        # From r + k j / n at the least, when column i + j is entered, to r + 1 + (k + 1) (j + 1) / n when it is left.
        for row in range(k * j // sectors, 1 - (-(k + 1) * (j + 1) // sectors)):
            clear &= free[:, j : padded + j, row : row + rows]
        ahead += clear
    found = np.zeros_like(free)
    for i in range(padded - sectors, -1, -sectors):
        here, beyond = slice(i, i + sectors), found[:, i + sectors : i + 2 * sectors]
        further = np.minimum(beyond[:, :, k : k + rows], beyond[:, :, k + 1 : k + 1 + rows])
        np.minimum(further, MOST - 1 - sectors, out=further)
        further *= clear[:, here]
        np.add(further, ahead[:, here], out=found[:, here, :rows])
    return found[:, : columns + 1, : rows + 1]
