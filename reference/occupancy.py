"""Occupancy grids: what each cell has been seen to be, as log-odds that scans add to.

With l = log(p / (1 - p)) and measurements independent given the cell, Bayes is a sum (Theorem 2 of the course):

    l_t = l_(t-1) + log(p(occ | z) / (1 - p(occ | z))) - l_0                                               (1)

The inverse sensor model gives the added term: one constant for a cell that a beam crosses, another for the cell that
stops it. Log-odds are clipped, so that a map can still change its mind. Cells as in `grid_map`.

Sources: Moravec and Elfes, "High resolution maps from wide angle sonar" (1985); Thrun, Burgard, Fox, "Probabilistic
Robotics" (2005), table 9.1; Hornung et al., "OctoMap" (2013), for clipping and for one vote a scan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.se2 import rotation_matrix, transform
from reference.world.grid_map import GridMap
from reference.world.ray_cells import crossed_cells
from reference.world.scan import Scan

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

P_HIT = 0.7
CLAMP = 5.0
BEYOND = 1e-6
CHANCE = 0.5
MOST_CELLS = 50_000_000
#: A pose so many times as far from the middle as half of what was seen is one gone astray.
ASTRAY = 20.0


class OccupancyError(InvalidArgumentError):
    """Something from which no map is made; `argument` names it."""


def log_odds(p: ArrayLike) -> Floats:
    """log(p / (1 - p)), elementwise, for probabilities in ]0, 1[. Raises OccupancyError."""
    values = np.asarray(p, dtype=np.float64)
    if not np.all((values > 0.0) & (values < 1.0)):
        raise OccupancyError("p", "holds a number outside ]0, 1[")
    return np.asarray(np.log(values) - np.log1p(-values))


def probability_of_log_odds(l: ArrayLike) -> Floats:  # noqa: E741 the letter of the formula
    """1 / (1 + exp(-l)), elementwise, without overflow."""
    values = np.asarray(l, dtype=np.float64)
    small = np.exp(-np.abs(values))
    return np.asarray(np.where(values >= 0.0, 1.0, small) / (1.0 + small))


@dataclass(frozen=True)
class InverseSensorModel:
    """What a beam adds to the log-odds (1) of the cell that stops it, and of those it crosses; the bound +-`clamp`.

    With `once_a_scan`, beams of one scan that meet in a cell have one vote together, and stopping wins over crossing;
    otherwise each has its own.
    """

    hit: float = float(np.log(P_HIT / (1.0 - P_HIT)))
    miss: float = -float(np.log(P_HIT / (1.0 - P_HIT)))
    clamp: float = CLAMP
    once_a_scan: bool = False

    def __post_init__(self) -> None:
        if not (np.isfinite(self.hit) and self.hit >= 0.0):
            raise OccupancyError("hit", f"{self.hit} does not speak for an obstacle")
        if not (np.isfinite(self.miss) and self.miss <= 0.0):
            raise OccupancyError("miss", f"{self.miss} does not speak for a free cell")
        if not self.clamp > 0.0:
            raise OccupancyError("clamp", f"{self.clamp} is not a positive bound")


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """`log_odds` (H, W), written to as scans come in; `resolution` in metres a cell; `T_world_map` (3,), as GridMap."""

    log_odds: Floats
    resolution: float = 1.0
    T_world_map: Floats = field(default_factory=lambda: np.zeros(3))
    model: InverseSensorModel = InverseSensorModel()

    def __post_init__(self) -> None:
        cells, corner = np.array(self.log_odds, dtype=np.float64), np.array(self.T_world_map, dtype=np.float64)
        if cells.ndim != 2 or cells.size == 0 or not np.all(np.isfinite(cells)):
            raise OccupancyError("log_odds", f"of shape {cells.shape} is not an array (H, W) of finite numbers")
        if not 0.0 < self.resolution < np.inf:
            raise OccupancyError("resolution", f"{self.resolution} is not a positive length")
        if corner.shape != (3,) or not np.all(np.isfinite(corner)):
            raise OccupancyError("T_world_map", "is not a pose (3,) of finite numbers")
        object.__setattr__(self, "log_odds", np.ascontiguousarray(cells))
        object.__setattr__(self, "T_world_map", corner)

    @property
    def probabilities(self) -> Floats:
        """How likely each cell (H, W) is to be occupied."""
        return probability_of_log_odds(self.log_odds)

    def integrate(self, scan: Scan, T_world_robot: ArrayLike) -> None:
        """Add a scan taken at a pose (3,) of the world. Raises OccupancyError.

        What lies off the grid is left out; a beam that was not measured adds nothing, and no reading marks the cell in
        which the lidar stands: that one is free.
        """
        pose = np.asarray(T_world_robot, dtype=np.float64)
        if pose.shape != (3,) or not np.all(np.isfinite(pose)):
            raise OccupancyError("T_world_robot", "is not a pose (3,) of finite numbers")
        if not len(scan):
            raise OccupancyError("scan", "has no beam")
        crossed, stopped = self._crossed_and_hit_cells(scan.only_measured(), pose)
        if self.model.once_a_scan:
            stopped = np.unique(stopped)
            crossed = np.setdiff1d(crossed, stopped)
        flat = self.log_odds.reshape(-1)
        np.add.at(flat, crossed, self.model.miss)
        np.add.at(flat, stopped, self.model.hit)
        for touched in (crossed, stopped):
            flat[touched] = np.clip(flat[touched], -self.model.clamp, self.model.clamp)

    def _crossed_and_hit_cells(self, scan: Scan, pose: Floats) -> tuple[Indices, Indices]:
        """The cells that beams cross, and those that stop one: as indices of the flat grid, once for each beam.

        A beam stops in the cell just behind the distance that it reads.
        """
        angle = float(self.T_world_map[2])
        origin = (pose[:2] - self.T_world_map[:2]) @ rotation_matrix(angle) / self.resolution
        headings = scan.angles + (pose[2] - angle)
        lengths = scan.ranges / self.resolution + np.where(scan.hit_mask, BEYOND, 0.0)
        ends = origin + lengths[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
        cells = crossed_cells(np.broadcast_to(origin, ends.shape), ends)
        last = np.floor(ends).astype(np.int64)
        stops = scan.hit_mask & np.any(last != np.floor(origin).astype(np.int64), axis=1)
        at_end = (cells.x == last[cells.segment, 0]) & (cells.y == last[cells.segment, 1])
        crossing = ~(at_end & stops[cells.segment])
        return self._flat_indices(cells.x[crossing], cells.y[crossing]), self._flat_indices(*last[stops].T)

    def _flat_indices(self, x: Indices, y: Indices) -> Indices:
        """The indices of the cells (x, y) that are on the grid."""
        height, width = self.log_odds.shape
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        return np.asarray(y[inside] * width + x[inside])

    def to_grid_map(self, threshold: float = CHANCE) -> GridMap:
        """Free where occupancy is likelier than not to be absent, occupied above `threshold`, else unknown.

        Free: p < 1 - threshold; occupied: p > threshold; a threshold in [0.5, 1[. Raises OccupancyError.
        """
        if not CHANCE <= threshold < 1.0:
            raise OccupancyError("threshold", f"{threshold} is not in [0.5, 1[")
        p = self.probabilities
        return GridMap(p < 1.0 - threshold, p > threshold, self.resolution, self.T_world_map)


def build_map(
    scans: Sequence[Scan],
    poses: ArrayLike,
    resolution: float,
    *,
    model: InverseSensorModel | None = None,
    margin: float = 1.0,
) -> OccupancyGrid:
    """The map of `scans` taken at `poses` (n, 3) of the world; just large enough for their points, with a margin.

    `resolution` in metres a cell, `margin` in metres. Raises OccupancyError, also for a map of more than 50 million
    cells, which would fill the memory: `argument` is "poses" where one has gone astray, "resolution" otherwise.
    """
    frames = np.asarray(poses, dtype=np.float64)
    if frames.shape != (len(scans), 3) or not np.all(np.isfinite(frames)):
        raise OccupancyError("poses", f"of shape {frames.shape} are not finite poses ({len(scans)}, 3)")
    if not len(scans):
        raise OccupancyError("scans", "are none")
    for name, length, least in (("resolution", resolution, resolution > 0.0), ("margin", margin, margin >= 0.0)):
        if not (least and length < np.inf):
            raise OccupancyError(name, f"{length} m is not a length")
    seen = [frames[:, :2], *(transform(pose, scan.points()) for pose, scan in zip(frames, scans, strict=True))]
    points = np.concatenate(seen)
    _check_map_size(points, frames, resolution, margin)
    low = np.floor((points.min(axis=0) - margin) / resolution)
    extent = np.ceil((points.max(axis=0) + margin) / resolution) - low + 1
    width, height = extent.astype(np.int64)
    corner = np.append(low * resolution, 0.0)
    grid = OccupancyGrid(np.zeros((height, width)), resolution, corner, model or InverseSensorModel())
    for pose, scan in zip(frames, scans, strict=True):
        grid.integrate(scan, pose)
    return grid


def _check_map_size(points: Floats, frames: Floats, resolution: float, margin: float) -> None:
    """Raise OccupancyError for a map of too many cells: of the pose that has gone astray, else of the resolution."""
    sides = np.ptp(points, axis=0) + 2.0 * margin
    with np.errstate(over="ignore"):
        cells = float(np.prod(sides / resolution))
    if cells <= MOST_CELLS:
        return
    asked = f"{' by '.join(f'{side:.4g} m' for side in sides)}, {cells:.2g} cells of {resolution:.4g} m"
    away = np.hypot(*(frames[:, :2] - np.median(frames[:, :2], axis=0)).T)
    reach = np.median(np.hypot(*(points - np.median(points, axis=0)).T))
    if float(away.max()) > ASTRAY * float(reach):
        raise OccupancyError("poses", f"ask for a map of {asked}: see pose {int(np.argmax(away))}")
    least = float(np.sqrt(sides[0]) * np.sqrt(sides[1] / MOST_CELLS))
    raise OccupancyError("resolution", f"asks for a map of {asked}: take {least:.2g} m or more")
