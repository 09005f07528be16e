"""The real scans that an exercise carries are those of the log that they are said to come from."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from graders.l20.tp_slam import journeys
from reference.formats.carmen import beam_angles, parse_flaser
from reference.front_end import slam
from reference.metrics import absolute_trajectory_error
from reference.se2 import relative
from reference.world.scan import Scan


def test_the_excerpt_is_that_of_the_log(dataset: Callable[[str], bytes]) -> None:
    log = parse_flaser(dataset("laser/intel.gfs.log").decode(), 1000.0)
    with np.load(journeys.LOG) as kept:
        ranges, poses = kept["centimetres"] / 100.0, kept["poses"]
    np.testing.assert_allclose(poses, log.T_world_laser[: len(poses)], atol=1e-12)
    assert len(poses) == len(log) == 910
    np.testing.assert_allclose(ranges, [scan.ranges for scan in log.scans[: len(ranges)]], atol=0.0051)


def test_the_odometry_is_what_the_log_counts_from_scan_to_scan(dataset: Callable[[str], bytes]) -> None:
    """The first ODOM line behind a FLASER line restates its pose; those that follow carry on by the wheels."""
    steps, counted = [], []
    for line in dataset("laser/intel.gfs.log").decode().splitlines():
        words = line.split()
        if words[0] == "ODOM":
            counted.append([float(word) for word in words[1:4]])
        elif words[0] == "FLASER":
            if steps or counted[0] != [0.0, 0.0, 0.0]:
                steps.append(relative(counted[0], counted[-1]))
            counted = []
    with np.load(journeys.LOG) as kept:
        found = relative(kept["odometry"][:-1], kept["odometry"][1:])
    assert len(found) == 909
    np.testing.assert_allclose(found, steps, atol=3e-5)


@pytest.mark.slow
def test_the_poses_that_are_shown_are_those_of_our_front_end() -> None:
    """Some minutes, with default settings; to within what its tuning may change."""
    log = journeys.whole_log()
    with np.load(journeys.LOG) as kept:
        ranges, odometry = kept["centimetres"] / 100.0, kept["odometry"]
    scans = [Scan.from_sensor(row, beam_angles(180), 40.0) for row in ranges]
    found = slam(scans, odometry, resolution=0.1)
    assert absolute_trajectory_error(found.T_map_robot, log.mapped).rmse < 0.1
    assert absolute_trajectory_error(log.truth, log.mapped).rmse == pytest.approx(0.09, abs=0.01)
