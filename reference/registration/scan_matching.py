"""The motion between two scans, and how far it can be believed.

From a guess near the truth, point-to-line ICP suffices; without one, `correlate` looks through a window first. The
answer comes with its information, for the edge of a pose graph, and with what speaks against it: a direction that the
walls do not hold, or points that find no counterpart.

Source: Censi, "An ICP variant using a point-to-line metric" (2008).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from reference.registration.correlation import Window, correlate
from reference.registration.icp import IcpError, IcpResult, Pairing, icp_to_lines
from reference.registration.kernels import Cauchy
from reference.registration.normals import normals_by_neighbours, plane_cloud
from reference.registration.observability import Observability, observability
from reference.se2 import Pose, transform
from reference.world.scan import Scan

Floats = NDArray[np.float64]

MIN_POINTS = 10


@dataclass(frozen=True)
class Matching:
    """How scans are matched, in metres: pairs farther than `max_distance` are dropped, gaps beyond `scale` count less.

    Points within `near` of the other scan overlap it; `sigma` is the least standard deviation believed of a gap.
    """

    max_distance: float = 0.5
    scale: float = 0.05
    near: float = 0.15
    sigma: float = 0.01

    def __post_init__(self) -> None:
        for name in ("max_distance", "scale", "near", "sigma"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise IcpError(name, f"{getattr(self, name)} is not a positive length")


@dataclass(frozen=True, eq=False)
class ScanMatch:
    """The pose `T_a_b` of the robot at scan b, seen from scan a.

    `information` (3, 3) of (x, y, theta), in 1/m^2, 1/(m rad), 1/rad^2; `overlap`: the share of the points of each scan
    that lie near the other, the smaller of the two; `held`: what the walls hold; `icp`: how the search went.
    """

    T_a_b: Pose
    information: Floats
    overlap: float
    held: Observability
    icp: IcpResult

    @property
    def degenerate(self) -> bool:
        """Is there a motion that the walls do not see?"""
        return self.held.degenerate


def match_scans(
    a: Scan, b: Scan, T_a_b: ArrayLike, *, matching: Matching | None = None, window: Window | None = None
) -> ScanMatch:
    """The pose of scan b seen from scan a, from the guess `T_a_b` (3,), or from the best place in a `window` around it.

    Raises IcpError for a scan of fewer than 10 points, or when nothing of b comes near a.
    """
    rule = matching or Matching()
    points_a, points_b = _points("a", a), _points("b", b)
    guess = correlate(points_b, points_a, T_a_b, window).T_q_p if window else np.asarray(T_a_b, dtype=np.float64)
    normals = normals_by_neighbours(points_a)
    pairing = Pairing(Cauchy(rule.scale), rule.max_distance)
    found = icp_to_lines(points_b, points_a, normals, guess, pairing=pairing, tolerance=1e-6)
    moved = transform(found.T_q_p, points_b)
    held = observability(moved, found.t_q_p, normals[found.pairs], found.weights)
    variance = max(found.rmse, rule.sigma) ** 2
    there, back = (cKDTree(x).query(y)[0] for x, y in ((points_a, moved), (moved, points_a)))
    overlap = min(float(np.mean(there <= rule.near)), float(np.mean(back <= rule.near)))
    return ScanMatch(found.T_q_p, held.hessian / variance, overlap, held, found)


def _points(name: str, scan: Scan) -> Floats:
    points = scan.points()
    if len(points) < MIN_POINTS:
        raise IcpError(name, f"shows {len(points)} points, fewer than {MIN_POINTS}")
    return plane_cloud(name, points)
