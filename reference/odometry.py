"""Odometry of a differential robot: poses by dead reckoning, their covariance, and how far they drift.

Encoders give the path of each wheel over a step, (left, right) in metres; `track` is the distance between the wheels.
Poses (3,) are those of the middle of the axle in the frame where the journey started; covariances (3, 3) are those of
their coordinates (x, y, theta).

Sources: Siegwart, Nourbakhsh, Scaramuzza, "Introduction to Autonomous Mobile Robots" (2011), section 5.2.4; for the
drift of a heading that is a random walk, the derivation is at `LateralDrift`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference import se2
from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]


class OdometryError(InvalidArgumentError):
    """Something that no encoder, robot or journey is; `argument` names it."""


@dataclass(frozen=True)
class Motion:
    """What one step does: `distance` run by the middle of the axle in metres, `turn` in radians."""

    distance: float
    turn: float


@dataclass(frozen=True)
class DifferentialDrive:
    """A robot on two wheels, `track` metres apart.

    The error of a wheel's path ds has variance `sigma`^2 + `sigma_per_root_metre`^2 |ds|: an encoder's grain, and a
    slip that adds up with the distance. Errors of the two wheels and of all steps are independent, and of mean zero.
    Raises OdometryError.
    """

    track: float
    sigma: float = 0.0
    sigma_per_root_metre: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.track < np.inf:
            raise OdometryError("track", f"{self.track} is not a positive length")
        for name in ("sigma", "sigma_per_root_metre"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise OdometryError(name, f"{getattr(self, name)} is not a standard deviation")

    def motion_from_wheels(self, left: float, right: float) -> Motion:
        """ds = (right + left) / 2,  dtheta = (right - left) / track                                           (1)"""
        ds_left, ds_right = _check_wheels([left, right])
        return Motion(float(ds_right + ds_left) / 2.0, float(ds_right - ds_left) / self.track)

    def wheel_paths(self, motion: Motion) -> Floats:
        """The paths (2,) = (left, right) that make a motion: the inverse of (1)."""
        half = motion.turn * self.track / 2.0
        return np.array([motion.distance - half, motion.distance + half])

    def path_deviations(self, wheels: ArrayLike) -> Floats:
        """The standard deviations (…, 2) of the errors of measured paths (…, 2)."""
        return np.sqrt(self.sigma**2 + self.sigma_per_root_metre**2 * np.abs(_check_wheels(wheels)))

    def wheel_covariance(self, left: float, right: float) -> Floats:
        """The covariance (2, 2) of the two measured paths (left, right)."""
        return np.diag(self.path_deviations([left, right]) ** 2)

    def turn_deviation(self, left: float, right: float) -> float:
        """The standard deviation of dtheta over one step: sqrt(s_left^2 + s_right^2) / track, in radians."""
        return float(np.sqrt(np.trace(self.wheel_covariance(left, right)))) / self.track

    def step(self, pose: ArrayLike, left: float, right: float) -> se2.Pose:
        """The pose after one step, by the chord that halves the turn:

        x += ds cos(theta + dtheta / 2),  y += ds sin(theta + dtheta / 2),  theta += dtheta                     (2)
        """
        return se2.compose(pose, self.pose_increment(left, right))

    def pose_increment(self, left: float, right: float) -> se2.Pose:
        """The pose (3,) after one step in the frame before it: (2) from the origin."""
        motion = self.motion_from_wheels(left, right)
        half = motion.turn / 2.0
        return np.array([motion.distance * np.cos(half), motion.distance * np.sin(half), se2.wrap_angle(motion.turn)])

    def step_along_arc(self, pose: ArrayLike, left: float, right: float) -> se2.Pose:
        """The pose after one step along the exact arc of a circle, which both wheels at constant speed follow.

        It differs from (2) by the ratio of arc to chord: a share of dtheta^2 / 24 of the step.
        """
        motion = self.motion_from_wheels(left, right)
        return se2.compose(pose, se2.exp([motion.distance, 0.0, motion.turn]))

    def increment_covariance(self, left: float, right: float) -> Floats:
        """The covariance (3, 3) of `pose_increment`, to first order: G Q G^T, G its Jacobian by (left, right)."""
        motion = self.motion_from_wheels(left, right)
        c, s = np.cos(motion.turn / 2.0), np.sin(motion.turn / 2.0)
        by_motion = np.array([[c, -motion.distance * s / 2.0], [s, motion.distance * c / 2.0], [0.0, 1.0]])
        G = by_motion @ np.array([[0.5, 0.5], [-1.0 / self.track, 1.0 / self.track]])
        return np.asarray(G @ self.wheel_covariance(left, right) @ G.T)


@dataclass(frozen=True, eq=False)
class DeadReckoning:
    """A journey as odometry tells it: `poses` (n + 1, 3) and their `covariances` (n + 1, 3, 3), the start included."""

    poses: Floats
    covariances: Floats


def dead_reckoning(
    drive: DifferentialDrive, wheels: ArrayLike, start: ArrayLike = (0.0, 0.0, 0.0), covariance: ArrayLike | None = None
) -> DeadReckoning:
    """Poses and covariances along the measured paths `wheels` (n, 2), from a start known to `covariance` (or exactly).

    Each step composes the pose with `pose_increment`, so that by (3) of `se2`, to first order,

        S <- J_pose S J_pose^T + J_step S_step J_step^T                                                        (3)

    Raises OdometryError, and PoseError for a start that is no pose.
    """
    paths = _check_journey(wheels)
    poses = [np.asarray(start, dtype=np.float64)]
    covariances = [np.zeros((3, 3)) if covariance is None else np.asarray(covariance, dtype=np.float64)]
    for left, right in paths:
        step, S_step = drive.pose_increment(left, right), drive.increment_covariance(left, right)
        covariances.append(se2.compose_covariance(poses[-1], covariances[-1], step, S_step))
        poses.append(se2.compose(poses[-1], step))
    return DeadReckoning(np.array(poses), np.array(covariances))


def integrate_poses(drive: DifferentialDrive, wheels: ArrayLike, start: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """The poses (…, n + 1, 3) of `dead_reckoning`, without covariances, of one journey (n, 2) or of many (…, n, 2).

    The headings are a cumulative sum; so are then the positions, by (2). Raises OdometryError.
    """
    paths = _check_wheels(wheels)
    if paths.ndim < 2:
        raise OdometryError("wheels", f"has shape {paths.shape}, not (…, n, 2)")
    origin = np.asarray(start, dtype=np.float64)
    distances, turns = paths.sum(axis=-1) / 2.0, (paths[..., 1] - paths[..., 0]) / drive.track
    headings = origin[..., 2] + np.cumulative_sum(turns, axis=-1, include_initial=True)
    middle = headings[..., :-1] + turns / 2.0
    steps = distances[..., None] * np.stack([np.cos(middle), np.sin(middle)], axis=-1)
    places = origin[..., :2] + np.cumulative_sum(steps, axis=-2, include_initial=True)
    return np.concatenate([places, se2.wrap_angle(headings)[..., None]], axis=-1)


@dataclass(frozen=True)
class LateralDrift:
    """Where errors of heading lead after n steps along a straight line; lengths in the unit of `distance`.

    The turns of the steps err by independent e_1 … e_n of standard deviation s (`turn_deviation`), so that the heading
    errs by h_k = e_1 + … + e_k after k steps, a random walk:

        sd(h_n) = s sqrt(n)                                                                                     (4)

    Step k, of length d = D / n, leaves the line by d (h_(k-1) + e_k / 2), for small angles. Error e_j is thus in the
    half of its own step and in all of the n - j that follow, and the position after D is beside the line by

        d sum_j (n - j + 1/2) e_j,  of standard deviation  D s sqrt(n) sqrt(1/3 - 1/(12 n^2))                   (5)

    which is D sd(h_n) / sqrt(3) as n grows: less than 58 % of the pessimistic D sd(h_n), where the heading is
    wrong by one standard deviation from the first step on. That one is no bound: 2 Phi(-sqrt 3), 8 %, lie beyond.
    """

    steps: int
    distance: float
    turn_deviation: float

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise OdometryError("steps", f"{self.steps} steps are no journey")
        for name in ("distance", "turn_deviation"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise OdometryError(name, f"{getattr(self, name)} is not a finite number, zero or more")

    @property
    def heading_deviation(self) -> float:
        """The standard deviation (4) of the heading at the end, in radians."""
        return self.turn_deviation * float(np.sqrt(self.steps))

    @property
    def constant_error_deviation(self) -> float:
        """Lateral deviation if the heading were wrong by `heading_deviation` all along: D sd(h_n), no upper bound."""
        return self.distance * self.heading_deviation

    @property
    def lateral_deviation(self) -> float:
        """The standard deviation (5) of the position beside the line."""
        return self.constant_error_deviation * float(np.sqrt(1.0 / 3.0 - 1.0 / (12.0 * self.steps**2)))


def _check_wheels(wheels: ArrayLike) -> Floats:
    paths = np.asarray(wheels, dtype=np.float64)
    if paths.ndim == 0 or paths.shape[-1] != 2 or not np.all(np.isfinite(paths)):
        raise OdometryError("wheels", f"of shape {paths.shape} are not finite paths (…, 2) = (left, right)")
    return paths


def _check_journey(wheels: ArrayLike) -> Floats:
    paths = _check_wheels(wheels)
    if paths.ndim != 2:
        raise OdometryError("wheels", f"has shape {paths.shape}, not (n, 2)")
    return paths
