"""The two journeys of the chain: the simulated one of the practical work, and the beginning of one in a real place.

`intel.npz` holds the 910 scans of a log of the Intel Research Lab in Seattle (recorded by Dirk Hähnel; a data set of
the SLAM benchmark of Freiburg), in whole centimetres, with the poses that the log gives them. Those were found by a
SLAM with a grid map, and stand for the truth: they agree with each other to some centimetres. `odometry` is the
robot's own: behind each FLASER line of the log, the first ODOM line restates its pose, and the following ones carry on
by the wheels alone; the steps that they make from scan to scan are put end to end here. `loops` are the proposals of
`recogniser` for the first 120 scans, which are the journey of the practical work: some of them are false.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Floats
from graders.l20 import parcours
from reference.formats.carmen import beam_angles
from reference.se2 import compose, relative
from reference.world.scan import Scan

LOG = Path(__file__).with_name("intel.npz")
REACH = 20.0
#: Scans of the practical work; the log goes on.
SCANS = 120


@dataclass(frozen=True, eq=False)
class Simulated:
    """`wheels` (n - 1, 2), left then right, and `scans` (n, 180), in metres; `truth` (n, 3) from the first pose."""

    wheels: Floats
    scans: Floats
    truth: Floats


@dataclass(frozen=True, eq=False)
class Indoor:
    """`clouds`: the points (m, 2) of each scan, in its robot's frame; `truth`, `odometry` (k, 3) from the first pose.

    `loops`: pairs (a, b) that may see the same walls, with a guess of the pose of b in the frame of a.
    """

    clouds: Sequence[Floats]
    truth: Floats
    odometry: Floats
    loops: Sequence[tuple[int, int, Floats]]


@dataclass(frozen=True, eq=False)
class Matched:
    """What the course's own functions make of the real scans, to be shown without their seconds of work.

    `first` and `matches`, (k - 1, 3): each scan on the one before, from the robot's odometry, and once it is
    calibrated. `closures` (l, 3): the loops' poses of b in the frame of a, and `shares` (l,) of the points that agree.
    """

    first: Floats
    matches: Floats
    closures: Floats
    shares: Floats


@dataclass(frozen=True, eq=False)
class Whole:
    """The whole log. `clouds`, `truth` (n, 3) as `Indoor` has them; `mapped` (n, 3): what the front end of `reference`
    makes of the scans and the robot's odometry, with default settings. `closures` (c, 2): pairs of scans it closed.
    """

    clouds: Sequence[Floats]
    truth: Floats
    mapped: Floats
    closures: NDArray[np.int64]


@cache
def simulated() -> Simulated:
    run = parcours.journey()
    return Simulated(run.wheels, run.ranges, relative(run.truth[0], run.truth))


@cache
def indoor() -> Indoor:
    with np.load(LOG) as log:
        ranges, poses = log["centimetres"][:SCANS] / 100.0, np.asarray(log["poses"][:SCANS], dtype=np.float64)
        odometry = np.asarray(log["odometry"][:SCANS], dtype=np.float64)
        loops = [(int(a), int(b), np.array(guess)) for a, b, *guess in log["loops"].tolist()]
    clouds = [Scan.from_sensor(scan, beam_angles(len(scan)), REACH).points() for scan in ranges]
    return Indoor(clouds, relative(poses[0], poses), odometry, loops)


@cache
def matched_indoor() -> Matched:
    with np.load(LOG) as log:
        closures = np.asarray(log["closures"], dtype=np.float64)
        first, matches = (np.asarray(log[name], dtype=np.float64) for name in ("first", "matches"))
    return Matched(first, matches, closures[:, :3], closures[:, 3])


@cache
def whole_log() -> Whole:
    with np.load(LOG) as log:
        ranges, poses = log["centimetres"] / 100.0, np.asarray(log["poses"], dtype=np.float64)
        mapped = np.asarray(log["mapped"], dtype=np.float64)
        closures = np.asarray(log["mapped_closures"], dtype=np.int64)
    clouds = [Scan.from_sensor(scan, beam_angles(len(scan)), REACH).points() for scan in ranges]
    return Whole(clouds, relative(poses[0], poses), mapped, closures)


def cloud(scan: Floats) -> Floats:
    """The points (m, 2) that a scan of the simulated journey has seen, in the robot's frame."""
    return Scan.full_turn(scan, parcours.REACH).points()


def added_up(steps: Sequence[Floats] | Floats) -> Floats:
    """The poses (k, 3) that relative poses (k - 1, 3) come to, from the zero pose."""
    poses = [np.zeros(3)]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)
