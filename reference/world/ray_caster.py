"""Fast exact ray casting on one map: rays leap through empty rectangles and land on grid lines.

As in `raycast`, whose answers these are: cell (row, column) = (y, x) covers [x, x + 1[ x [y, y + 1[, lengths are in
cells, whatever lies outside the grid is wall. The map is prepared once, for as many rays as there will be.

Sources: Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987), for the crossing of grid lines;
Cohen and Sheffer, "Proximity clouds: an acceleration technique for 3D grid traversal" (1994), for leaps taken from a
distance map. Here the leaps are one-sided rectangles, and end on the line where the walk would have come, so that no
walk has to finish them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.world.empty_rectangles import empty_squares, stretched_widths
from reference.world.raycast import Floats, Grid, RaycastError, checked_rays

T = TypeVar("T", bound=np.generic)

MAX_SIDE = 2**15 - 3
# Half of a word for each side of a rectangle: one look-up finds both.
HALF, MASK = 16, 2**16 - 1
# A direction along an axis crosses no line of the other: its first crossing is put off, but stays a number.
LEAST_SLOPE = 1e-300
# As many rays as the nearest memory holds well, however many there are to cast.
BLOCK = 5000
# Rays that have landed are carried along until so many have: moving the others has a price too.
COMPACTION = 0.8


@dataclass
class _Rays:
    """Rays in flight, each seen in the mirror where it goes towards +x and +y.

    In that mirror, lines 0, 1, 2… of x are those ahead of the start, the first at a distance `first_x` in [0, 1] along
    x; `line_x` is the last that was crossed, -1 before any. `cell` is the place in the caster's table of the cell
    behind line 0 of both axes, `time` the length run, `number` whose ray it is. All have shape (n,).
    """

    first_x: Floats
    first_y: Floats
    slope_x: Floats
    slope_y: Floats
    inverse_x: Floats
    inverse_y: Floats
    line_x: Floats
    line_y: Floats
    time: Floats
    cell: NDArray[np.int64]
    number: NDArray[np.int64]

    def only(self, kept: NDArray[np.int64]) -> _Rays:
        return _Rays(*(getattr(self, field.name).take(kept) for field in fields(self)))

    def places(self, stride: int) -> NDArray[np.int64]:
        """Where the table tells of the cells (n,) that the rays are in."""
        offsets = (self.line_y * stride + self.line_x).astype(np.int64)
        offsets += self.cell
        return offsets

    def leap(self, widths: NDArray[np.int32], heights: NDArray[np.int32]) -> None:
        """Run to the first line beyond the empty rectangle of `widths` x `heights` (n,) that starts in the ray's cell.

        Line j of x is crossed at time (first_x + j) / slope_x. On the axis whose line is met, that line follows from
        the rectangle; on the other, it is the last one crossed by then, decided by comparing those very times: a ray
        cannot slip between two walls that touch at a corner. A tie enters the neighbour in y first. A ray in a wall,
        where sides are 0, stays as it is.
        """
        exit_x, exit_y = self.line_x + widths, self.line_y + heights
        time_x, time_y = self.first_x + exit_x, self.first_y + exit_y
        time_x *= self.inverse_x
        time_y *= self.inverse_y
        through_x = (time_x < time_y) & (widths > 0)
        time = np.maximum(self.time, np.minimum(time_x, time_y, out=time_x), out=self.time)
        # Sums of truth values stand for choices: a processor cannot foresee these, and would stumble at every second.
        passed_x, at_x = _nearest_lines(time, self.first_x, self.slope_x, self.inverse_x)
        passed_x -= at_x >= time
        np.maximum(self.line_x, passed_x, out=self.line_x)
        self.line_x += through_x
        passed_y, at_y = _nearest_lines(time, self.first_y, self.slope_y, self.inverse_y)
        passed_y -= at_y > time
        np.maximum(self.line_y, passed_y, out=self.line_y)


def _nearest_lines(time: Floats, first: Floats, slope: Floats, inverse: Floats) -> tuple[Floats, Floats]:
    """The lines of one axis that rays are nearest to at `time` (n,), and the times at which they cross them."""
    lines = time * slope
    lines -= first
    np.rint(lines, out=lines)
    crossed_at = first + lines
    crossed_at *= inverse
    return lines, crossed_at


@dataclass(frozen=True, eq=False)
class RayCaster:
    """A map `free` (H, W) made ready for casting. `table` holds, for each of 8 directions and each cell of the map
    framed by walls, the sides of an empty rectangle, packed as width * 2^16 + height."""

    free: Grid
    table: NDArray[np.int32]

    @classmethod
    def of(cls, free: ArrayLike) -> RayCaster:
        """Prepare the map `free` (H, W), up to 32,765 cells a side, into 32 bytes a cell. Raises RaycastError.

        Four mirrors make every direction one towards +x and +y; in each, rectangles are wide for rays that are nearer
        to the x axis and tall for the others.
        """
        grid = np.array(free, dtype=np.bool_)
        if grid.ndim != 2 or grid.size == 0 or max(grid.shape) > MAX_SIDE:
            raise RaycastError("free", f"has shape {grid.shape}, not (H, W) with sides from 1 to {MAX_SIDE}")
        wall = np.pad(~grid, 1, constant_values=True)
        mirrors = np.stack([wall[::step_y, ::step_x] for step_y in (1, -1) for step_x in (1, -1)])
        sides = empty_squares(mirrors)
        wide = stretched_widths(mirrors, sides)
        tall = stretched_widths(_turned(mirrors), _turned(sides)).swapaxes(1, 2)
        table = np.stack([(wide << HALF) | sides, (sides << HALF) | tall], axis=1)
        return cls(grid, table.ravel())

    def cast(self, origins: ArrayLike, angles: ArrayLike, max_range: float) -> Floats:
        """Distances (n,) to the first wall from origins (n, 2) = (x, y) at angles (n,) in radians, at most `max_range`.

        Those of `raycast.cast_rays`, to rounding; through the very corner of four cells, rounding may decide which
        neighbour comes first. From inside a wall, or from outside the grid, a ray reads 0. Raises RaycastError.
        """
        _, starts, headings = checked_rays(self.free, origins, angles, max_range)
        distances = np.zeros(len(headings))
        standing = self._standing(starts)
        for first in range(0, len(standing), BLOCK):
            block = standing[first : first + BLOCK]
            x, y = starts[:, 0].take(block), starts[:, 1].take(block)
            self._fly(self._launch(x, y, headings.take(block), block), max_range, distances)
        return distances

    def _fly(self, rays: _Rays, max_range: float, distances: Floats) -> None:
        """Let rays leap until all have landed, and write down the distances that they reached."""
        while rays.number.size:
            sides = self.table.take(rays.places(self.free.shape[1] + 2))
            flying = (sides > 0) & (rays.time < max_range)
            left = np.count_nonzero(flying)
            if left <= COMPACTION * flying.size:
                landed = np.flatnonzero(~flying)
                distances[rays.number[landed]] = np.minimum(rays.time[landed], max_range)
                rays, sides = rays.only(kept := np.flatnonzero(flying)), sides.take(kept)
            rays.leap(sides >> HALF, sides & MASK)

    def scans(self, poses: ArrayLike, angles: ArrayLike, max_range: float) -> Floats:
        """What a lidar at poses (m, 3), in cells, reads along `angles` (n,) from its heading: (m, n).

        Raises RaycastError.
        """
        frames, beams = np.asarray(poses, dtype=np.float64), np.asarray(angles, dtype=np.float64)
        if frames.ndim != 2 or frames.shape[1] != 3:
            raise RaycastError("poses", f"has shape {frames.shape}, not (m, 3)")
        if beams.ndim != 1:
            raise RaycastError("angles", f"has shape {beams.shape}, not (n,)")
        headings = (frames[:, 2:] + beams).ravel()
        origins = np.repeat(frames[:, :2], beams.size, axis=0)
        return self.cast(origins, headings, max_range).reshape(len(frames), beams.size)

    def _standing(self, starts: Floats) -> NDArray[np.int64]:
        """Which origins lie on a free cell: their indices (k,)."""
        height, width = self.free.shape
        x, y = np.floor(starts[:, 0]).astype(np.int64), np.floor(starts[:, 1]).astype(np.int64)
        inside = np.flatnonzero((x >= 0) & (x < width) & (y >= 0) & (y < height))
        return inside[self.free[y[inside], x[inside]]]

    def _launch(self, x: Floats, y: Floats, headings: Floats, numbers: NDArray[np.int64]) -> _Rays:
        height, width = self.free.shape
        first_x, slope_x, column, left = _mirrored(x, np.cos(headings), width)
        first_y, slope_y, row, down = _mirrored(y, np.sin(headings), height)
        row += (4 * (height + 2)) * down
        row += (2 * (height + 2)) * left
        row += (height + 2) * (slope_y > slope_x)
        # One more row and column: the map is framed by walls, and the start lies before line 0 of both axes.
        cell = ((row + 2.0) * (width + 2) + column + 2.0).astype(np.int64)
        inverse_x, inverse_y, time = 1.0 / slope_x, 1.0 / slope_y, np.zeros(len(numbers))
        line_x, line_y = time - 1.0, time - 1.0
        return _Rays(
            first_x, first_y, slope_x, slope_y, inverse_x, inverse_y, line_x, line_y, time, cell, numbers
        )  # fmt: skip


def _turned(maps: NDArray[T]) -> NDArray[T]:
    """The maps (m, H, W) with rows for columns, (m, W, H)."""
    return np.ascontiguousarray(maps.swapaxes(1, 2))


def _mirrored(start: Floats, slope: Floats, size: int) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Along one axis: distance to the first line, slope, cell in the mirror, and whether the axis is turned around."""
    cell = np.floor(start)
    backward = slope < 0
    first = np.abs(cell + (slope >= 0) - start)
    mirrored = np.abs(cell - (size - 1.0) * backward)
    return first, np.maximum(np.abs(slope), LEAST_SLOPE), mirrored, backward
