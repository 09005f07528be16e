"""The line that a cloud follows at each of its points, as a unit normal (2,); (0, 0) where it follows none.

Points with a null normal tell nothing of a point-to-line registration: their gaps are 0 by definition.

Source: Pomerleau, Colas, Siegwart, "A Review of Point Cloud Registration Algorithms for Mobile Robotics" (2015),
section 3.2, for normals by principal components.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from reference.registration.rigid import InvalidCloudError

Floats = NDArray[np.float64]

NEIGHBOURS = 7
MAX_ROUNDNESS = 0.5


def normals_by_neighbours(
    points: ArrayLike,
    neighbours: int = NEIGHBOURS,
    *,
    max_roundness: float = MAX_ROUNDNESS,
    max_thickness: float = np.inf,
) -> Floats:
    """Unit normals (n, 2) of points (n, 2) in any order: across the main axis of each one and its nearest neighbours.

    Where the spread across exceeds `max_roundness` times the spread along, or `max_thickness` in the unit of the
    points, there is no line: far neighbours may be of two walls. Signs are arbitrary. Raises InvalidCloudError for
    fewer than 3 points or neighbours.
    """
    cloud = check_plane_cloud("points", points)
    if min(neighbours, len(cloud)) < 3:
        raise InvalidCloudError("points" if neighbours >= 3 else "neighbours", "a line is drawn through 3 or more")
    _, near = cKDTree(cloud).query(cloud, k=min(neighbours, len(cloud)))
    around = cloud[near] - cloud[near].mean(axis=1, keepdims=True)
    xx, yy = np.moveaxis((around**2).mean(axis=1), -1, 0)
    xy = (around[:, :, 0] * around[:, :, 1]).mean(axis=1)
    half_trace, half_gap = (xx + yy) / 2.0, np.hypot((xx - yy) / 2.0, xy)
    along = np.arctan2(xy, (xx - yy) / 2.0) / 2.0
    across = half_trace - half_gap
    straight = (across <= max_roundness**2 * (half_trace + half_gap)) & (across <= max_thickness**2)
    normals = np.stack([-np.sin(along), np.cos(along)], axis=1)
    return np.where((straight & (half_gap > 0.0))[:, None], normals, 0.0)


def normals_by_beams(points: ArrayLike, max_gap: float) -> Floats:
    """Unit normals (n, 2) of points (n, 2) in the order of a scan's beams, turned towards the sensor at the origin.

    Across the chord from the beam before to the beam after; a neighbour farther than `max_gap` belongs to another
    surface and is replaced by the point itself. The first beam follows the last one.
    """
    cloud = check_plane_cloud("points", points)
    if not max_gap > 0.0:
        raise InvalidCloudError("max_gap", f"{max_gap} is not a positive length")
    before, after = np.roll(cloud, 1, axis=0), np.roll(cloud, -1, axis=0)
    for neighbour in (before, after):
        torn = np.linalg.norm(neighbour - cloud, axis=1) > max_gap
        neighbour[torn] = cloud[torn]
    chord = after - before
    length = np.linalg.norm(chord, axis=1)
    across = np.stack([-chord[:, 1], chord[:, 0]], axis=1) / np.where(length > 0.0, length, 1.0)[:, None]
    facing = np.where(np.einsum("ij,ij->i", across, cloud) > 0.0, -1.0, 1.0)
    return np.asarray(across * facing[:, None])


def check_plane_cloud(name: str, points: ArrayLike) -> Floats:
    """A cloud (n, 2), n >= 1, of finite coordinates; InvalidCloudError otherwise."""
    cloud = np.ascontiguousarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[0] == 0 or cloud.shape[1] != 2:
        raise InvalidCloudError(name, f"expected one or more points (x, y) as rows, got shape {cloud.shape}")
    if not np.all(np.isfinite(cloud)):
        raise InvalidCloudError(name, "a coordinate is not finite")
    return cloud
