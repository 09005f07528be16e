"""What wheels are believed: a step and its covariance, after a bias that is learned from the steps that scans confirm.

A robot pulls to one side, runs on worn wheels, carries its lidar before its axle: errors that repeat, and can be told
from a few dozen steps. Each component of the error of a step is a share of its distance and one of its turn,

    T_matched - T_wheels = (dx, dtheta) B + noise,    B (2, 3)                                                (1)

found by least squares with a prior that B is small, one step after another.

Source: Roy and Thrun, "Online Self-Calibration for Mobile Robots" (1999).
"""

from __future__ import annotations

import numpy as np

from reference.se2 import Floats, Pose, wrap_angle

BELIEVED_BIAS = 0.1
BELIEVED_NOISE = 0.03


class OdometryBias:
    """The bias B of (1) as it is learned; `shares` (2, 3)."""

    def __init__(self) -> None:
        self._normal = np.eye(2) * (BELIEVED_NOISE / BELIEVED_BIAS) ** 2
        self._right = np.zeros((2, 3))
        self.shares: Floats = np.zeros((2, 3))

    def remove_bias(self, step: Pose) -> Pose:
        """The step (3,) of the wheels without its bias."""
        better = step + step[[0, 2]] @ self.shares
        better[2] = wrap_angle(float(better[2]))
        return better

    def learn(self, step: Pose, T_matched: Pose) -> None:
        """Take a step of the wheels into account, and what it was by the scans."""
        told, error = step[[0, 2]], subtract_poses(T_matched, step)
        self._normal += np.outer(told, told)
        self._right += np.outer(told, error)
        self.shares = np.asarray(np.linalg.solve(self._normal, self._right), dtype=np.float64)


def subtract_poses(a: Pose, b: Pose) -> Floats:
    """a - b (3,) of poses, by components, the angle in ]-pi, pi]."""
    gap = a - b
    gap[2] = wrap_angle(float(gap[2]))
    return gap


def fuse_poses(T_expected: Pose, covariance: Floats, T_matched: Pose, information: Floats) -> Pose:
    """The pose (3,) of least squares between what was expected and what was matched, which may know only a part."""
    gap = subtract_poses(T_matched, T_expected)
    pose = T_expected + np.linalg.solve(np.eye(3) + covariance @ information, covariance @ (information @ gap))
    pose[2] = wrap_angle(float(pose[2]))
    return pose


def squared_disagreement(gap: Floats, covariance: Floats, information: Floats) -> float:
    """The squared length of a gap (3,) between what was expected, to a covariance, and what a match of some information
    says: g' (P + W^-1)^-1 g, along what the match knows."""
    return float(gap @ information @ np.linalg.solve(np.eye(3) + covariance @ information, gap))
