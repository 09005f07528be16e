"""Differences, means and covariances of vectors some of whose components are angles.

`angles` (d,) tells which components are: those are compared around the circle, so that 179 and -179 degrees are two
degrees apart.

Source for the circular mean: Mardia and Jupp, "Directional Statistics" (2000), section 2.2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


def wrap_angles(vectors: Floats, angles: Flags) -> Floats:
    """The vectors (…, d), their angles back in ]-pi, pi]."""
    result = np.array(vectors)
    if angles.any():
        result[..., angles] = wrap_angle(result[..., angles])
    return result


def subtract_vectors(left: Floats, right: Floats, angles: Flags) -> Floats:
    """left - right, (…, d), angles the short way round."""
    return wrap_angles(left - right, angles)


def weighted_mean(vectors: Floats, weights: Floats, angles: Flags) -> Floats:
    """The mean (d,) of vectors (n, d) with weights (n,) of sum 1; of angles, the direction of the mean unit vector."""
    mean = np.asarray(weights @ vectors)
    if angles.any():
        turning = vectors[:, angles]
        mean[angles] = np.arctan2(weights @ np.sin(turning), weights @ np.cos(turning))
    return mean


def weighted_covariance(vectors: Floats, weights: Floats, mean: Floats, angles: Flags) -> Floats:
    """The covariance (d, d) of vectors (n, d) with weights (n,) about `mean` (d,)."""
    away = subtract_vectors(vectors, mean, angles)
    return np.asarray(away.T @ (weights[:, None] * away))
