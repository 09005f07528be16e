"""Rigid registration of paired point clouds in any dimension: the rotation and translation that fit best.

`R_q_p`, `t_q_p` carry coordinates from the frame of P to the frame of Q: q ~ R_q_p p + t_q_p. Clouds are arrays (n, d),
one point a row, paired by their rows, in any unit of length (the same for both).

Sources: Kabsch, "A solution for the best rotation to relate two sets of vectors" (1976); for the sign of the
determinant, Umeyama, "Least-squares estimation of transformation parameters between two point patterns" (1991).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]

ROUNDING = 16.0 * float(np.finfo(np.float64).eps)


class InvalidCloudError(InvalidArgumentError):
    """Clouds that cannot be registered; `argument` names the one at fault ("P" or "Q")."""


@dataclass(frozen=True)
class RigidAlignment:
    """The best rigid transformation from P to Q.

    `R_q_p` (d, d) is a rotation, det = +1; `t_q_p` (d,). `singular_values` (d,), decreasing, are those of the
    cross-covariance H. `residual` is the minimum of sum |R p + t - q|^2. `unique` is False when other rotations fit
    as well, up to rounding: `R_q_p` is then one of the best.
    """

    R_q_p: Floats
    t_q_p: Floats
    singular_values: Floats
    residual: float
    unique: bool


def kabsch(P: ArrayLike, Q: ArrayLike) -> RigidAlignment:
    """The rotation and translation that minimise sum |R p_i + t - q_i|^2, for clouds P and Q (n, d), n >= 1.

    With H = sum (p_i - p_mean)(q_i - q_mean)^T = U S V^T:

        R = V diag(1, ..., 1, det(V U^T)) U^T,    t = q_mean - R p_mean           (Umeyama 1991, eq. 40-42)

    Raises InvalidCloudError for an empty cloud, shapes that differ or a coordinate that is not finite.
    """
    p, q = _check_clouds(P, Q)
    p_mean, q_mean = p.mean(axis=0), q.mean(axis=0)
    p_centred, q_centred = p - p_mean, q - q_mean
    U, singular_values, Vt = np.linalg.svd(p_centred.T @ q_centred)
    sign = 1.0 if np.linalg.det(U) * np.linalg.det(Vt) > 0 else -1.0
    signs = np.ones(p.shape[1])
    signs[-1] = sign
    R = (Vt.T * signs) @ U.T
    t = q_mean - R @ p_mean
    floor = _rounding_floor((p, p_centred), (q, q_centred))
    return RigidAlignment(R, t, singular_values, squared_residual(R, t, p, q), _is_unique(singular_values, sign, floor))


def squared_residual(R_q_p: ArrayLike, t_q_p: ArrayLike, P: ArrayLike, Q: ArrayLike) -> float:
    """sum |R p_i + t - q_i|^2 over the pairs of P and Q (n, d): the cost that `kabsch` minimises."""
    gaps = np.asarray(P) @ np.asarray(R_q_p).T + np.asarray(t_q_p) - np.asarray(Q)
    return float(np.sum(gaps * gaps))


def _check_clouds(P: ArrayLike, Q: ArrayLike) -> tuple[Floats, Floats]:
    p, q = np.asarray(P, dtype=np.float64), np.asarray(Q, dtype=np.float64)
    for name, cloud in (("P", p), ("Q", q)):
        if cloud.ndim != 2 or 0 in cloud.shape:
            raise InvalidCloudError(name, f"expected one or more points as rows, got shape {cloud.shape}")
        if not np.all(np.isfinite(cloud)):
            raise InvalidCloudError(name, "a coordinate is not finite")
    if p.shape != q.shape:
        raise InvalidCloudError("Q", f"shape {q.shape} differs from that of P, {p.shape}")
    return p, q


def _is_unique(singular_values: Floats, sign: float, floor: float) -> bool:
    """Is tr(R H) maximal at one rotation only? At R, the gap to a turn in the last two axes is s_(d-1) + sign s_d."""
    if singular_values.size == 1:
        return True
    return bool(singular_values[-2] + sign * singular_values[-1] > floor)


def _rounding_floor(p: tuple[Floats, Floats], q: tuple[Floats, Floats]) -> float:
    """How far rounding alone, in the centred clouds and in their product, can move a singular value of H.

    Each pair holds a cloud and the same cloud centred: centring errs by about eps |P|, whatever is left of P.
    """
    (p_size, p_spread), (q_size, q_spread) = (tuple(float(np.linalg.norm(c)) for c in pair) for pair in (p, q))
    return ROUNDING * (p_size * q_spread + p_spread * q_size + ROUNDING * p_size * q_size)
