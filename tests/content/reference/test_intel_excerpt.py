"""The real scans that an exercise carries are those of the log that they are said to come from."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graders.l20.tp_slam import journeys
from reference.formats.carmen import parse_flaser


def test_the_excerpt_is_that_of_the_log(dataset: Callable[[str], bytes]) -> None:
    log = parse_flaser(dataset("laser/intel.gfs.log").decode(), 1000.0)
    with np.load(journeys.LOG) as kept:
        ranges, poses = kept["centimetres"] / 100.0, kept["poses"]
    np.testing.assert_allclose(poses, log.T_world_laser[: len(poses)], atol=1e-12)
    np.testing.assert_allclose(ranges, [scan.ranges for scan in log.scans[: len(ranges)]], atol=0.0051)
