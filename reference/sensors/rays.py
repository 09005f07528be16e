"""Against overconfidence: the beams of a scan are not independent, and 360 of them must not vote as 360 witnesses.

Two remedies: use few beams, spread evenly; or raise the likelihood to a power below one (tempering), so that n beams
count as power x n. Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), section 6.3.4.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.world.scan import Scan

Floats = NDArray[np.float64]


class ScanLikelihood(Protocol):
    """What weighs particles: log p(scan | pose), (n,), for poses (n, 3) of the lidar in the world, up to a constant."""

    def log_likelihood(self, poses_world: Floats, scan: Scan, /) -> Floats: ...


def thin_scan(scan: Scan, count: int) -> Scan:
    """At most `count` beams of the scan, as evenly spread as whole beams can be. Raises InvalidArgumentError."""
    if count < 1:
        raise InvalidArgumentError("count", f"{count} beams make no scan")
    if count >= len(scan):
        return scan
    return scan.select_beams(np.arange(count) * len(scan) // count)


def check_power(power: float) -> float:
    """The exponent of a tempered likelihood. Raises InvalidArgumentError unless 0 < power <= 1."""
    if not 0.0 < power <= 1.0:
        raise InvalidArgumentError("power", f"{power} is not in ]0, 1]")
    return power


def check_poses(poses_world: Floats, scan: Scan) -> Floats:
    """Poses (n, 3) and a scan that can be weighed. Raises InvalidArgumentError, also for a scan without beams."""
    poses = np.asarray(poses_world, dtype=np.float64)
    if poses.ndim != 2 or poses.shape[1] != 3 or not np.isfinite(poses).all():
        raise InvalidArgumentError("poses_world", f"of shape {poses.shape} is not an array (n, 3) of finite numbers")
    if len(scan) == 0:
        raise InvalidArgumentError("scan", "has no beams")
    return poses
