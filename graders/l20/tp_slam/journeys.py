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
from reference.se2 import compose, relative

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
    clouds = [cloud(scan, REACH, -np.pi / 2.0, np.pi) for scan in ranges]
    return Indoor(clouds, truth, _drifting(truth, rng), _loops(truth, rng))


def cloud(scan: Floats, reach: float = parcours.REACH, first: float = 0.0, turn: float = 2.0 * np.pi) -> Floats:
    """The points (m, 2) that a scan has seen, in the robot's frame; its rays share out `turn`, from `first` on."""
    angles = first + turn * np.arange(len(scan)) / len(scan)
    return np.asarray(np.column_stack([scan * np.cos(angles), scan * np.sin(angles)])[scan < reach])


def _drifting(truth: Floats, rng: np.random.Generator) -> Floats:
    poses = [np.zeros(3)]
    for k in range(len(truth) - 1):
        step = relative(truth[k], truth[k + 1])
        missed = rng.normal(0.0, NOISE) + np.array([STRETCH, 0.0, PULL]) * step[0]
        poses.append(compose(poses[-1], step + missed))
    return np.array(poses)


def _loops(truth: Floats, rng: np.random.Generator) -> list[tuple[int, int, Floats]]:
    pairs = [(a, b) for b in range(len(truth)) for a in range(b - LOOP_GAP) if _alike(relative(truth[a], truth[b]))]
    kept = pairs[:: max(1, len(pairs) // MOST_LOOPS)][:MOST_LOOPS]
    return [(a, b, relative(truth[a], truth[b]) + rng.normal(0.0, GUESS)) for a, b in kept]


def _alike(z: Floats) -> bool:
    return bool(np.hypot(z[0], z[1]) < LOOP_DISTANCE and abs(z[2]) < LOOP_TURN)
