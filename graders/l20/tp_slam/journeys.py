"""The two journeys of the chain: the simulated one of the practical work, and the beginning of one in a real place.

`intel.npz` holds the first 120 scans of the log of the Intel Research Lab in Seattle (recorded by Dirk Hähnel; a data
set of the SLAM benchmark of Freiburg), in whole centimetres, with the poses that the log gives them. Those were found
by a SLAM with a grid map, and stand for the truth: they agree with each other to some centimetres. The log keeps no
odometry; `indoor` makes one that drifts. A lidar of half a turn knows no place from behind: which key poses see
the same walls is given, with a rough guess, as a place recogniser would.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from graders.core.contract.values import Floats
from graders.l20 import parcours
from reference.formats.carmen import beam_angles
from reference.se2 import compose, relative
from reference.world.scan import Scan

LOG = Path(__file__).with_name("intel.npz")
SEED = 20
#: What odometry is made to miss between two scans: noise along, across and in heading, then shares of the motion.
NOISE = (0.05, 0.025, 0.03)
STRETCH, PULL = 0.02, 0.01
GUESS = (0.1, 0.1, 0.05)
REACH = 20.0
MOST_LOOPS = 30
LOOP_GAP, LOOP_DISTANCE, LOOP_TURN = 20, 1.0, 0.5


@dataclass(frozen=True, eq=False)
class Simulated:
    """`wheels` (n - 1, 2), left then right, and `scans` (n, 180), in metres; `truth` (n, 3) from the first pose."""

    wheels: Floats
    scans: Floats
    truth: Floats


@dataclass(frozen=True, eq=False)
class Indoor:
    """`clouds`: the points (m, 2) of each scan, in its robot's frame; `truth`, `odometry` (k, 3) from the first pose.

    `loops`: pairs (a, b) that see the same walls, with a guess of the pose of b in the frame of a.
    """

    clouds: Sequence[Floats]
    truth: Floats
    odometry: Floats
    loops: Sequence[tuple[int, int, Floats]]


@cache
def simulated() -> Simulated:
    run = parcours.journey()
    return Simulated(run.wheels, run.ranges, relative(run.truth[0], run.truth))


@cache
def indoor() -> Indoor:
    with np.load(LOG) as log:
        ranges, poses = log["centimetres"] / 100.0, np.asarray(log["poses"], dtype=np.float64)
    rng = np.random.default_rng(SEED)
    truth = relative(poses[0], poses)
    clouds = [Scan.from_sensor(scan, beam_angles(len(scan)), REACH).points() for scan in ranges]
    return Indoor(clouds, truth, _drifting(truth, rng), _loops(truth, rng))


def cloud(scan: Floats) -> Floats:
    """The points (m, 2) that a scan of the simulated journey has seen, in the robot's frame."""
    return Scan.full_turn(scan, parcours.REACH).points()


def added_up(steps: Sequence[Floats] | Floats) -> Floats:
    """The poses (k, 3) that relative poses (k - 1, 3) come to, from the zero pose."""
    poses = [np.zeros(3)]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)


def _drifting(truth: Floats, rng: np.random.Generator) -> Floats:
    steps = []
    for step in relative(truth[:-1], truth[1:]):
        missed = rng.normal(0.0, NOISE) + np.array([STRETCH, 0.0, PULL]) * step[0]
        steps.append(step + missed)
    return added_up(steps)


def _loops(truth: Floats, rng: np.random.Generator) -> list[tuple[int, int, Floats]]:
    pairs = [(a, b) for b in range(len(truth)) for a in range(b - LOOP_GAP) if _alike(relative(truth[a], truth[b]))]
    kept = pairs[:: max(1, len(pairs) // MOST_LOOPS)][:MOST_LOOPS]
    return [(a, b, relative(truth[a], truth[b]) + rng.normal(0.0, GUESS)) for a, b in kept]


def _alike(z: Floats) -> bool:
    return bool(np.hypot(z[0], z[1]) < LOOP_DISTANCE and abs(z[2]) < LOOP_TURN)
