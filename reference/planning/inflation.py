"""Keeping away from walls: cells too near for the robot are closed, those near cost more.

Source: the inflation layer of ROS's costmap_2d: an exponential fall beyond the inscribed radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.planning.grid_search import PlanningError
from reference.world.distance_map import distances_to_cells

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class InflatedGrid:
    """The cells `free` (H, W) for the centre of the robot, and the `costs` (H, W) of their nearness to walls."""

    free: NDArray[np.bool_]
    costs: Floats


def inflate(free: ArrayLike, radius: float, *, weight: float = 10.0, fall: float = 0.5) -> InflatedGrid:
    """For a round robot of `radius`, in cells: costs are weight exp(-fall (d - radius)) at d from the nearest wall.

    Closed where d <= radius; distances in cells, between centres of cells. Raises PlanningError.
    """
    grid = np.asarray(free, dtype=np.bool_)
    for name, value in (("radius", radius), ("weight", weight), ("fall", fall)):
        if not 0.0 <= value < np.inf:
            raise PlanningError(name, f"{value} is not a number from 0 on")
    if grid.ndim != 2 or grid.size == 0:
        raise PlanningError("free", f"has shape {grid.shape}, not (H, W)")
    distance = distances_to_cells(~np.pad(grid, 1))[1:-1, 1:-1]
    open_cells = grid & (distance > radius)
    return InflatedGrid(open_cells, np.where(open_cells, weight * np.exp(-fall * (distance - radius)), 0.0))
