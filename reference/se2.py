"""Poses of the plane: the group SE(2), its exponential, its Jacobians, and the covariances that they carry.

A pose is an array (3,): x, y in metres (or cells), theta in radians. `T_a_b`, the pose of frame b in frame a, maps
coordinates in b to coordinates in a; so `T_a_c = compose(T_a_b, T_b_c)`, frames reading from left to right. Functions
of poses also take arrays (…, 3) of them, whose shapes broadcast. A covariance (3, 3) is that of the coordinates
(x, y, theta). A twist (vx, vy, omega) is a constant velocity in the moving frame, for one unit of time.

Sources: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010), section II; Smith, Self,
Cheeseman, "Estimating Uncertain Spatial Relationships in Robotics" (1990), for the Jacobians and the covariances; Solà,
Deray, Atchuthan, "A micro Lie theory for state estimation in robotics" (2018), section V.A, for the exponential.
"""

from __future__ import annotations

import math
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Pose = NDArray[np.float64]

ABOVE_MINUS_PI = math.nextafter(-math.pi, 0.0)


class PoseError(InvalidArgumentError):
    """Something that is no pose, twist, matrix or covariance; `argument` names it."""


@overload
def wrap_angle(angle: float) -> float: ...
@overload
def wrap_angle(angle: NDArray[np.float64]) -> NDArray[np.float64]: ...
def wrap_angle(angle: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
    """Bring an angle in radians back to ]-pi, pi], elementwise: pi stays pi, -pi becomes pi.

    An angle that is well inside is left as it is, to the last digit.
    """
    if isinstance(angle, float) and -3.0 <= angle <= 3.0:
        return angle
    turns = np.ceil((angle - np.pi) / (2.0 * np.pi))
    # Rounding must not lead out of the interval.
    return np.minimum(np.maximum(angle - turns * (2.0 * np.pi), ABOVE_MINUS_PI), np.pi)


def rotation_matrix(theta: float) -> Floats:
    """The 2 x 2 matrix of the rotation by theta radians."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s], [s, c]])


def compose(T_a_b: ArrayLike, T_b_c: ArrayLike) -> Pose:
    """The pose of c in a, from the pose of b in a and the pose of c in b. Raises PoseError.

    (x1, y1, t1) + (x2, y2, t2) = (x1 + x2 cos t1 - y2 sin t1, y1 + x2 sin t1 + y2 cos t1, t1 + t2)      (1)
    """
    x1, y1, t1 = _split_poses("T_a_b", T_a_b)
    x2, y2, t2 = _split_poses("T_b_c", T_b_c)
    c, s = np.cos(t1), np.sin(t1)
    return _stack_columns(x1 + c * x2 - s * y2, y1 + s * x2 + c * y2, wrap_angle(t1 + t2))


def inverse(T_a_b: ArrayLike) -> Pose:
    """The pose of a in b: compose(T_a_b, inverse(T_a_b)) is the identity. Raises PoseError.

    (x, y, t)^-1 = (-x cos t - y sin t, x sin t - y cos t, -t)                                             (2)
    """
    x, y, t = _split_poses("T_a_b", T_a_b)
    c, s = np.cos(t), np.sin(t)
    return _stack_columns(-c * x - s * y, s * x - c * y, wrap_angle(-t))


def relative(T_a_b: ArrayLike, T_a_c: ArrayLike) -> Pose:
    """The pose of c in b, both being given in a: compose(inverse(T_a_b), T_a_c), by (1) and (2). Raises PoseError."""
    x1, y1, t1 = _split_poses("T_a_b", T_a_b)
    x2, y2, t2 = _split_poses("T_a_c", T_a_c)
    c, s = np.cos(t1), np.sin(t1)
    dx, dy = x2 - x1, y2 - y1
    return _stack_columns(c * dx + s * dy, c * dy - s * dx, wrap_angle(t2 - t1))


def transform(T_a_b: ArrayLike, points_b: ArrayLike) -> Floats:
    """The points (n, 2) of frame b, in frame a: R(theta) p + (x, y). One pose (3,) only. Raises PoseError."""
    pose, points = _check_pose("T_a_b", T_a_b), np.asarray(points_b, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.all(np.isfinite(points)):
        raise PoseError("points_b", f"of shape {points.shape} is not an array (n, 2) of finite coordinates")
    return points @ rotation_matrix(pose[2]).T + pose[:2]


def to_matrix(T_a_b: ArrayLike) -> Floats:
    """The homogeneous matrices (…, 3, 3) of poses (…, 3). Raises PoseError."""
    x, y, t = _split_poses("T_a_b", T_a_b)
    c, s, zero, unit = np.cos(t), np.sin(t), np.zeros_like(t), np.ones_like(t)
    return np.stack([_stack_columns(c, -s, x), _stack_columns(s, c, y), _stack_columns(zero, zero, unit)], axis=-2)


def from_matrix(matrices: ArrayLike) -> Pose:
    """The poses (…, 3) of homogeneous matrices (…, 3, 3), which must be rigid to 1e-6. Raises PoseError."""
    M = np.asarray(matrices, dtype=np.float64)
    if M.shape[-2:] != (3, 3) or not np.all(np.isfinite(M)):
        raise PoseError("matrices", f"of shape {M.shape} are not arrays (…, 3, 3) of finite numbers")
    R = M[..., :2, :2]
    orthogonal = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(2)) <= 1e-6
    if not np.all(orthogonal) or np.any(np.linalg.det(R) < 0) or np.any(np.abs(M[..., 2, :] - [0, 0, 1]) > 1e-6):
        raise PoseError("matrices", "are not those of displacements of the plane")
    return _stack_columns(M[..., 0, 2], M[..., 1, 2], np.arctan2(M[..., 1, 0], M[..., 0, 0]))


def exp(twist: ArrayLike) -> Pose:
    """The pose reached from the identity by moving with a twist (…, 3) for one unit of time: an arc of a circle.

    exp(v, w) = (V(w) v, w),  V(w) = [[sin w, -(1 - cos w)], [1 - cos w, sin w]] / w               (Solà et al., 156)

    Raises PoseError.
    """
    vx, vy, w = _split_poses("twist", twist)
    a, b = _sinc(w), _cosc(w)
    return _stack_columns(a * vx - b * vy, b * vx + a * vy, wrap_angle(w))


def log(T_a_b: ArrayLike) -> Floats:
    """The twist (…, 3), of the smallest |omega|, that leads to a pose (…, 3): exp(log(T)) = T. Raises PoseError.

    v = V(w)^-1 t,  V(w)^-1 = [[h, w/2], [-w/2, h]],  h = (w / 2) / tan(w / 2)                     (Solà et al., 158)
    """
    x, y, t = _split_poses("T_a_b", T_a_b)
    w = wrap_angle(t)
    half = 0.5 * w
    h = np.cos(half) / _sinc(half)
    return _stack_columns(h * x + half * y, h * y - half * x, w)


def adjoint(T_a_b: ArrayLike) -> Floats:
    """The matrices (…, 3, 3) that carry twists of b to a: T exp(xi) T^-1 = exp(Ad_T xi). Raises PoseError.

    Ad = [[R, (y, -x)^T], [0, 1]]                                                                  (Solà et al., 159)
    """
    x, y, t = _split_poses("T_a_b", T_a_b)
    c, s, zero, unit = np.cos(t), np.sin(t), np.zeros_like(t), np.ones_like(t)
    return np.stack([_stack_columns(c, -s, y), _stack_columns(s, c, -x), _stack_columns(zero, zero, unit)], axis=-2)


def compose_jacobians(T_a_b: ArrayLike, T_b_c: ArrayLike) -> tuple[Floats, Floats]:
    """The derivatives (…, 3, 3) of (1) with respect to T_a_b and to T_b_c. Raises PoseError.

    J_ab = [[1, 0, -(y3 - y1)], [0, 1, x3 - x1], [0, 0, 1]],  J_bc = [[R(t1), 0], [0, 1]]       (Smith et al., J_+)
    """
    _, _, t = _split_poses("T_a_b", T_a_b)
    x2, y2, _ = _split_poses("T_b_c", T_b_c)
    c, s = np.cos(t), np.sin(t)
    unit, zero = np.ones_like(c * x2), np.zeros_like(c * x2)
    by_ab = [
        _stack_columns(unit, zero, -s * x2 - c * y2),
        _stack_columns(zero, unit, c * x2 - s * y2),
        _stack_columns(zero, zero, unit),
    ]
    by_bc = [_stack_columns(c, -s, zero), _stack_columns(s, c, zero), _stack_columns(zero, zero, unit)]
    return np.stack(by_ab, axis=-2), np.stack(by_bc, axis=-2)


def inverse_jacobian(T_a_b: ArrayLike) -> Floats:
    """The derivative (…, 3, 3) of (2). With (x', y', t') the inverse:                          (Smith et al., J_-)

    J = [[-cos t, -sin t, y'], [sin t, -cos t, -x'], [0, 0, -1]]

    Raises PoseError.
    """
    _, _, t = _split_poses("T_a_b", T_a_b)
    back = inverse(T_a_b)
    c, s, zero, unit = np.cos(t), np.sin(t), np.zeros_like(t), np.ones_like(t)
    rows = [
        _stack_columns(-c, -s, back[..., 1]),
        _stack_columns(s, -c, -back[..., 0]),
        _stack_columns(zero, zero, -unit),
    ]
    return np.stack(rows, axis=-2)


def relative_jacobians(T_a_b: ArrayLike, T_a_c: ArrayLike) -> tuple[Floats, Floats]:
    """The derivatives (…, 3, 3) of `relative` with respect to T_a_b and T_a_c, by the chain rule. Raises PoseError."""
    by_inverse, by_ac = compose_jacobians(inverse(T_a_b), T_a_c)
    return by_inverse @ inverse_jacobian(T_a_b), by_ac


def compose_covariance(T_a_b: ArrayLike, cov_a_b: ArrayLike, T_b_c: ArrayLike, cov_b_c: ArrayLike) -> Floats:
    """The covariance (3, 3) of compose(T_a_b, T_b_c), to first order, for independent errors. Raises PoseError.

    S = J_ab S_ab J_ab^T + J_bc S_bc J_bc^T                                                                    (3)
    """
    by_ab, by_bc = compose_jacobians(_check_pose("T_a_b", T_a_b), _check_pose("T_b_c", T_b_c))
    S_ab, S_bc = _check_covariance("cov_a_b", cov_a_b), _check_covariance("cov_b_c", cov_b_c)
    return np.asarray(by_ab @ S_ab @ by_ab.T + by_bc @ S_bc @ by_bc.T)


def inverse_covariance(T_a_b: ArrayLike, cov_a_b: ArrayLike) -> Floats:
    """The covariance (3, 3) of inverse(T_a_b), to first order: J S J^T. Raises PoseError."""
    J = inverse_jacobian(_check_pose("T_a_b", T_a_b))
    return np.asarray(J @ _check_covariance("cov_a_b", cov_a_b) @ J.T)


def relative_covariance(T_a_b: ArrayLike, T_a_c: ArrayLike, joint_covariance: ArrayLike) -> Floats:
    """The covariance (3, 3) of relative(T_a_b, T_a_c), to first order, from that (6, 6) of both poses together.

    Two poses of one trajectory share errors: their correlation is what makes nearby poses sure of each other.
    S = [J_ab J_ac] S_joint [J_ab J_ac]^T. Raises PoseError.
    """
    J = np.hstack(relative_jacobians(_check_pose("T_a_b", T_a_b), _check_pose("T_a_c", T_a_c)))
    return np.asarray(J @ _check_covariance("joint_covariance", joint_covariance, 6) @ J.T)


def _sinc(w: Floats) -> Floats:
    """sin w / w, which is 1 at 0."""
    return np.sinc(w / np.pi)


def _cosc(w: Floats) -> Floats:
    """(1 - cos w) / w, which is 0 at 0, without loss of digits: sin(w / 2) sinc(w / 2)."""
    return np.asarray(np.sin(0.5 * w) * _sinc(0.5 * w))


def _split_poses(argument: str, poses: ArrayLike) -> tuple[Floats, Floats, Floats]:
    values = np.asarray(poses, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] != 3:
        raise PoseError(argument, f"has shape {values.shape}, not (3,) or (…, 3)")
    single = values.ndim == 1
    if not (all(map(math.isfinite, values.tolist())) if single else np.isfinite(values).all()):
        raise PoseError(argument, "holds a coordinate that is not finite")
    return (values[0], values[1], values[2]) if single else (values[..., 0], values[..., 1], values[..., 2])


def _check_pose(argument: str, pose: ArrayLike) -> Pose:
    values = np.array(_split_poses(argument, pose))
    if values.shape != (3,):
        raise PoseError(argument, f"has shape {values.shape}, not (3,)")
    return values


def _check_covariance(argument: str, covariance: ArrayLike, size: int = 3) -> Floats:
    S = np.asarray(covariance, dtype=np.float64)
    if S.shape != (size, size) or not np.all(np.isfinite(S)):
        raise PoseError(argument, f"of shape {S.shape} is not an array ({size}, {size}) of finite numbers")
    spread = float(np.abs(S).max())
    if np.abs(S - S.T).max() > 1e-9 * spread or np.linalg.eigvalsh(S).min() < -1e-9 * spread:
        raise PoseError(argument, "is not symmetric with eigenvalues of zero or more")
    return S


def _stack_columns(*columns: Floats) -> Floats:
    if all(column.ndim == 0 for column in columns):
        return np.array(columns)
    shapes = {column.shape for column in columns}
    stacked = np.empty((*(shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)), len(columns)))
    for index, column in enumerate(columns):
        stacked[..., index] = column
    return stacked
