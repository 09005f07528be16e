"""Grid maps: which cells are free, which are walls, and where the grid lies in the world.

Cell (row, column) = (y, x) covers [x, x + 1[ x [y, y + 1[ in the frame of the map, in cells: x along columns, y along
rows. `T_world_map` = (x, y, theta), in metres and radians, is the pose of that frame in the world: of the corner of
cell (0, 0). A cell that is neither free nor occupied is unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.se2 import rotation_matrix, wrap_angle
from reference.text import decode_lines
from reference.world.distance_map import distances_to_cells
from reference.world.ray_caster import RayCaster

Floats = NDArray[np.float64]
Grid = NDArray[np.bool_]

FREE, OCCUPIED, UNKNOWN = ".#?"


class GridMapError(InvalidArgumentError):
    """Something that is no map, or that a map cannot place; `argument` names it."""


@dataclass(frozen=True, eq=False)
class GridMap:
    """`free` and `occupied` (H, W), never both true; `resolution` in metres a cell; `T_world_map` (3,).

    The arrays are copied and cannot be written to. Raises GridMapError.
    """

    free: Grid
    occupied: Grid
    resolution: float
    T_world_map: Floats

    def __post_init__(self) -> None:
        free, occupied = np.array(self.free, dtype=np.bool_), np.array(self.occupied, dtype=np.bool_)
        corner = np.array(self.T_world_map, dtype=np.float64)
        if free.ndim != 2 or free.size == 0:
            raise GridMapError("free", f"has shape {free.shape}, not (H, W)")
        if occupied.shape != free.shape:
            raise GridMapError("occupied", f"has shape {occupied.shape}, not {free.shape}")
        if np.any(free & occupied):
            raise GridMapError("occupied", "holds a cell that is free too")
        if not 0.0 < self.resolution < np.inf:
            raise GridMapError("resolution", f"{self.resolution} is not a positive length")
        if corner.shape != (3,) or not np.all(np.isfinite(corner)):
            raise GridMapError("T_world_map", "is not a pose (3,) of finite numbers")
        for name, values in (("free", free), ("occupied", occupied), ("T_world_map", corner)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @classmethod
    def from_free(cls, free: ArrayLike, resolution: float = 1.0, T_world_map: ArrayLike = (0.0, 0.0, 0.0)) -> GridMap:
        """The map without unknown cells whose free cells are given, (H, W): all others are walls."""
        grid = np.asarray(free, dtype=np.bool_)
        return cls(grid, ~grid, resolution, np.asarray(T_world_map, dtype=np.float64))

    @classmethod
    def from_text(cls, text: str | bytes, resolution: float = 1.0, T_world_map: ArrayLike = (0.0, 0.0, 0.0)) -> GridMap:
        """The map drawn with . (free), # (occupied) and ? (unknown), one line a row, row 0 first. Raises GridMapError.

        Blank lines and spaces around lines do not count. As row 0 comes first, y points down the page.
        """
        rows = [line.strip() for line in decode_lines(text, error=GridMapError) if line.strip()]
        if not rows or len({len(row) for row in rows}) > 1 or not set("".join(rows)) <= {FREE, OCCUPIED, UNKNOWN}:
            raise GridMapError("text", f"is not lines of one length made of {FREE}, {OCCUPIED} and {UNKNOWN}")
        cells = np.array([list(row) for row in rows])
        return cls(cells == FREE, cells == OCCUPIED, resolution, np.asarray(T_world_map, dtype=np.float64))

    def to_text(self) -> str:
        """The drawing that `from_text` reads."""
        cells = np.where(self.free, FREE, np.where(self.occupied, OCCUPIED, UNKNOWN))
        return "".join("".join(row) + "\n" for row in cells.tolist())

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W): rows, columns."""
        return self.free.shape[0], self.free.shape[1]

    @property
    def unknown_cells(self) -> Grid:
        """The cells (H, W) of which nothing is known."""
        return ~(self.free | self.occupied)

    def to_cells(self, points_world: ArrayLike) -> Floats:
        """Points (…, 2) of the world, in metres, as (x, y) in cells in the frame of the map."""
        points = _check_points("points_world", points_world)
        return np.asarray((points - self.T_world_map[:2]) @ rotation_matrix(self.T_world_map[2]) / self.resolution)

    def to_world(self, points_cells: ArrayLike) -> Floats:
        """Points (…, 2) = (x, y) in cells in the frame of the map, as points of the world in metres."""
        points = _check_points("points_cells", points_cells)
        return np.asarray(points * self.resolution @ rotation_matrix(self.T_world_map[2]).T + self.T_world_map[:2])

    def poses_to_cells(self, poses_world: ArrayLike) -> Floats:
        """Poses (…, 3) of the world as poses in cells in the frame of the map."""
        poses = _check_poses("poses_world", poses_world)
        return np.concatenate(
            [self.to_cells(poses[..., :2]), wrap_angle(poses[..., 2:] - self.T_world_map[2])], axis=-1
        )

    def poses_to_world(self, poses_cells: ArrayLike) -> Floats:
        """Poses (…, 3) in cells in the frame of the map as poses of the world."""
        poses = _check_poses("poses_cells", poses_cells)
        return np.concatenate(
            [self.to_world(poses[..., :2]), wrap_angle(poses[..., 2:] + self.T_world_map[2])], axis=-1
        )

    def contains(self, points_world: ArrayLike) -> Grid:
        """Which points (…, 2) of the world lie on the grid, (…)."""
        cells = self.to_cells(points_world)
        height, width = self.shape
        return (cells[..., 0] >= 0) & (cells[..., 0] < width) & (cells[..., 1] >= 0) & (cells[..., 1] < height)

    def is_free(self, points_world: ArrayLike) -> Grid:
        """Which points (…, 2) of the world lie on a free cell, (…); off the grid none does."""
        inside = self.contains(points_world)
        cells = np.floor(np.where(inside[..., None], self.to_cells(points_world), 0.0)).astype(np.int64)
        return np.asarray(inside & self.free[cells[..., 1], cells[..., 0]])

    @cached_property
    def distances_to_wall(self) -> Floats:
        """Metres (H, W) from the centre of each cell to the centre of the nearest occupied one; inf without any."""
        return distances_to_cells(self.occupied) * self.resolution

    @cached_property
    def ray_caster(self) -> RayCaster:
        """The map made ready for casting rays, in cells; they stop at whatever is not free."""
        return RayCaster.from_free_cells(self.free)

    def cast_scans(self, poses_world: ArrayLike, angles: ArrayLike, max_range: float) -> Floats:
        """What a perfect lidar at poses (m, 3) of the world reads along `angles` (n,) from its heading, (m, n)."""
        cells = self.ray_caster.cast_scans(self.poses_to_cells(poses_world), angles, max_range / self.resolution)
        return np.minimum(cells * self.resolution, max_range)


def _check_points(argument: str, points: ArrayLike) -> Floats:
    return _check_rows(argument, points, 2)


def _check_poses(argument: str, poses: ArrayLike) -> Floats:
    return _check_rows(argument, poses, 3)


def _check_rows(argument: str, rows: ArrayLike, columns: int) -> Floats:
    values = np.asarray(rows, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] != columns or not np.all(np.isfinite(values)):
        raise GridMapError(argument, f"of shape {values.shape} is not an array (…, {columns}) of finite numbers")
    return values
