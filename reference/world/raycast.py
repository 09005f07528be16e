"""Exact ray casting on an occupancy grid, all rays advanced together.

Cell (row, column) = (y, x) covers [x, x + 1[ x [y, y + 1[; lengths are in cells, the frame is that of the grid (x along
columns, y along rows). Whatever lies outside the grid is wall.

Source: Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987): a ray is cut where it crosses
grid lines, so that no cell is stepped over and the distance is exact to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Grid = NDArray[np.bool_]


class RaycastError(InvalidArgumentError):
    """Input along which no ray can be cast; `argument` names it."""


@dataclass
class _AxisCrossings:
    """The crossings of rays with the grid lines of one axis: those still to come, one for each ray."""

    cell: NDArray[np.int64]
    step: NDArray[np.int64]
    next_at: Floats
    spacing: Floats

    @classmethod
    def from_rays(cls, start: Floats, direction: Floats) -> _AxisCrossings:
        cell = np.floor(start).astype(np.int64)
        forward = direction > 0
        with np.errstate(divide="ignore", invalid="ignore"):
            next_at = np.where(direction == 0, np.inf, (cell + forward - start) / direction)
            spacing = np.abs(1.0 / direction)
        return cls(cell, np.where(forward, 1, -1), next_at, spacing)

    def advance(self, rays: NDArray[np.int64]) -> None:
        """Cross the next line: first the distance to it, then the cell behind it."""
        self.cell[rays] += self.step[rays]
        self.next_at[rays] += self.spacing[rays]


def cast_rays(free: ArrayLike, origins: ArrayLike, angles: ArrayLike, max_range: float) -> Floats:
    """Distances (n,) to the first wall from origins (n, 2) = (x, y) at angles (n,) in radians, at most `max_range`.

    From inside a wall, or from outside the grid, a ray reads 0. A ray through the very corner of four cells enters the
    neighbour in y before the one in x. Raises RaycastError.
    """
    grid, starts, headings = check_rays(free, origins, angles, max_range)
    blocked = np.pad(~grid, 1, constant_values=True)
    x, y = (
        _AxisCrossings.from_rays(starts[:, 0], np.cos(headings)),
        _AxisCrossings.from_rays(starts[:, 1], np.sin(headings)),
    )
    inside = (x.cell >= 0) & (x.cell < grid.shape[1]) & (y.cell >= 0) & (y.cell < grid.shape[0])
    standing = inside.copy()
    standing[inside] = grid[y.cell[inside], x.cell[inside]]
    distances = np.where(standing, float(max_range), 0.0)
    rays = np.flatnonzero(standing)
    while rays.size:
        rays = _cross_next_line(blocked, x, y, rays, distances)
    return distances


def _cross_next_line(
    blocked: Grid, x: _AxisCrossings, y: _AxisCrossings, rays: NDArray[np.int64], distances: Floats
) -> NDArray[np.int64]:
    """Move each ray over its next grid line; write down the distances of those that end and return the others."""
    through_x = x.next_at[rays] < y.next_at[rays]
    travelled = np.where(through_x, x.next_at[rays], y.next_at[rays])
    flying = travelled < distances[rays]
    rays, through_x, travelled = rays[flying], through_x[flying], travelled[flying]
    x.advance(rays[through_x])
    y.advance(rays[~through_x])
    hit = blocked[y.cell[rays] + 1, x.cell[rays] + 1]
    distances[rays[hit]] = travelled[hit]
    return rays[~hit]


def cast_scans(free: ArrayLike, poses: ArrayLike, beams: int, max_range: float) -> Floats:
    """Scans (m, beams) seen from poses (m, 3): beam k points at theta + 2 pi k / beams. Raises RaycastError."""
    frames = np.asarray(poses, dtype=np.float64)
    if frames.ndim != 2 or frames.shape[1] != 3:
        raise RaycastError("poses", f"has shape {frames.shape}, not (m, 3)")
    if beams < 1:
        raise RaycastError("beams", f"{beams} beams make no scan")
    angles = frames[:, 2:] + 2.0 * np.pi * np.arange(beams) / beams
    origins = np.repeat(frames[:, :2], beams, axis=0)
    return cast_rays(free, origins, angles.ravel(), max_range).reshape(len(frames), beams)


def check_rays(free: ArrayLike, origins: ArrayLike, angles: ArrayLike, max_range: float) -> tuple[Grid, Floats, Floats]:
    """The grid (H, W), origins (n, 2) and angles (n,) as arrays. Raises RaycastError for what cannot be cast."""
    grid = np.asarray(free, dtype=np.bool_)
    starts, headings = np.asarray(origins, dtype=np.float64), np.asarray(angles, dtype=np.float64)
    if grid.ndim != 2 or grid.size == 0:
        raise RaycastError("free", f"has shape {grid.shape}, not (H, W)")
    if headings.ndim != 1 or not np.all(np.isfinite(headings)):
        raise RaycastError("angles", "is not an array (n,) of finite numbers")
    if starts.shape != (len(headings), 2) or not np.all(np.abs(starts) < 2**31):
        raise RaycastError("origins", f"is not an array ({len(headings)}, 2) of finite numbers")
    if not 0.0 < max_range < np.inf:
        raise RaycastError("max_range", f"{max_range} is not a positive length")
    return grid, starts, headings
