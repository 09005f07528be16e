"""What a registration can know: which motions the lines of the target hold, and which would go unseen.

A displacement along a corridor, or a turn inside a round room, changes no distance to a line. The Hessian of the
point-to-line cost has then a null direction, and an answer along it is an accident.

Sources: Censi, "An accurate closed-form estimate of ICP's covariance" (2007); Zhang, Kaess, Singh, "On Degeneracy of
Optimization-based State Estimation Problems" (2016), for the test on the smallest eigenvalue.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEGENERATE = 0.01


@dataclass(frozen=True)
class Observability:
    """How firmly lines hold a pose T_q_p.

    `hessian` (3, 3): half the second derivative of sum (n . (R p + t - q))^2 by (x, y, theta), that is sum J'J with

        J = [n_x, n_y, n . (R p turned by +90 degrees)]                                                    (1)

    divided by the variance of a gap it is the information of the pose, as an edge of a pose graph wants it.
    `strengths` (3,), increasing, of sum at most 2, and `directions` (3, 3), one a row: eigenvalues and eigenvectors of
    the same matrix per pair, with lengths in units of the cloud's spread about its centre, so that metres and radians
    compare. Direction k is a motion (x, y, turn times spread) about that centre.
    """

    hessian: Floats
    strengths: Floats
    directions: Floats

    @property
    def is_degenerate(self) -> bool:
        """Is there a motion that the lines do not see, or hardly?"""
        return bool(self.strengths[0] < DEGENERATE)


def observability(moved: Floats, t_q_p: Floats, normals: Floats, weights: Floats) -> Observability:
    """For points `moved` = R p + t (n, 2), the normals (n, 2) of the targets paired with them, and weights (n,)."""
    J = line_jacobians(moved, normals, t_q_p)
    hessian = (J * weights[:, None]).T @ J
    total = max(float(weights.sum()), float(np.finfo(np.float64).tiny))
    centre = weights @ moved / total
    spread = np.sqrt(max(float(weights @ np.sum((moved - centre) ** 2, axis=1)) / total, 1e-300))
    centred = line_jacobians(moved, normals, centre) / [1.0, 1.0, spread]
    strengths, directions = np.linalg.eigh((centred * weights[:, None]).T @ centred / total)
    return Observability(hessian, np.maximum(strengths, 0.0), directions.T)


def line_jacobians(moved: Floats, normals: Floats, pivot: Floats) -> Floats:
    """Derivatives (n, 3) of n . p by a displacement and by a turn about `pivot` (2,), for points p (n, 2): (1)."""
    arm = moved - pivot
    return np.column_stack([normals, normals[:, 1] * arm[:, 0] - normals[:, 0] * arm[:, 1]])
