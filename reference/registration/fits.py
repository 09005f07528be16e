"""The best motion for given pairs: onto points, or one step towards lines. Points of the plane are numbers x + i y."""

from __future__ import annotations

import cmath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.registration.nearest import Complexes, squared_moduli, to_coordinate_rows
from reference.registration.observability import line_jacobians
from reference.registration.rigid import ROUNDING
from reference.se2 import Pose, wrap_angle

Floats = NDArray[np.float64]

UNSEEN = 1e-9
TINY = float(np.finfo(np.float64).tiny)


def transform_points(T_q_p: Pose, points: Complexes) -> Complexes:
    """The points (n,) of the frame of P, in the frame of Q: z becomes exp(i theta) z + (x + i y)."""
    x, y, theta = T_q_p.tolist()
    return points * cmath.rect(1.0, theta) + complex(x, y)


class WeightedPoints(NamedTuple):
    """Points with their weights: the mean, and weight times what is left (n,), with the root of the sum of its squares.

    A cloud that is fitted again and again with all its weights equal is weighed once.
    """

    mean: complex
    parts: Complexes
    size: float

    @classmethod
    def from_points(cls, points: Complexes, weights: Floats | None = None) -> WeightedPoints:
        """Points (n,) and their weights (n,); 1 each, unless given."""
        if weights is None:
            mean = complex(np.add.reduce(points)) / len(points)
            parts = points - mean
        else:
            mean = complex(weights @ points) / float(weights.sum())
            parts = weights * (points - mean)
        return cls(mean, parts, float(np.vdot(parts, parts).real) ** 0.5)


def fit_weighted_pairs(p: WeightedPoints, q: Complexes, weights: Floats | None, T_q_p: Pose) -> Pose:
    """The motion that minimises sum w |R p + t - q|^2 over pairs (n,): Theorem 3 in the plane, in closed form.

    With centred points, sum w conj(p) q = sum w p . q + i sum w p x q, and R is the turn by its argument: a rotation by
    construction. Where it is null every turn fits as well, and that of `T_q_p` stays. `p` has the same `weights` (n,).
    """
    mean = complex(np.add.reduce(q)) / len(q) if weights is None else complex(weights @ q) / float(weights.sum())
    centred = q - mean
    z = complex(np.vdot(p.parts, centred))
    size = p.size * float(np.vdot(centred, centred).real) ** 0.5
    theta = cmath.phase(z) if abs(z) > ROUNDING * size else float(T_q_p[2])
    t = mean - cmath.rect(1.0, theta) * p.mean
    return np.array([t.real, t.imag, theta])


def step_towards_lines(
    T_q_p: Pose, moved: Complexes, q: Complexes, normals: Complexes, weights: Floats, unseen: float = UNSEEN
) -> Pose:
    """One Gauss-Newton step of sum w (n . (R p + t - q))^2, turning about the centre of the points `moved` = R p + t.

    Least norm where the lines leave a motion free: where its strength, as `Observability`'s, is `unseen` or less.
    """
    total = weights.sum()
    centre = complex(weights @ moved) / total
    # Where all that counts is one point no turn is seen; what does not count must not be divided by that nothing.
    apart = squared_moduli(moved - centre)
    spread = max(float(weights @ apart / total) ** 0.5, ROUNDING * float(apart.max()) ** 0.5, TINY)
    J = line_jacobians(to_coordinate_rows(moved), to_coordinate_rows(normals), np.array([centre.real, centre.imag])) / [
        1.0,
        1.0,
        spread,
    ]
    gaps = (np.conj(normals) * (moved - q)).real
    weighted = J * weights[:, None]
    strengths, directions = np.linalg.eigh(weighted.T @ J)
    seen = strengths > unseen * total
    held = directions[:, seen]
    dx, dy, turn = -held @ ((held.T @ (weighted.T @ gaps)) / strengths[seen]) / [1.0, 1.0, spread]
    # The turn about the centre and the displacement come after the motion so far.
    t = cmath.rect(1.0, turn) * (complex(*T_q_p[:2]) - centre) + centre + complex(dx, dy)
    return np.array([t.real, t.imag, wrap_angle(float(T_q_p[2] + turn))])
