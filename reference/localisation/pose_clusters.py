"""Clouds of poses: where the particles are gathered, when that may be at several places at once.

In a symmetrical corridor the mean of all particles lies where the robot is not; the mean of the heaviest cloud is a
place where it may be. Poses are put in bins; bins that touch, corners included, make a cloud, headings going round.

Source: the clustering of the particles of AMCL in ROS, after Thrun, Burgard, Fox, "Probabilistic Robotics" (2005),
section 8.3.6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reference.errors import InvalidArgumentError
from reference.filters.moments import weighted_covariance, weighted_mean

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_ANGLES = np.array([False, False, True])


@dataclass(frozen=True, eq=False)
class Cluster:
    """A cloud: its share of the `weight`, the `mean` (3,) and `covariance` (3, 3) of its poses, and which they are."""

    weight: float
    mean: Floats
    covariance: Floats
    members: Integers


def find_clusters(poses: ArrayLike, weights: ArrayLike, cell: float = 0.5, sectors: int = 12) -> list[Cluster]:
    """The clouds of poses (n, 3) with weights (n,), heaviest first; bins of `cell` metres and 2 pi / `sectors`.

    Raises InvalidArgumentError.
    """
    values, w = np.asarray(poses, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != 3 or len(values) == 0 or not np.all(np.isfinite(values)):
        raise InvalidArgumentError("poses", f"of shape {values.shape} is not an array (n, 3) of finite numbers")
    if w.shape != (len(values),) or not w.min() >= 0.0 or not 0.0 < w.sum() < np.inf:
        raise InvalidArgumentError("weights", f"of shape {w.shape} are no weights of {len(values)} poses")
    if not 0.0 < cell < np.inf:
        raise InvalidArgumentError("cell", f"{cell} is not a positive length")
    if sectors < 1:
        raise InvalidArgumentError("sectors", f"{sectors} make no circle")
    labels = _label_poses(values, cell, sectors)
    return sorted(
        (_make_cluster(values, w / w.sum(), np.flatnonzero(labels == label)) for label in range(labels.max() + 1)),
        key=lambda cluster: -cluster.weight,
    )


def _label_poses(poses: Floats, cell: float, sectors: int) -> Integers:
    """The number (n,) of each pose's cloud."""
    places = np.floor(poses[:, :2] / cell)
    headings = np.floor(np.mod(poses[:, 2] / (2.0 * np.pi), 1.0) * sectors) % sectors
    bins, bin_of_pose = np.unique(np.column_stack([places, headings]), axis=0, return_inverse=True)
    # Only the third axis goes round; a side of 0 is an axis that does not.
    touching = cKDTree(bins, boxsize=np.array([0.0, 0.0, float(sectors)])).query_pairs(
        1.0, p=np.inf, output_type="ndarray"
    )
    links = coo_array((np.ones(len(touching)), (touching[:, 0], touching[:, 1])), shape=(len(bins), len(bins)))
    _, cloud_of_bin = connected_components(links, directed=False)
    return np.asarray(cloud_of_bin[bin_of_pose.ravel()], dtype=np.int64)


def _make_cluster(poses: Floats, weights: Floats, members: Integers) -> Cluster:
    weight = float(weights[members].sum())
    own = weights[members] / weight if weight > 0.0 else np.full(members.size, 1.0 / members.size)
    mean = weighted_mean(poses[members], own, _ANGLES)
    return Cluster(weight, mean, weighted_covariance(poses[members], own, mean, _ANGLES), members)
