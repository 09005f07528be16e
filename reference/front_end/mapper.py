"""The graph of key poses: linked to those before by tracking, and to those of long ago where a place is recognised.

A place is recognised by its walls: the last few scans, laid together, are searched on those around an old key pose, as
far as the robot may have drifted. Half a turn of a lidar sees one side of a place only; several scans see more. A loop
that odometry contradicts waits for others: robust optimisation, which doubts closures and never tracking, believes
them once they are so many that odometry must be what errs. It also chooses between those that contradict one another.

Sources: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010); Bosse and Zlot, "Map Matching
and Data Association for Large-Scale Two-dimensional Laser Scan-based SLAM" (2008), for maps matched with maps; Yang,
Antonante, Tzoumas, Carlone, "Graduated Non-Convexity for Robust Spatial Perception" (2020).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from reference.front_end.odometry import squared_disagreement, subtract_poses
from reference.front_end.settings import FrontEndSettings
from reference.front_end.tracker import TrackedScan
from reference.pose_graph import PoseGraph, edge_chi2, graduated_non_convexity, relative_covariance
from reference.registration import IcpError, InvalidCloudError, LineCloud, ScanMatch, SearchWindow, match_clouds
from reference.registration.scan_matching import MIN_POINTS
from reference.se2 import Floats, Pose, compose, relative

Edge = tuple[int, int, Pose, Floats]

ROUGHLY = 1.5
THIN_MAP, THIN_SCANS = 0.05, 0.1
TURN_PER_METRE, LEAST_TURN, MOST_TURN = 0.15, 0.1, 0.5
STRAINED, BELIEVED = 1.0, 0.5
APART, CONTRADICTED = "the scans have too little in common", "odometry contradicts it"


@dataclass(frozen=True, eq=False)
class LoopClosure:
    """A match of key poses i < j, and the squared error (chi-square, 3 degrees) by which odometry disagrees with it.

    `refusal`: why it does not count; empty if it does.
    """

    i: int
    j: int
    match: ScanMatch
    disagreement: float
    refusal: str = ""

    @property
    def edge(self) -> Edge:
        return self.i, self.j, self.match.T_a_b, self.match.information


class Mapper:
    """The map as it grows: `T_map_keys`, the `clouds` seen from there, `links` and `closures`, `refused` ones apart."""

    def __init__(self, settings: FrontEndSettings, T_map_start: Pose, cloud: LineCloud) -> None:
        self.T_map_keys: list[Pose] = [T_map_start]
        self.clouds: list[LineCloud] = [cloud]
        self.links: list[TrackedScan] = []
        self.closures: list[LoopClosure] = []
        self.refused: list[LoopClosure] = []
        self._believed: list[bool] = []
        self._contradicted: list[LoopClosure] = []
        self._settings = settings

    def add(self, cloud: LineCloud, tracked: TrackedScan) -> None:
        """Take a tracked scan as the next key pose, and close the loops that it closes."""
        self.T_map_keys.append(compose(self.T_map_keys[-1], tracked.T_key_robot))
        self.clouds.append(cloud)
        self.links.append(tracked)
        found = [
            closure
            for i, reach in self._closure_candidates()
            if (closure := self._search_closure(i, reach)) is not None
        ]
        self.refused += [closure for closure in found if closure.refusal == APART]
        self._contradicted += [closure for closure in found if closure.refusal == CONTRADICTED]
        accepted = [closure for closure in found if not closure.refusal]
        self.closures += accepted
        self._believed += [True] * len(accepted)
        if not self._reconsider_refused_closures() and any(
            self._closure_squared_error(closure) > STRAINED for closure in accepted
        ):
            self._optimise_key_poses()

    def _reconsider_refused_closures(self) -> bool:
        """Let the latest loops that odometry contradicts be weighed against it, once they are many; is any believed?

        Alone, each of them may be false. Together, they cost `gate` apiece to refuse, and only once, what stretches
        odometry, to believe: robust optimisation compares the two. It is asked where the first may be the greater.
        """
        newest, first = len(self.T_map_keys) - 1, len(self.closures)
        votes = [closure for closure in self._contradicted if newest - closure.j < self._settings.voters]
        if not votes or votes[-1].j < newest:
            return False
        if len(votes) * self._settings.gate < min(closure.disagreement for closure in votes):
            return False
        before = self._believed, self.T_map_keys
        self.closures, self._believed = self.closures + votes, self._believed + [True] * len(votes)
        self._optimise_key_poses()
        won = [vote for vote, good in zip(votes, self._believed[first:], strict=True) if good]
        self.closures = self.closures[:first] + [replace(vote, refusal="") for vote in won]
        if not won:
            self._believed, self.T_map_keys = before
            return False
        self._believed = self._believed[:first] + [True] * len(won)
        self._contradicted = [closure for closure in self._contradicted if closure not in won]
        return True

    def settle_closures(self) -> None:
        """Keep the closures that agree with one another and with tracking; refuse the others."""
        self.refused += self._contradicted
        self._contradicted = []
        self._optimise_key_poses()
        for closure, good in zip(self.closures, self._believed, strict=True):
            if not good:
                self.refused.append(replace(closure, refusal="the other closures contradict it"))
        self.closures = self._agreeing_closures()
        self._believed = [True] * len(self.closures)

    def graph(self) -> PoseGraph:
        """The graph of the key poses: links first, then the closures that are believed."""
        return self._build_graph(self._agreeing_closures())

    def chi2(self) -> float:
        """The squared error of that graph."""
        return float(edge_chi2(self.graph(), np.array(self.T_map_keys)).sum())

    def _agreeing_closures(self) -> list[LoopClosure]:
        return [closure for closure, good in zip(self.closures, self._believed, strict=True) if good]

    def _build_graph(self, closures: list[LoopClosure]) -> PoseGraph:
        edges = [(k, k + 1, link.T_key_robot, link.information) for k, link in enumerate(self.links)]
        edges += [closure.edge for closure in closures]
        return PoseGraph.from_edges(len(self.T_map_keys), [(i, j, z, (w + w.T) / 2.0) for i, j, z, w in edges])

    def _optimise_key_poses(self) -> None:
        """Move the key poses to where links and closures agree best; the closures that then count are believed."""
        if not self.closures:
            return
        graph, links = self._build_graph(self.closures), len(self.links)
        doubted = np.arange(len(graph.i)) >= links
        found = graduated_non_convexity(graph, np.array(self.T_map_keys), suspects=doubted, bound=self._settings.gate)
        self._believed = (found.weights[links:] >= BELIEVED).tolist()
        self.T_map_keys = list(found.poses)

    def _closure_candidates(self) -> list[tuple[int, float]]:
        """Old key poses that the newest one may stand at, the nearest first, and how far each may have drifted away."""
        rule, j = self._settings, len(self.T_map_keys) - 1
        past = j - rule.min_gap + 1
        if past < 1:
            return []
        T_here_keys = relative(self.T_map_keys[j], np.array(self.T_map_keys[:past]))
        since = np.full(past, j) - np.arange(past)
        if self.closures:
            since = np.minimum(since, j - self.closures[-1].j + rule.around)
        reach = np.minimum(rule.reach + rule.drift * since, rule.farthest)
        away = np.hypot(T_here_keys[:, 0], T_here_keys[:, 1])
        order = np.argsort(away + np.abs(T_here_keys[:, 2]), kind="stable")
        chosen: list[int] = []
        for i in order[away[order] < ROUGHLY + reach[order]].tolist():
            if len(chosen) < rule.tries and all(abs(i - other) > 2 * rule.around for other in chosen):
                chosen.append(i)
        return [(i, float(reach[i])) for i in chosen]

    def _search_closure(self, i: int, reach: float) -> LoopClosure | None:
        """Search the newest scans around key pose i, and judge what is found; None where nothing is."""
        rule, j = self._settings, len(self.T_map_keys) - 1
        old = self._join_clouds(i, max(0, i - rule.around), min(i + rule.around, j - rule.min_gap // 2)).thin(THIN_MAP)
        new = self._join_clouds(j, max(0, j - rule.behind + 1), j).thin(THIN_SCANS)
        if min(len(old), len(new)) < MIN_POINTS:
            return None
        expected = relative(self.T_map_keys[i], self.T_map_keys[j])
        window = SearchWindow(reach, min(LEAST_TURN + TURN_PER_METRE * reach, MOST_TURN))
        try:
            match = match_clouds(old, new, expected, matching=rule.matching, window=window)
        except (IcpError, InvalidCloudError):
            return None
        if match.overlap < rule.loop_overlap:
            return LoopClosure(i, j, match, np.inf, APART)
        gap = subtract_poses(match.T_a_b, expected)
        apart = squared_disagreement(gap, np.zeros((3, 3)), match.information)
        if apart > rule.gate:  # more than the match alone can err: how far may odometry have drifted?
            covariance = relative_covariance(self.graph(), np.array(self.T_map_keys), i, j)
            apart = squared_disagreement(gap, covariance, match.information)
        return LoopClosure(i, j, match, apart, CONTRADICTED if apart > rule.gate else "")

    def _join_clouds(self, key: int, first: int, last: int) -> LineCloud:
        """The clouds of key poses first to last, in the frame of one of them."""
        T_map_key = self.T_map_keys[key]
        return LineCloud.join(
            [self.clouds[k].transform(relative(T_map_key, self.T_map_keys[k])) for k in range(first, last + 1)]
        )

    def _closure_squared_error(self, closure: LoopClosure) -> float:
        """The squared error of a closure as the poses now stand."""
        gap = subtract_poses(closure.match.T_a_b, relative(self.T_map_keys[closure.i], self.T_map_keys[closure.j]))
        return float(gap @ closure.match.information @ gap)
