"""The cells that segments cross on a grid, all segments and all crossings at once.

A segment from cell c0 to cell c1 enters |dx| + |dy| further cells: one at each grid line it crosses. At the k-th line
across x it enters column c0_x + k, at the row where it stands at that moment; and the other way round. No crossing
depends on the one before: nothing is marched.

Source: Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987), for the crossings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CrossedCells:
    """Cells `x`, `y` (k,), columns and rows of any grid, and the segment (k,) that crosses each, in no order."""

    segment: Indices
    x: Indices
    y: Indices


def crossed_cells(starts: ArrayLike, ends: ArrayLike) -> CrossedCells:
    """Every cell that the segments from `starts` (n, 2) to `ends` (n, 2) = (x, y) cross, both ends' cells included.

    Each cell once a segment; through the very corner of four cells, it enters the neighbour in y before the one in x.
    Raises InvalidArgumentError.
    """
    a, b = np.asarray(starts, dtype=np.float64), np.asarray(ends, dtype=np.float64)
    for name, points in (("starts", a), ("ends", b)):
        if points.ndim != 2 or points.shape[1] != 2 or not np.all(np.isfinite(points)):
            raise InvalidArgumentError(name, f"of shape {points.shape} are not finite points (n, 2)")
    if a.shape != b.shape:
        raise InvalidArgumentError("ends", f"has shape {b.shape}, not {a.shape}")
    ax, ay, bx, by = a[:, 0], a[:, 1], b[:, 0], b[:, 1]
    first_y = np.floor(ay).astype(np.int64)
    first_x = np.floor(ax).astype(np.int64)
    by_x, x_of_columns, y_of_columns = _cells_entered(ax, ay, bx, by, other_first=True)
    by_y, y_of_rows, x_of_rows = _cells_entered(ay, ax, by, bx, other_first=False)
    return CrossedCells(
        np.concatenate([np.arange(len(a)), by_x, by_y]),
        np.concatenate([first_x, x_of_columns, x_of_rows]),
        np.concatenate([first_y, y_of_columns, y_of_rows]),
    )


def _cells_entered(
    u0: Floats, v0: Floats, u1: Floats, v1: Floats, *, other_first: bool
) -> tuple[Indices, Indices, Indices]:
    """The cells (u, v) entered across the lines of axis u, and by which segment.

    On a line of axis v at that very moment, v is the cell behind that line if `other_first`, before it otherwise. How
    many lines of v were crossed is guessed from the place, then settled by comparing moments: so that rounding cannot
    make the two axes disagree about which line comes first.
    """
    c0, d0 = np.floor(u0).astype(np.int64), np.floor(v0).astype(np.int64)
    counts, across = (np.abs(np.floor(end).astype(np.int64) - start) for end, start in ((u1, c0), (v1, d0)))
    segment = np.repeat(np.arange(len(u0)), counts)
    k = np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    u0, v0, u1, v1 = (values[segment] for values in (u0, v0, u1, v1))
    c0, d0, across = (values[segment] for values in (c0, d0, across))
    moment = _crossing_time(u0, u1, c0, k)
    guess = np.floor(v0 + moment * (v1 - v0)).astype(np.int64)
    crossed = np.clip(np.abs(guess - d0), 0, across)
    one_more, one_less = (_crossing_time(v0, v1, d0, crossed + extra) for extra in (1, 0))
    before = np.less_equal if other_first else np.less
    crossed = crossed + ((crossed < across) & before(one_more, moment)) - ((crossed > 0) & ~before(one_less, moment))
    return segment, c0 + np.where(u1 > u0, k, -k), d0 + np.where(v1 > v0, crossed, -crossed)


def _crossing_time(start: Floats, end: Floats, cell: Indices, k: Indices) -> Floats:
    """When, from 0 at the start to 1 at the end, the k-th grid line is crossed; without meaning where none is."""
    line = np.where(end > start, cell + k, cell + 1 - k)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.asarray((line - start) / (end - start))
