"""Fast exact ray casting on one map: rays leap through clear cones, from one grid line to another.

As in `raycast`, whose answers these are: cell (row, column) = (y, x) covers [x, x + 1[ x [y, y + 1[, lengths are in
cells, whatever lies outside the grid is wall. The map is prepared once, for as many rays as there will be.

Each ray is seen in a mirror in which it goes towards greater columns and rows, and is no steeper than one row a column:
the axis along which it runs faster stands for columns. It is then known by the rows in which it crosses the lines
between columns: in a column, it stays in one row or goes on to the next one. Those rows are computed without rounding,
so that no ray slips between two walls that touch at a corner; distances are those of the line that a ray ends on.

Sources: Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987), for the crossing of grid lines;
Cohen and Sheffer, "Proximity clouds: an acceleration technique for 3D grid traversal" (1994), for leaps taken from a
distance map. Here the leaps are told by direction, and end where the walk would have come, so that no walk has to
finish them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.world.clear_cones import clear_leap_lengths
from reference.world.raycast import Floats, Grid, RaycastError, check_rays

Integers = NDArray[np.int64]

MAX_SIDE = 2**15 - 3
# Ranges of slopes that are told apart within an eighth of a turn: more of them leap further, and fill more memory.
SECTORS = 2
# Heights are whole numbers of 2^-unit rows, in words that hold so many bits of them: 46 are left to the unit of the
# largest map, over which slopes then err by less than 1e-9, and 53, as in a number between 0.5 and 1, at 200 cells.
BITS = 61
# As many rays as the nearest memory holds well, however many there are to cast.
BLOCK = 16384
# Rays that have landed are carried along until so many have: moving the others has a price too.
COMPACTION = 0.4
# The last rays go on to the end of the map at once, when that makes no more places than so many: leaping one by one
# along a wall, they would keep all the others waiting.
LAST_PLACES = 8192


@dataclass
class _FlyingRays:
    """Rays in flight, each where it comes into a column of its mirror. All have shape (n,).

    `height` is how far it then is above the row of its start, in units; `slope` how much it rises in a column,
    likewise; `origin` the place in the caster's table of that column and of the start's row; `stride` how many places
    further the next column is; `number` whose ray it is.
    """

    height: Integers
    slope: Integers
    origin: Integers
    stride: Integers
    number: Integers

    def select(self, kept: Integers) -> _FlyingRays:
        height, slope, origin = self.height.take(kept), self.slope.take(kept), self.origin.take(kept)
        return _FlyingRays(height, slope, origin, self.stride.take(kept), self.number.take(kept))

    def leap(self, columns: Integers) -> None:
        """Go on by so many columns (n,), an array that is spent on it."""
        self.height += columns * self.slope
        columns *= self.stride
        self.origin += columns

    def table_places(self, unit: int) -> Integers:
        """Where the table tells of the columns (n,) that the rays come into.

        It has two places for each row of a column, one for rays that stay in it and one for those that go on to the
        next: the rows at both ends of the column, summed, tell which.
        """
        found = self.height + self.slope
        found >>= unit
        found += self.height >> unit
        found += self.origin
        return found

    def next_places(self, unit: int, columns: int) -> Integers:
        """The places (n, columns) of the next columns on the rays' ways, whether they get there or not."""
        ahead = np.arange(columns + 1)
        rows = self.height[:, None] + self.slope[:, None] * ahead
        rows >>= unit
        found = rows[:, 1:] + rows[:, :-1]
        found += self.stride[:, None] * ahead[:-1]
        found += self.origin[:, None]
        return found


@dataclass(frozen=True)
class _RayStarts:
    """Where rays start from. Pairs (2, n) tell of the lines between columns of the mirror, then of those between rows.

    `first` is how far the first line ahead is, along its axis, and `speed` how fast the ray nears it; `origin` and
    `stride` (n,) are those of the rays.
    """

    first: Floats
    speed: Floats
    origin: Integers
    stride: Integers

    def distances(self, places: Integers, above: NDArray[np.bool_]) -> Floats:
        """How far rays (n,) run to the column of a place, or to the row above it. Line j is met at (first + j) / speed.

        A start in its own column has gone over no line, one in the next over line 0.
        """
        away = places - self.origin
        columns = np.floor((away + 0.5) / self.stride)
        rows = away - columns * self.stride
        rows *= 0.5
        np.floor(rows, out=rows)
        columns -= 1.0
        rows += self.first[1]
        columns += self.first[0]
        lines = np.where(above, rows, columns)
        lines /= np.where(above, self.speed[1], self.speed[0])
        return lines


