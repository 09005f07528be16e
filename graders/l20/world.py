"""The worlds that the graders of module L20 launch programs in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.program import KitSettings

MODULE = "l20"
RANGE = 12.0

Grid = NDArray[np.bool_]


def kit(rng: np.random.Generator, libres: Grid | None = None, *, portee_max: float = RANGE) -> KitSettings:
    """Settings of one execution: the module's own map unless `libres` (H, W) is given, and a seed drawn from `rng`."""
    seed = int(rng.integers(2**62))
    return KitSettings(MODULE, {"libres": libres, "portee_max": portee_max, "seed": seed})


def random_map(rng: np.random.Generator, height: int = 12, width: int = 16, *, fill: float = 0.18) -> Grid:
    """A bool grid (height, width), True where free: a walled room with random obstacles, in one connected piece."""
    free = np.zeros((height, width), dtype=bool)
    free[1:-1, 1:-1] = rng.random((height - 2, width - 2)) > fill
    return _largest_region(free)


def _largest_region(free: Grid) -> Grid:
    from scipy import ndimage

    labels, count = ndimage.label(free)
    if count == 0:
        raise ValueError("the map has no free cell")
    sizes = np.bincount(labels.ravel())[1:]
    return np.asarray(labels == 1 + int(np.argmax(sizes)))


def free_cells(libres: Grid) -> NDArray[np.int64]:
    """The free cells as rows (y, x), shape (n, 2)."""
    return np.argwhere(libres)


#: The module's own map, and always the same random numbers: where mistakes are recognised by hand-made inputs.
STILL = KitSettings(MODULE, {"libres": None, "portee_max": RANGE, "seed": 0})
