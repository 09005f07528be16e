"""The whole front end, as it reads: follow the scans, keep key poses, close loops, settle_closures, draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.front_end.mapper import LoopClosure, Mapper
from reference.front_end.settings import FrontEndError, FrontEndSettings
from reference.front_end.tracker import TrackedScan, Tracker
from reference.occupancy import InverseSensorModel, OccupancyGrid, build_map
from reference.pose_graph import PoseGraph
from reference.registration import LineCloud
from reference.se2 import Floats, Pose, compose, relative
from reference.world.scan import Scan

IDENTITY = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class SlamResult:
    """What came out: the poses `T_map_robot` (n, 3) of all scans, and the occupancy `grid`.

    `keys` (k,): the scans that are key poses, the nodes of `graph`. `links` (k - 1): how each key pose was tracked from
    the one before; `closures` join one to the past; `refused` were looked at and do not count. `bias` (2, 3): what the
    odometry was found to miss, in (x, y, theta), a metre ahead and a radian turned. `chi2`: the squared error of the
    finished graph.
    """

    T_map_robot: Floats
    keys: NDArray[np.int64]
    graph: PoseGraph
    links: tuple[TrackedScan, ...]
    closures: tuple[LoopClosure, ...]
    refused: tuple[LoopClosure, ...]
    bias: Floats
    chi2: float
    grid: OccupancyGrid


def slam(
    scans: Sequence[Scan],
    T_odom_robot: ArrayLike,
    *,
    T_robot_laser: ArrayLike = IDENTITY,
    start: ArrayLike = IDENTITY,
    settings: FrontEndSettings | None = None,
    resolution: float = 0.05,
) -> SlamResult:
    """The trajectory and the map of n `scans`, of a lidar of any field of view that sits at `T_robot_laser`.

    `T_odom_robot` (n, 3): where odometry says that the robot was at each scan; only the steps between count. The map
    is that of the first pose at `start`. Raises FrontEndError.
    """
    rule = settings or FrontEndSettings()
    odometry, mount = _check_journey(scans, T_odom_robot), _check_pose("T_robot_laser", T_robot_laser)
    clouds = [LineCloud.from_scan(scan, mount) for scan in scans]
    tracker, mapper = Tracker(rule), Mapper(rule, _check_pose("start", start), clouds[0])
    tracker.set_submap(mapper.T_map_keys, mapper.clouds)
    keys, T_key_robot = [0], [np.zeros(3)]
    for k in range(1, len(scans)):
        tracked = tracker.track(clouds[k], relative(odometry[k - 1], odometry[k]))
        if _is_key_pose(tracked, rule):
            mapper.add(clouds[k], tracked)
            tracker.restart()
            tracker.set_submap(mapper.T_map_keys, mapper.clouds)
            keys.append(k)
        T_key_robot.append(tracker.T_key_robot)
    mapper.settle_closures()
    T_map_robot = _poses_from_key_poses(np.array(keys), np.array(T_key_robot), np.array(mapper.T_map_keys))
    T_map_laser = np.array([compose(pose, mount) for pose in T_map_robot])
    grid = build_map(scans, T_map_laser, resolution, model=InverseSensorModel(once_a_scan=True))
    parts = (tuple(mapper.links), tuple(mapper.closures), tuple(mapper.refused))
    return SlamResult(T_map_robot, np.array(keys), mapper.graph(), *parts, tracker.bias.shares, mapper.chi2(), grid)


def _is_key_pose(tracked: TrackedScan, rule: FrontEndSettings) -> bool:
    """Is the robot so far from the last key pose, or sees so much that is new, that it needs another?"""
    x, y, turn = tracked.T_key_robot.tolist()
    seen = 1.0 if tracked.match is None else tracked.match.overlap
    return bool(np.hypot(x, y) >= rule.key_distance or abs(turn) >= rule.key_turn or seen < rule.key_overlap)


def _poses_from_key_poses(keys: NDArray[np.int64], T_key_robot: Floats, T_map_keys: Floats) -> Floats:
    """All poses (n, 3): each from the last key pose before it, as it was tracked."""
    last = np.searchsorted(keys, np.arange(len(T_key_robot)), side="right") - 1
    return compose(T_map_keys[last], T_key_robot)


def _check_journey(scans: Sequence[Scan], T_odom_robot: ArrayLike) -> Floats:
    odometry = np.asarray(T_odom_robot, dtype=np.float64)
    if len(scans) < 2:
        raise FrontEndError("scans", "are fewer than two: nothing was travelled")
    if odometry.shape != (len(scans), 3) or not np.all(np.isfinite(odometry)):
        raise FrontEndError("T_odom_robot", f"of shape {odometry.shape} are not finite poses ({len(scans)}, 3)")
    return odometry


def _check_pose(argument: str, pose: ArrayLike) -> Pose:
    values = np.array(pose, dtype=np.float64)
    if values.shape != (3,) or not np.all(np.isfinite(values)):
        raise FrontEndError(argument, f"of shape {values.shape} is not a finite pose (x, y, theta)")
    return values
