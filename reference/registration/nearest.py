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

KEPT = 6
SLACK = 1.0 - 1e-12


class NearestPoints:
    """The one of `targets` (m,) nearest to each of n points that are shown again and again as they move: x + i y."""

    def __init__(self, targets: Complexes) -> None:
        self._targets = targets
        self._tree = cKDTree(as_rows(targets))
        self._kept = min(KEPT, len(targets))
        self._asked_at: Complexes | None = None
        self.searches = 0

    def find(self, points: Complexes) -> tuple[Floats, Indices]:
        """Squared distances (n,) to the nearest targets, and their rows (n,), for points (n,), the same n each time."""
        if self._asked_at is None:
            self._asked_at = points.copy()
            self._candidates, self._beyond = self._search(points)
            self._all = np.arange(len(points))
        moved = np.abs(points - self._asked_at)
        squares, best = self._best(points, self._candidates)
        doubtful = np.flatnonzero(np.sqrt(squares) > SLACK * (self._beyond - moved))
        if doubtful.size:
            asked = points[doubtful]
            found, beyond = self._search(asked)
            self._asked_at[doubtful], self._candidates[doubtful], self._beyond[doubtful] = asked, found, beyond
            gaps = asked - self._targets[found[:, 0]]
            squares[doubtful], best[doubtful] = squared(gaps), found[:, 0]
        return squares, best

    def _best(self, points: Complexes, candidates: Indices) -> tuple[Floats, Indices]:
        squares = squared(self._targets[candidates] - points[:, None])
        best = squares.argmin(axis=1)
        return squares[self._all, best], candidates[self._all, best]

    def _search(self, points: Complexes) -> tuple[Indices, Floats]:
        """The rows (n, K) of the nearest targets, nearest first, and how far (n,) every other target is at least."""
        self.searches += len(points)
        found = self._tree.query(as_rows(points), k=self._kept)
        distances, rows = (np.asarray(part).reshape(len(points), -1) for part in found)
        beyond = distances[:, -1] if self._kept < len(self._targets) else np.full(len(points), np.inf)
        return rows, beyond


def as_rows(points: Complexes) -> Floats:
    """Points x + i y (n,) as rows (x, y), (n, 2)."""
    return np.ascontiguousarray(points).view(np.float64).reshape(-1, 2)


def squared(gaps: Complexes) -> Floats:
    """|z|^2, elementwise."""
    return np.asarray(gaps.real**2 + gaps.imag**2)
