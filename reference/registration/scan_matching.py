"""The motion between two scans, or from a few scans laid together to one more, and how far it can be believed.

From a guess near the truth, point-to-line ICP suffices; without one, `match_by_correlation` looks through a window
first. The answer comes with its information, for the edge of a pose graph, and with what speaks against it: a direction
that the walls do not hold, or points that find no counterpart.

The errors of the beams that end on one piece of wall are hardly independent: the map is wrong there, or the wall is
rough, or somebody stands before it, for all of them alike. So each piece of `patch` metres counts as one measurement,
however many beams fall on it; and a direction that too few pieces hold has no information at all, rather than little.

Sources: Censi, "An ICP variant using a point-to-line metric" (2008), and "An accurate closed-form estimate of ICP's
covariance" (2007), for what the covariance of a match leaves out; Zhang, Kaess, Singh, "On Degeneracy of
Optimization-based State Estimation Problems" (2016), for leaving weak directions out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from reference.registration.correlation import SearchWindow, match_by_correlation
from reference.registration.icp import IcpError, IcpResult, PairingRule, icp_to_lines
from reference.registration.kernels import Cauchy
from reference.registration.normals import check_plane_cloud, normals_by_neighbours
from reference.registration.observability import DEGENERATE, Observability, line_jacobians, observability
from reference.se2 import Pose, rotation_matrix, transform
from reference.world.scan import Scan

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MIN_POINTS = 10
THICKNESS = 0.05
SHORTEST_ARM = 0.1
STILL = 1e-5


@dataclass(frozen=True)
class MatchingSettings:
    """How scans are matched, in metres: pairs farther than `max_distance` are dropped, gaps beyond `scale` count less.

    Points within `near` of the other scan overlap it; `sigma` is the standard deviation believed of the gap of a piece
    of wall of `patch` metres. A motion that less than the share `weakest` of the pieces hold is free. The window search
    leaves points beyond `reach` out: they would ask for the finest turns.
    """

    max_distance: float = 0.4
    scale: float = 0.05
    near: float = 0.12
    sigma: float = 0.03
    patch: float = 0.5
    weakest: float = 0.05
    reach: float = 20.0

    def __post_init__(self) -> None:
        for name in ("max_distance", "scale", "near", "sigma", "patch", "weakest", "reach"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise IcpError(name, f"{getattr(self, name)} is not a positive number")


@dataclass(frozen=True, eq=False)
class LineCloud:
    """Points (n, 2) of walls in one frame, and the unit normal (n, 2) of the wall at each; null where it has none."""

    points: Floats
    normals: Floats

    @classmethod
    def from_scan(cls, scan: Scan, T_robot_laser: ArrayLike = (0.0, 0.0, 0.0)) -> LineCloud:
        """The points that a scan shows, in the frame of the robot."""
        points = transform(T_robot_laser, scan.points())
        if len(points) < MIN_POINTS:
            return cls(points, np.zeros_like(points))
        return cls(points, normals_by_neighbours(points, max_thickness=THICKNESS))

    @classmethod
    def join(cls, clouds: Sequence[LineCloud]) -> LineCloud:
        """All the points of several clouds of one frame."""
        return cls(np.concatenate([c.points for c in clouds]), np.concatenate([c.normals for c in clouds]))

    def __len__(self) -> int:
        return len(self.points)

    def transform(self, T_a_b: Pose) -> LineCloud:
        """The cloud of frame b, in frame a."""
        R = rotation_matrix(float(T_a_b[2]))
        return LineCloud(self.points @ R.T + T_a_b[:2], self.normals @ R.T)

    def thin(self, cell: float) -> LineCloud:
        """One point of each square of `cell` metres."""
        _, first = np.unique(_square_numbers(self.points, cell), return_index=True)
        return LineCloud(self.points[first], self.normals[first])


@dataclass(frozen=True, eq=False)
class ScanMatch:
    """The pose `T_a_b` of the robot at scan b, seen from scan a.

    `information` (3, 3) of (x, y, theta), in 1/m^2, 1/(m rad), 1/rad^2, positive semidefinite: a motion that the walls
    do not hold has none. `overlap`: the share of the points of b that lie near a; of `match_scans`, also of a near b,
    the smaller of the two. `held`: what the walls hold; `icp`: how the search went.
    """

    T_a_b: Pose
    information: Floats
    overlap: float
    observability: Observability
    icp: IcpResult

    @property
    def is_degenerate(self) -> bool:
        """Is there a motion that the walls do not see?"""
        return self.observability.is_degenerate


def match_scans(
    a: Scan, b: Scan, T_a_b: ArrayLike, *, matching: MatchingSettings | None = None, window: SearchWindow | None = None
) -> ScanMatch:
    """The pose of scan b seen from scan a, from the guess `T_a_b` (3,), or from the best place in a `window` around it.

    Raises IcpError for a scan of fewer than 10 points, or when nothing of b comes near a.
    """
    rule, clouds = matching or MatchingSettings(), (LineCloud.from_scan(a), LineCloud.from_scan(b))
    for name, cloud in zip("ab", clouds, strict=True):
        if len(cloud) < MIN_POINTS:
            raise IcpError(name, f"shows {len(cloud)} points, fewer than {MIN_POINTS}")
    match = match_clouds(*clouds, T_a_b, matching=rule, window=window)
    moved = transform(match.T_a_b, clouds[1].points)
    back = float(np.mean(cKDTree(moved).query(clouds[0].points)[0] <= rule.near))
    return ScanMatch(match.T_a_b, match.information, min(match.overlap, back), match.observability, match.icp)


def match_clouds(
    a: LineCloud,
    b: LineCloud,
    T_a_b: ArrayLike,
    *,
    matching: MatchingSettings | None = None,
    window: SearchWindow | None = None,
) -> ScanMatch:
    """The pose of cloud b on cloud a, as `match_scans`; a may be many scans laid together.

    Raises IcpError or InvalidCloudError, also when nothing of b comes near a.
    """
    rule, guess = matching or MatchingSettings(), np.asarray(T_a_b, dtype=np.float64)
    if window:
        close = b.points[np.linalg.norm(check_plane_cloud("b", b.points), axis=1) <= rule.reach]
        guess = match_by_correlation(close, a.points, guess, window).T_q_p
    pairing = PairingRule(Cauchy(rule.scale), rule.max_distance)
    # A few points of a door frame would let a corridor slide by metres: along what is hardly seen, the guess stays.
    found = icp_to_lines(b.points, a.points, a.normals, guess, pairing=pairing, tolerance=STILL, unseen=DEGENERATE)
    moved, normals = transform(found.T_q_p, b.points), a.normals[found.pairs]
    overlap = float(np.mean(np.linalg.norm(moved - a.points[found.pairs], axis=1) <= rule.near))
    held = observability(moved, found.t_q_p, normals, found.weights)
    information = _match_information(moved, found.t_q_p, normals, found.weights, rule)
    return ScanMatch(found.T_q_p, information, overlap, held, found)


def _match_information(
    moved: Floats, t_a_b: Floats, normals: Floats, weights: Floats, rule: MatchingSettings
) -> Floats:
    """The sum (3, 3) over the pieces of wall of the mean of w J'J / sigma^2 of the points on each, w their weights.

    What is weak is left out, lengths and angles being compared by the spread of the points about the robot.
    """
    counting = (weights > 0.0) & normals.any(axis=1)
    J, w = line_jacobians(moved[counting], normals[counting], t_a_b), weights[counting]
    if not len(J):
        return np.zeros((3, 3))
    _, piece, count = np.unique(_square_numbers(moved[counting], rule.patch), return_inverse=True, return_counts=True)
    arms = np.hypot(*(moved[counting] - t_a_b).T)
    units = np.array([1.0, 1.0, max(float(np.sqrt(np.mean(arms**2))), SHORTEST_ARM)])
    scaled = J / units
    strengths, directions = np.linalg.eigh((scaled * (w / count[piece])[:, None]).T @ scaled)
    strengths = np.where(strengths < rule.weakest * len(count), 0.0, strengths)
    whole = (directions * strengths) @ directions.T * np.outer(units, units) / rule.sigma**2
    return np.asarray((whole + whole.T) / 2.0)


def _square_numbers(points: Floats, cell: float) -> Indices:
    """A number (n,) for the square of `cell` metres in which each point lies."""
    columns = np.floor(points / cell).astype(np.int64)
    columns -= columns.min(axis=0, initial=0)
    return np.asarray(columns[:, 0] * (columns[:, 1].max(initial=0) + 1) + columns[:, 1])
