"""The likelihood field: how far from a wall each beam would end, looked up in a table; no ray is cast.

    p(z_k | pose) = hit N(d; 0, sigma^2) + random / max_range                                                  (1)

d is the distance from the cell in which the beam ends to the nearest occupied one, between centres. Beams that read
`max_range`, or that were not measured, say nothing. Walls are transparent to this model: it sees where beams end, not
what they cross.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), table 6.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.se2 import rotation_matrix
from reference.sensors.rays import check_poses, check_power
from reference.world.grid_map import GridMap
from reference.world.scan import Scan

Floats = NDArray[np.float64]


class LikelihoodField:
    """A ScanLikelihood: `hit` + `random` = 1 at most, `sigma` and `max_range` in metres, `power` tempers the product.

    Beams that end off the map have the likelihood of noise. Raises InvalidArgumentError.
    """

    def __init__(
        self,
        grid_map: GridMap,
        *,
        sigma: float = 0.2,
        hit: float = 0.9,
        random: float = 0.1,
        max_range: float = 10.0,
        power: float = 1.0,
    ) -> None:
        for argument, value in (("sigma", sigma), ("max_range", max_range)):
            if not 0.0 < value < np.inf:
                raise InvalidArgumentError(argument, f"{value} is not a positive length")
        if not (hit >= 0.0 and random > 0.0 and hit + random <= 1.0 + 1e-9):
            raise InvalidArgumentError("hit, random", "are not shares, the second one positive, of at most one")
        self.grid_map = grid_map
        noise = random / max_range
        density = np.exp(-0.5 * (grid_map.distances_to_wall / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
        self.log_field = check_power(power) * np.log(hit * density + noise)
        self.log_field.flags.writeable = False
        # One cell of noise all around, and more behind each row, which also comes before the next one: what ends as far
        # off the map as that needs no clipping. It is as wide as the map, or else as far as twice what a beam reaches.
        width = grid_map.shape[1]
        self._behind = 1 + int(min(2.0 * max_range / grid_map.resolution, width))
        self._table = np.pad(self.log_field, ((1, 1), (1, self._behind)), constant_values=power * np.log(noise))
        # Whole numbers of half the size, where they hold every place, even off the table by its width.
        self._place = np.int32 if self._table.size + self._table.shape[1] ** 2 < 2**31 else np.int64
        self._to_table = rotation_matrix(-grid_map.T_world_map[2]) / grid_map.resolution
        self._corner = 1.0 - self._to_table @ grid_map.T_world_map[:2]

    def log_likelihood(self, poses_world: Floats, scan: Scan) -> Floats:
        """The sum over the beams that hit something of log (1), times the power, (n,). Raises InvalidArgumentError.

        Lengths are in cells of the table, whose corner is one cell before that of the map. The ends of the k beams from
        the n poses are two products of matrices, (k, 3) by (3, n).
        """
        poses = check_poses(poses_world, scan)
        points = scan.points()
        starts = self._to_table @ poses[:, :2].T + self._corner[:, None]
        headings = poses[:, 2] - self.grid_map.T_world_map[2]
        (x, y), c, s, ends = starts, np.cos(headings), np.sin(headings), np.ones((len(points), 3))
        np.divide(points, self.grid_map.resolution, out=ends[:, :2])
        columns = ends @ np.array([c, -s, x])
        rows = ends @ np.array([s, c, y])
        if not self._has_wide_enough_margin(starts, scan.max_range / self.grid_map.resolution):
            # Whatever lies off the map falls on the one cell of noise around it.
            np.clip(columns, 0.0, self.grid_map.shape[1] + 1.0, out=columns)
            np.clip(rows, 0.0, self.grid_map.shape[0] + 1.0, out=rows)
        cells = rows.astype(self._place)
        cells *= self._table.shape[1]
        cells += columns.astype(self._place)
        # Before the first row and after the last one all is noise, as their ends are.
        return np.asarray(self._table.ravel().take(cells, mode="clip").sum(axis=0))

    def _has_wide_enough_margin(self, starts: Floats, reach: float) -> bool:
        """Is the noise around the map wide enough for beams of that reach from points (2, n) = (x, y) of the table?"""
        (right, top), (height, width) = starts.max(axis=1, initial=0.0).tolist(), self.grid_map.shape
        room = self._behind - reach
        return bool(starts.min(initial=0.0) >= -room) and right <= width + room and top <= height + room
