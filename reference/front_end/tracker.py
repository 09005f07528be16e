"""Tracking: each scan is laid on the key scans just before it, from where odometry expects it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reference.front_end.odometry import OdometryBias, fuse_poses, squared_disagreement, subtract_poses
from reference.front_end.settings import FrontEndSettings
from reference.registration import IcpError, InvalidCloudError, LineCloud, ScanMatch, SearchWindow, match_clouds
from reference.registration.scan_matching import MIN_POINTS
from reference.se2 import Floats, Pose, compose, compose_covariance, relative

SURE = 3.0
#: The share of the points that a match must lay near a wall: little where it lands as odometry expects it, since few
#: walls are seen from both sides of a corner; much where it has slid out of the window of its search, by ASTRAY times
#: what was searched. With fewer, it has found other walls; with more, the wheels have slipped.
AGREEING, CERTAIN, ASTRAY = 0.3, 0.8, 1.5


@dataclass(frozen=True, eq=False)
class TrackedScan:
    """Where a scan was taken, `T_key_robot` (3,), and the `information` (3, 3) of it, odometry included.

    `match`: that with the scans before; None where they did not help.
    """

    T_key_robot: Pose
    information: Floats
    match: ScanMatch | None


class Tracker:
    """The robot since the last key pose: `T_key_robot`, and the `covariance` that odometry alone has added up since."""

    def __init__(self, settings: FrontEndSettings) -> None:
        self.bias = OdometryBias()
        self._settings = settings
        self._submap: LineCloud | None = None
        self.restart()

    def restart(self) -> None:
        """The robot stands on a key pose, the newest one."""
        self.T_key_robot, self.covariance = np.zeros(3), np.zeros((3, 3))

    def set_submap(self, T_map_keys: Sequence[Pose], clouds: Sequence[LineCloud]) -> None:
        """Lay the clouds of the newest key poses together, in the frame of the last of them: what scans are laid on."""
        key = T_map_keys[-1]
        near = zip(T_map_keys[-self._settings.recent :], clouds[-self._settings.recent :], strict=True)
        self._submap = LineCloud.join([cloud.transform(relative(key, pose)) for pose, cloud in near])

    def track(self, cloud: LineCloud, wheels: Pose) -> TrackedScan:
        """Move by a step (3,) of the wheels, and correct it by what is seen there."""
        before, step = self.T_key_robot, self.bias.remove_bias(wheels)
        noise = self._settings.noise.covariance(step)
        expected = compose(before, step)
        match = self._match_with_submap(cloud, expected, noise)
        if match is None:
            self.covariance = compose_covariance(before, self.covariance, step, noise)
            self.T_key_robot = expected
            return TrackedScan(expected, _invert_matrix(self.covariance), None)
        apart = squared_disagreement(subtract_poses(match.T_a_b, expected), noise, match.information)
        # Wheels that slip are believed the less, the more the scans contradict them.
        slipped = noise * max(1.0, apart / self._settings.gate)
        self.covariance = compose_covariance(before, self.covariance, step, slipped)
        self.T_key_robot = fuse_poses(expected, self.covariance, match.T_a_b, match.information)
        if not match.is_degenerate and apart <= self._settings.gate:
            self.bias.learn(wheels, relative(before, self.T_key_robot))
        return TrackedScan(self.T_key_robot, match.information + _invert_matrix(self.covariance), match)

    def _match_with_submap(self, cloud: LineCloud, expected: Pose, noise: Floats) -> ScanMatch | None:
        """The match of a cloud with the submap; None where too little of it lies near."""
        rule = self._settings
        sigma, turn_sigma = float(noise[0, 0] ** 0.5), float(noise[2, 2] ** 0.5)
        reach, turn = max(rule.reach, SURE * sigma), max(rule.turn, SURE * turn_sigma)
        window = SearchWindow(reach, turn, sigma=sigma, turn_sigma=turn_sigma)
        if self._submap is None or min(len(cloud), len(self._submap)) < MIN_POINTS:
            return None
        try:
            match = match_clouds(self._submap, cloud, expected, matching=rule.matching, window=window)
        except (IcpError, InvalidCloudError):
            return None
        gap = subtract_poses(match.T_a_b, expected)
        needed = rule.link_overlap
        if squared_disagreement(gap, noise, match.information) <= rule.gate:
            needed = min(AGREEING, needed)
        elif np.hypot(gap[0], gap[1]) > ASTRAY * reach or abs(gap[2]) > ASTRAY * turn:
            needed = max(CERTAIN, needed)
        return match if match.overlap >= needed else None


def _invert_matrix(matrix: Floats) -> Floats:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
