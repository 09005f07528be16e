"""Poses of the plane: the group SE(2).

A pose is an array (3,): x, y in metres (or cells), theta in radians. `T_a_b`, the pose of frame b in frame a, maps
coordinates in b to coordinates in a; so `T_a_c = compose(T_a_b, T_b_c)`, frames reading from left to right.

Source: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010), section II.
"""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

Pose = NDArray[np.float64]


@overload
def wrap_angle(angle: float) -> float: ...
@overload
def wrap_angle(angle: NDArray[np.float64]) -> NDArray[np.float64]: ...
def wrap_angle(angle: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
    """Bring an angle in radians back to ]-pi, pi], elementwise: pi stays pi, -pi becomes pi."""
    return np.pi - np.mod(np.pi - angle, 2.0 * np.pi)


def rotation(theta: float) -> NDArray[np.float64]:
    """The 2 x 2 matrix of the rotation by theta radians."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s], [s, c]])


def compose(T_a_b: ArrayLike, T_b_c: ArrayLike) -> Pose:
    """The pose of c in a, from the pose of b in a and the pose of c in b.

    (x1, y1, t1) + (x2, y2, t2) = (x1 + x2 cos t1 - y2 sin t1, y1 + x2 sin t1 + y2 cos t1, t1 + t2)      (1)
    """
    x1, y1, t1 = np.asarray(T_a_b, dtype=np.float64)
    x2, y2, t2 = np.asarray(T_b_c, dtype=np.float64)
    c, s = np.cos(t1), np.sin(t1)
    return np.array([x1 + c * x2 - s * y2, y1 + s * x2 + c * y2, wrap_angle(t1 + t2)])


def inverse(T_a_b: ArrayLike) -> Pose:
    """The pose of a in b: compose(T_a_b, inverse(T_a_b)) is the identity.

    (x, y, t)^-1 = (-x cos t - y sin t, x sin t - y cos t, -t)                                             (2)
    """
    x, y, t = np.asarray(T_a_b, dtype=np.float64)
    c, s = np.cos(t), np.sin(t)
    return np.array([-c * x - s * y, s * x - c * y, wrap_angle(-t)])


def relative(T_a_b: ArrayLike, T_a_c: ArrayLike) -> Pose:
    """The pose of c in b, both being given in a: compose(inverse(T_a_b), T_a_c), by (1) and (2)."""
    return compose(inverse(T_a_b), T_a_c)
