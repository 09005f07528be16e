"""A complete small SLAM in the plane: wheels and scans in, trajectory and map out.

    odometry -> key poses -> places that look alike -> matched, or refused -> pose graph, optimised -> occupancy map

Each key pose is also linked to the one before by their scans, where the walls hold every motion. A loop is closed only
if four things agree: the signatures of the two scans, their overlap once matched, walls that hold every motion, and the
odometry between the two, by a chi-square test. What still strains the finished graph is cut out.

Sources: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010), for the division of work;
Bosse and Zlot, "Map Matching and Data Association for Large-Scale Two-dimensional Laser Scan-based SLAM" (2008), for
checking a match in several ways.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.loop_closure import fourier_signature, loop_candidates
from reference.occupancy import InverseSensorModel, OccupancyGrid, build_map
from reference.odometry import DifferentialDrive, integrate
from reference.pose_graph import PoseGraph, edge_chi2, gauss_newton
from reference.registration import IcpError, Matching, ScanMatch, Window, match_scans
from reference.se2 import compose, compose_covariance, relative, wrap_angle
from reference.world.scan import Scan

Floats = NDArray[np.float64]
Edge = tuple[int, int, Floats, Floats]

CHI2_99 = 11.34
FLOOR = np.diag([1e-6, 1e-6, 1e-6])


class FrontEndError(InvalidArgumentError):
    """A journey from which no map can be made; `argument` names what is at fault."""


@dataclass(frozen=True)
class Settings:
    """Key poses every `key_distance` m or `key_turn` rad; loops between poses `min_gap` key poses apart or more.

    Signatures within `likeness` m (of the mean range and its harmonics); at most `tries` matches a key pose, in a
    `window` around what odometry says; at least `min_overlap` of both scans in common, or `link_overlap`
    from a key pose to the next; squared errors up to `gate`.
    """

    key_distance: float = 0.4
    key_turn: float = 0.6
    min_gap: int = 10
    likeness: float = 0.3
    tries: int = 3
    window: Window = field(default_factory=lambda: Window(reach=1.5, turn=np.pi / 3.0))
    matching: Matching = field(default_factory=lambda: Matching(sigma=0.03))
    min_overlap: float = 0.9
    link_overlap: float = 0.6
    gate: float = CHI2_99

    def __post_init__(self) -> None:
        for name in ("key_distance", "key_turn", "likeness", "gate"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise FrontEndError(name, f"{getattr(self, name)} is not a positive number")
        if self.min_gap < 2 or self.tries < 1:
            raise FrontEndError("min_gap" if self.min_gap < 2 else "tries", "is too small for a loop to be found")


@dataclass(frozen=True, eq=False)
class Closure:
    """A match of key poses i < j, and the squared error (chi-square, 3 degrees) by which odometry disagrees with it.

    `refused`: why it does not count; empty if it does.
    """

    i: int
    j: int
    match: ScanMatch
    disagreement: float
    refused: str = ""


@dataclass(frozen=True, eq=False)
class Slam:
    """What came out: `poses` (n, 3) of all scans, `odometry` (n, 3) beside it, and the occupancy `grid`.

    `keys` (k,): the scans that are key poses, the nodes of `graph`. `links` join a key pose to the next, `closures` one
    to the past; `refused` were looked at and do not count. `chi2`: the squared error of the finished graph.
    """

    poses: Floats
    odometry: Floats
    keys: NDArray[np.int64]
    graph: PoseGraph
    links: tuple[Closure, ...]
    closures: tuple[Closure, ...]
    refused: tuple[Closure, ...]
    chi2: float
    grid: OccupancyGrid


def slam(
    scans: Sequence[Scan],
    wheels: ArrayLike,
    drive: DifferentialDrive,
    *,
    start: ArrayLike = (0.0, 0.0, 0.0),
    settings: Settings | None = None,
    resolution: float = 0.05,
) -> Slam:
    """The trajectory and the map of n `scans`, one a pose, with the `wheels` (n - 1, 2) counted between them.

    Scans must go all round, or a place would not look alike from another heading. The first pose is `start`.
    Raises FrontEndError.
    """
    rule, counted = settings or Settings(), _checked_wheels(scans, wheels)
    odometry = integrate(drive, counted, start)
    keys = key_poses(odometry, rule)
    builder = _Builder([scans[k] for k in keys], odometry[keys], _key_edges(drive, counted, keys), rule)
    for j in range(1, len(keys)):
        builder.add(j)
    builder.cut_strained()
    poses = _between_keys(odometry, keys, builder.poses)
    grid = build_map(scans, poses, resolution, model=InverseSensorModel(once_a_scan=True))
    graph = builder.graph()
    strain = float(edge_chi2(graph, builder.poses).sum())
    links, closures, refused = (tuple(part) for part in (builder.links, builder.closures, builder.refused))
    return Slam(poses, odometry, keys, graph, links, closures, refused, strain, grid)


def key_poses(odometry: Floats, settings: Settings) -> NDArray[np.int64]:
    """The indices (k,) of the poses (n, 3) kept as nodes: the first, and each far enough from the one kept before."""
    keys = [0]
    for k in range(1, len(odometry)):
        step = odometry[k] - odometry[keys[-1]]
        far = np.hypot(step[0], step[1]) >= settings.key_distance
        if far or abs(wrap_angle(float(step[2]))) >= settings.key_turn:
            keys.append(k)
    return np.array(keys)


def _key_edges(drive: DifferentialDrive, wheels: Floats, keys: NDArray[np.int64]) -> list[tuple[Floats, Floats]]:
    """The motion (3,) from each key pose to the next, by odometry, and its covariance (3, 3)."""
    edges = []
    for first, last in pairwise(keys):
        T, covariance = np.zeros(3), np.zeros((3, 3))
        for left, right in wheels[first:last].tolist():
            step = drive.increment(left, right)
            covariance = compose_covariance(T, covariance, step, drive.increment_covariance(left, right))
            T = compose(T, step)
        edges.append((T, covariance + FLOOR))
    return edges


def _between_keys(odometry: Floats, keys: NDArray[np.int64], key_estimates: Floats) -> Floats:
    """All poses (n, 3): each as odometry sees it from the key pose before."""
    before = np.searchsorted(keys, np.arange(len(odometry)), side="right") - 1
    return np.array([compose(key_estimates[b], relative(odometry[keys[b]], odometry[k])) for k, b in enumerate(before)])


class _Builder:
    """The graph as it grows: key poses `poses` (k, 3), edges of odometry, links and closures so far."""

    def __init__(
        self, scans: list[Scan], odometry: Floats, edges: list[tuple[Floats, Floats]], settings: Settings
    ) -> None:
        self.poses = odometry.copy()
        self.links: list[Closure] = []
        self.closures: list[Closure] = []
        self.refused: list[Closure] = []
        self._scans, self._edges, self._settings = scans, edges, settings
        self._signatures = np.array([fourier_signature(scan.filled_ranges()) / len(scan) for scan in scans])

    def add(self, j: int) -> None:
        """Place key pose j after the one before, by odometry and by their scans, and close the loops that it closes."""
        self.poses[j] = compose(self.poses[j - 1], self._edges[j - 1][0])
        link = self._look(j - 1, j, None)
        if link and not link.refused:
            self.links.append(link)
            self.poses[j] = compose(self.poses[j - 1], link.match.T_a_b)
        seen = [closure for closure in (self._look(i, j, self._settings.window) for i in self._alike(j)) if closure]
        self.refused += [closure for closure in seen if closure.refused]
        accepted = [closure for closure in seen if not closure.refused]
        if accepted:
            self.closures += accepted
            self.poses[: j + 1] = gauss_newton(self.graph(j + 1), self.poses[: j + 1]).poses

    def _alike(self, j: int) -> list[int]:
        """The key poses of the past that look most like j and may be near it, the likest first."""
        rule = self._settings
        found = loop_candidates(self._signatures[: j + 1], j, rule.likeness, min_gap=rule.min_gap)
        away = np.linalg.norm(self.poses[found.indices, :2] - self.poses[j, :2], axis=1)
        near = away <= 2.0 * rule.window.reach
        likest = found.indices[near][np.argsort(found.distances[near], kind="stable")]
        return [int(i) for i in likest[: rule.tries]]

    def _look(self, i: int, j: int, window: Window | None) -> Closure | None:
        """Match key pose j with i, and judge the match; None when the scans cannot even be compared."""
        rule, expected = self._settings, relative(self.poses[i], self.poses[j])
        try:
            match = match_scans(self._scans[i], self._scans[j], expected, matching=rule.matching, window=window)
        except IcpError:
            return None
        if match.degenerate:
            return Closure(i, j, match, np.inf, "the walls leave a motion free")
        disagreement = self._disagreement(i, j, expected, match)
        if match.overlap < (rule.min_overlap if window else rule.link_overlap):
            return Closure(i, j, match, disagreement, "the scans have too little in common")
        if disagreement > rule.gate:
            return Closure(i, j, match, disagreement, "odometry contradicts it")
        return Closure(i, j, match, disagreement)

    def _disagreement(self, i: int, j: int, expected: Floats, match: ScanMatch) -> float:
        """The squared distance of a match from what was expected, in units of what odometry from i to j may drift."""
        T, covariance = np.zeros(3), np.zeros((3, 3))
        for step, of_step in self._edges[i:j]:
            covariance = compose_covariance(T, covariance, step, of_step)
            T = compose(T, step)
        gap = match.T_a_b - expected
        gap[2] = wrap_angle(float(gap[2]))
        return float(gap @ np.linalg.solve(covariance + np.linalg.inv(match.information), gap))

    def cut_strained(self) -> None:
        """Remove, worst first, the closures that the finished graph cannot satisfy."""
        while self.closures:
            graph = self.graph()
            strain = edge_chi2(graph, self.poses)[len(self._edges) + len(self.links) :]
            worst = int(np.argmax(strain))
            if strain[worst] <= self._settings.gate:
                return
            bad = self.closures.pop(worst)
            self.refused.append(Closure(bad.i, bad.j, bad.match, bad.disagreement, "the other closures contradict it"))
            self.poses = gauss_newton(self.graph(), self.poses).poses

    def graph(self, count: int | None = None) -> PoseGraph:
        """The graph of the first `count` key poses: odometry first, then links, then closures."""
        n = len(self.poses) if count is None else count
        edges: list[Edge] = [
            (k, k + 1, step, np.asarray(np.linalg.inv(covariance), dtype=np.float64))
            for k, (step, covariance) in enumerate(self._edges[: n - 1])
        ]
        edges += [(c.i, c.j, c.match.T_a_b, _symmetric(c.match.information)) for c in [*self.links, *self.closures]]
        return PoseGraph.from_edges(n, [(i, j, z, _symmetric(omega)) for i, j, z, omega in edges])


def _symmetric(matrix: Floats) -> Floats:
    return np.asarray((matrix + matrix.T) / 2.0)


def _checked_wheels(scans: Sequence[Scan], wheels: ArrayLike) -> Floats:
    counted = np.asarray(wheels, dtype=np.float64)
    if len(scans) < 2:
        raise FrontEndError("scans", "are fewer than two: nothing was travelled")
    if len({len(scan) for scan in scans}) != 1 or not len(scans[0]):
        raise FrontEndError("scans", "do not all have the same beams, one or more")
    if counted.shape != (len(scans) - 1, 2) or not np.all(np.isfinite(counted)):
        raise FrontEndError("wheels", f"of shape {counted.shape} are not finite paths ({len(scans) - 1}, 2)")
    return counted
