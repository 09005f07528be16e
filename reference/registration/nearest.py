"""Nearest neighbours of points that move little by little: exact, and searched again only where in doubt.

A search keeps the K nearest targets of a point and the distance d_K of the last of them. When the point has since moved
by m, every target left out is still at d_K - m or more (triangle inequality); so while one of the K is within that, the
nearest of the K is the nearest of all, and no search is needed. Near the end of an ICP almost every point is spared.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]

KEPT = 8
SLACK = 1.0 - 1e-12


class NearestPoints:
    """The one of `targets` (m,) nearest to each of n points that are shown again and again as they move: x + i y."""

    def __init__(self, targets: Complexes) -> None:
        self._tree = cKDTree(to_coordinate_rows(targets), balanced_tree=False)
        self._targets = np.append(targets, np.inf)  # the row m stands where there are fewer than K
        self._asked_at: Complexes | None = None
        self.searches = 0

    def find(self, points: Complexes) -> tuple[Floats, Indices]:
        """Distances (n,) to the nearest targets, and their rows (n,), for points (n,), the same n each time."""
        if self._asked_at is None:
            return self._search_first(points)
        gaps = np.abs(self._around - points[:, None])
        nearest = gaps.argmin(axis=1)
        nearest += self._first
        distances, pairs = gaps.take(nearest), self._rows.take(nearest)
        doubtful = np.flatnonzero(distances > self._beyond - np.abs(points - self._asked_at))
        if doubtful.size:
            asked = points[doubtful]
            found, rows = self._search_targets(asked)
            self._asked_at[doubtful], self._rows[doubtful] = asked, rows
            self._around[doubtful] = self._targets[rows]
            self._beyond[doubtful] = SLACK * found[:, -1]
            distances[doubtful], pairs[doubtful] = found[:, 0], rows[:, 0]
        return distances, pairs

    def _search_first(self, points: Complexes) -> tuple[Floats, Indices]:
        """The first search, of all points; `_beyond` (n,): how far every target that is not among the K is at least."""
        found, self._rows = self._search_targets(points)
        self._asked_at, self._around = points.copy(), self._targets[self._rows]
        self._beyond = SLACK * found[:, -1]
        self._first = np.arange(len(points)) * KEPT
        return found[:, 0].copy(), self._rows[:, 0].copy()

    def _search_targets(self, points: Complexes) -> tuple[Floats, Indices]:
        """Distances (n, K) to the nearest targets, nearest first, and their rows (n, K); infinity and m for none."""
        self.searches += len(points)
        distances, rows = self._tree.query(to_coordinate_rows(points), k=KEPT)
        return np.asarray(distances), np.asarray(rows, dtype=np.int64)


def to_coordinate_rows(points: Complexes) -> Floats:
    """Points x + i y (n,) as rows (x, y), (n, 2)."""
    return np.ascontiguousarray(points).view(np.float64).reshape(-1, 2)


def squared_moduli(gaps: Complexes) -> Floats:
    """|z|^2, elementwise."""
    return np.asarray(gaps.real**2 + gaps.imag**2)
