"""Distance maps: how far each cell is from the nearest cell of a set, exactly.

Lengths are in cells, between centres of cells, which is also how far cells must be shifted to coincide.

Source: Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions" (2012), for the problem; the transform
itself is SciPy's, which is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_cdt, distance_transform_edt

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Grid = NDArray[np.bool_]


class DistanceMapError(InvalidArgumentError):
    """Something to which no distance is defined; `argument` names it."""


def distances_to_cells(cells: ArrayLike) -> Floats:
    """Euclidean distances (H, W) from each cell's centre to that of the nearest true one of `cells` (H, W).

    Zero on the cells themselves; infinite everywhere when there is none. Raises DistanceMapError.
    """
    grid = _check_cells(cells)
    if not grid.any():
        return np.full(grid.shape, np.inf)
    return np.asarray(distance_transform_edt(~grid), dtype=np.float64)


def chessboard_distances_to_cells(cells: ArrayLike) -> NDArray[np.int64]:
    """How many moves a chess king needs (H, W) from each cell to the nearest true one of `cells` (H, W).

    A square of side 2 d - 1 around a cell at distance d >= 1 holds none of them. Raises DistanceMapError, also when
    there is no such cell.
    """
    grid = _check_cells(cells)
    if not grid.any():
        raise DistanceMapError("cells", "are all false: a chess king never arrives")
    return np.asarray(distance_transform_cdt(~grid, metric="chessboard"), dtype=np.int64)


def _check_cells(cells: ArrayLike) -> Grid:
    grid = np.asarray(cells, dtype=np.bool_)
    if grid.ndim != 2 or grid.size == 0:
        raise DistanceMapError("cells", f"has shape {grid.shape}, not (H, W)")
    return grid