@dataclass(frozen=True, eq=False)
class RayCaster:
    """A map `free` (H, W) made ready for casting.

    `table`: the `clear_cones.clear_leap_lengths` of its mirrors, framed by walls: of four whose columns are the map's,
    then of four whose columns are its rows. `place` (3, 8) tells, for each mirror, where cell (x, y) of the map is in
    the table: place[0] x + place[1] y + place[2]. Heights are in units of 2^-`unit` rows.
    """

    free: Grid
    table: NDArray[np.uint8]
    place: Floats
    unit: int

    @classmethod
    def from_free_cells(cls, free: ArrayLike) -> RayCaster:
        """Prepare the map `free` (H, W), up to 32,765 cells a side, into 32 bytes a cell. Raises RaycastError."""
        grid = np.array(free, dtype=np.bool_)
        if grid.ndim != 2 or grid.size == 0 or max(grid.shape) > MAX_SIDE:
            raise RaycastError("free", f"has shape {grid.shape}, not (H, W) with sides from 1 to {MAX_SIDE}")
        wall = np.pad(~grid, 1, constant_values=True)
        steep = np.stack([wall[::step_y, ::step_x] for step_y in (1, -1) for step_x in (1, -1)])
        shallow = np.ascontiguousarray(steep.swapaxes(1, 2))
        table = np.concatenate([clear_leap_lengths(maps, SECTORS).ravel() for maps in (shallow, steep)])
        return cls(grid, table, _place_table(*wall.shape), BITS - max(wall.shape).bit_length())

    def cast(self, origins: ArrayLike, angles: ArrayLike, max_range: float) -> Floats:
        """Distances (n,) to the first wall from origins (n, 2) = (x, y) at angles (n,) in radians, at most `max_range`.

        Those of `raycast.cast_rays`, to rounding; through the very corner of four cells, rounding may decide which
        neighbour comes first. From inside a wall, or from outside the grid, a ray reads 0. Raises RaycastError.
        """
        _, starts, headings = check_rays(self.free, origins, angles, max_range)
        distances = np.empty(len(headings))
        for first in range(0, len(headings), BLOCK):
            block = slice(first, first + BLOCK)
            directions = np.empty((2, len(headings[block])))
            np.cos(headings[block], out=directions[0])
            np.sin(headings[block], out=directions[1])
            distances[block] = self._wall_distances(starts[block].T, directions)
        return np.minimum(distances, max_range, out=distances)

    def cast_scans(self, poses: ArrayLike, angles: ArrayLike, max_range: float) -> Floats:
        """What a lidar at poses (m, 3), in cells, reads along `angles` (n,) from its heading: (m, n).

        Raises RaycastError.
        """
        frames, beams = np.asarray(poses, dtype=np.float64), np.asarray(angles, dtype=np.float64)
        if frames.ndim != 2 or frames.shape[1] != 3:
            raise RaycastError("poses", f"has shape {frames.shape}, not (m, 3)")
        if beams.ndim != 1 or not np.all(np.isfinite(beams)):
            raise RaycastError("angles", f"of shape {beams.shape} is not an array (n,) of finite numbers")
        _, starts, headings = check_rays(self.free, frames[:, :2], frames[:, 2], max_range)
        # exp(i (heading + beam)) = exp(i heading) exp(i beam): far fewer cosines than rays.
        turns, beam_turns = np.exp(1j * headings), np.exp(1j * beams)
        distances, together = np.empty((len(frames), beams.size)), max(1, BLOCK // max(1, beams.size))
        for first in range(0, len(frames), together):
            block = slice(first, first + together)
            directions = np.outer(turns[block], beam_turns).view(np.float64).reshape(-1, 2).T
            points = np.repeat(starts[block].T, beams.size, axis=1)
            distances[block] = self._wall_distances(points, directions).reshape(distances[block].shape)
        return np.minimum(distances, max_range, out=distances)

    def _wall_distances(self, points: Floats, directions: Floats) -> Floats:
        """How far the walls are (n,) from points (2, n) = (x, y); 0 from a point that is not on a free cell."""
        starts, rays, places = self._launch_rays(points, directions)
        ends = self._leap_until_landed(rays, places)
        # The wall is in the row above when the column could be crossed without going there.
        above = (ends & 1).astype(np.bool_)
        above &= self.table.take(ends & -2) > 0
        distances = starts.distances(ends, above)
        distances[np.flatnonzero(self.table.take(starts.origin) == 0)] = 0.0
        return distances

    def _launch_rays(self, points: Floats, directions: Floats) -> tuple[_RayStarts, _FlyingRays, Integers]:
        """Rays from points (2, n), about to leap from the columns of their starts; and those columns' places."""
        # Fresh memory costs most of all. In one piece, as the C library keeps for the next block no more than twice the
        # largest piece that it was ever given back.
        room = np.empty((17, points.shape[1]))
        cells, ways, (first, speed) = room[:2], room[2:6].reshape(2, 2, -1), room[6:10].reshape(2, 2, -1)
        height, slope, origin, places, ahead, stride, number = whole = room[10:].view(np.int64)
        back = directions < 0.0
        np.subtract(points, np.floor(points, out=cells), out=ways[0])
        ways[0] -= ~back
        ways[1] = directions
        np.abs(ways, out=ways)
        steep = ways[1, 1] > ways[1, 0]
        first[:], speed[:] = np.where(steep, ways[:, ::-1], ways)
        sector = _write_slopes(first, speed, steep, 2**self.unit, ways, whole[:2])
        mirror = (4 * steep.view(np.uint8) + 2 * back[1].view(np.uint8) + back[0].view(np.uint8)).astype(np.int64)
        origin[:] = ahead[:] = self._start_places(cells, mirror, sector)
        stride[:] = np.where(steep, 2 * self.free.shape[1] + 4, 2 * self.free.shape[0] + 4)
        number[:] = np.arange(len(number))
        np.right_shift(height, self.unit, out=places)
        places += origin
        # As if they had come into the columns that they start in.
        height -= slope
        return _RayStarts(first, speed, origin, stride), _FlyingRays(height, slope, ahead, stride, number), places

    def _start_places(self, cells: Floats, mirror: Integers, sector: Floats) -> Floats:
        """The places (n,), whole, of cells (2, n), each in its mirror and sector (n,); both are spent on it."""
        # Off the map, the nearest cell of its frame is as good a wall.
        for along, side in zip(cells, self.free.shape[::-1], strict=True):
            np.clip(along, -1.0, side, out=along)
        place = np.multiply(sector, self.table.size // (8 * SECTORS), out=sector)
        for steps, along in zip(self.place, (*cells, 1.0), strict=True):
            term = steps.take(mirror)
            term *= along
            place += term
        return place

    def _leap_until_landed(self, rays: _FlyingRays, places: Integers) -> Integers:
        """Let rays leap from their first `places` (n,) until all have landed; where they have."""
        ends, longest = places.copy(), max(self.free.shape) + 2
        # What lands where it starts is told by its first place alone: its height at the column's line cannot give it.
        left, share = len(places), 1.0
        while left:
            columns = self.table.take(places)
            left = int(np.count_nonzero(columns))
            few = left * longest <= LAST_PLACES
            if few or left <= share * columns.size:
                flying = columns > 0
                landed, kept = np.flatnonzero(~flying), np.flatnonzero(flying)
                ends[rays.number.take(landed)] = places.take(landed)
                rays, columns = rays.select(kept), columns.take(kept)
            rays.leap(columns.astype(np.int64))
            if few:
                ends[rays.number] = self._places_of_walls(rays.next_places(self.unit, longest))
                break
            places, share = rays.table_places(self.unit), COMPACTION
        return ends

    def _places_of_walls(self, ways: Integers) -> Integers:
        """The places (n,) at which ways (n, columns) meet a wall."""
        where = self.table.take(ways, mode="clip").argmin(axis=1)
        return np.take_along_axis(ways, where[:, None], axis=1)[:, 0]


def _write_slopes(
    first: Floats, speed: Floats, steep: NDArray[np.bool_], units_per_row: int, spare: Floats, found: Integers
) -> Floats:
    """Write to `found` (2, n) how high rays are above their start row when they leave its column, and how much they
    rise in a column, in units of 1 / `units_per_row` row. Return the sector of that slope, in `spare` (2, 2, n).

    Fresh memory costs more than what is computed here: arrays that are done with take the results.
    """
    (_, height), (slope, sector) = spare
    # A ray through a corner enters the neighbour in y first. So, in steep mirrors, a line belongs to the row below it
    # and what is rounded is rounded up, elsewhere down: rounding makes corners of near misses, never near misses of
    # corners, nor does it change the neighbour that comes first.
    np.divide(speed[1], speed[0], out=slope)
    slope *= np.where(steep, -float(units_per_row), float(units_per_row))
    np.floor(slope, out=slope)
    np.multiply(slope, first[0], out=height)
    np.floor(height, out=height)
    np.abs(slope, out=slope)
    np.abs(height, out=height)
    np.subtract(1.0, first[1], out=sector)
    sector *= units_per_row
    climbed, found[1] = found[0], slope
    climbed[:] = height
    climbed -= steep
    climbed += sector.astype(np.int64)
    # From one corner to another, rounding leaves the choice: a column is left by its first row or by the next one.
    np.clip(climbed, 0, 2 * units_per_row - 1, out=climbed)
    np.multiply(slope, SECTORS / units_per_row, out=sector)
    return np.asarray(np.minimum(np.floor(sector, out=sector), SECTORS - 1.0, out=sector))


def _place_table(height: int, width: int) -> Floats:
    """RayCaster's `place`, for a map that takes height x width cells with its frame."""
    found: list[tuple[int, int, int]] = []
    for steep, back_y, back_x in product((False, True), repeat=3):
        by_x, by_y = (2, 2 * width) if steep else (2 * height, 2)
        # Behind its frame, cell x has number x + 1, or width - 2 - x from the other end.
        start = 2 * height * width * SECTORS * len(found)
        start += by_x * (width - 2 if back_x else 1) + by_y * (height - 2 if back_y else 1)
        found.append((-by_x if back_x else by_x, -by_y if back_y else by_y, start))
    return np.array(found, dtype=np.float64).T.copy()
