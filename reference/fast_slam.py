"""FastSLAM: particles carry a trajectory each, and every particle a map of its own, one small Kalman filter a landmark.

Given the trajectory, landmarks do not depend on each other: the posterior factors into that of the trajectory, which
particles represent, and of each landmark, a Gaussian (2,), (2, 2) in each particle (Rao-Blackwell). Which landmark a
sighting is of is known; see `data_association` where it is not.

FastSLAM 1.0 moves the particles by odometry, and then weighs them by what they see. Where the sensor is much better
than odometry, nearly all of them are moved to no purpose. FastSLAM 2.0 moves them by what they see as well: the noise w
of the control (2,), drawn in 1.0 from N(0, M), is drawn from N(m, C), what a Kalman filter makes of N(0, M) by

    z = h(f(x, u, w), l),   linearised at m:   S = (H_x V) C (H_x V)' + H_l P_l H_l' + R                        (1)
    K = C (H_x V)' S^-1,    m <- m + K (z - h),    C <- C - K S K'                                              (2)

one sighting after the other, and its weight is multiplied by N(z - h; 0, S). Written for w and not for the pose, it
needs no inverse of the pose's covariance, which has rank two at most.

Sources: Montemerlo, Thrun, Koller, Wegbreit, "FastSLAM: A Factored Solution to the Simultaneous Localization and
Mapping Problem" (2002), and "FastSLAM 2.0" (2003).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.ekf_slam import SlamNoise
from reference.errors import InvalidArgumentError, check_choice
from reference.filters.resampling import effective_sample_size, systematic_resampling
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Version = Literal["1.0", "2.0"]


class FastSlam:
    """n `particles` that start at one `pose` (3,), which fixes the frame.

    `poses` (n, 3); `means` (n, l, 2) and `covariances` (n, l, 2, 2) of the l landmarks in the order they were first
    seen, `ranks` by identity; `log_weights` (n,), the greatest of which is 0. When fewer than `least_share` of the
    particles still count, they are drawn anew. Raises InvalidArgumentError.
    """

    def __init__(
        self,
        noise: SlamNoise,
        particles: int,
        rng: np.random.Generator,
        *,
        version: Version = "2.0",
        pose: ArrayLike = (0.0, 0.0, 0.0),
        least_share: float = 0.5,
    ) -> None:
        check_choice("version", version, Version)
        if particles < 1:
            raise InvalidArgumentError("particles", f"{particles} carry no belief")
        start = np.asarray(pose, dtype=np.float64)
        if start.shape != (3,) or not np.all(np.isfinite(start)):
            raise InvalidArgumentError("pose", f"of shape {start.shape} is not a finite pose (3,)")
        if not 0.0 <= least_share <= 1.0:
            raise InvalidArgumentError("least_share", f"{least_share} is no share")
        self.noise, self.version, self.least_share, self._rng = noise, version, least_share, rng
        self.poses = np.tile(start, (particles, 1))
        self.means, self.covariances = np.zeros((particles, 0, 2)), np.zeros((particles, 0, 2, 2))
        self.log_weights = np.zeros(particles)
        self.ranks: dict[int, int] = {}
        self.log_evidence = 0.0

    @property
    def weights(self) -> Floats:
        """Of the particles (n,), their sum being one."""
        raw = np.exp(self.log_weights - self.log_weights.max())
        return np.asarray(raw / raw.sum())

    @property
    def pose(self) -> Floats:
        """The mean (3,) of the particles' poses, headings as directions."""
        w = self.weights
        heading = np.arctan2(w @ np.sin(self.poses[:, 2]), w @ np.cos(self.poses[:, 2]))
        return np.array([*(w @ self.poses[:, :2]).tolist(), float(heading)])

    def landmark_position(self, identity: int) -> Floats:
        """Where a landmark (2,) is on average. Raises InvalidArgumentError for one never seen."""
        if identity not in self.ranks:
            raise InvalidArgumentError("identity", f"{identity} was never seen")
        return np.asarray(self.weights @ self.means[:, self.ranks[identity]])

    def step(self, control: ArrayLike, sightings: Mapping[int, ArrayLike]) -> None:
        """Move by (advance, turn), see (range, bearing) of landmarks by identity, and resample where it is needed.

        `log_evidence` becomes that of the sightings of landmarks known before. Raises InvalidArgumentError.
        """
        u = _check_pair("control", control)
        seen = {identity: _check_sighting(z) for identity, z in sightings.items()}
        known = {self.ranks[identity]: z for identity, z in seen.items() if identity in self.ranks}
        before = self.weights
        gains = self._move_by_odometry_and_sightings(u, known) if self.version == "2.0" else self._move_by_odometry(u)
        for rank, z in known.items():
            evidence = self._correct_landmark(rank, z)
            if self.version == "1.0":
                gains += evidence
        for identity, z in seen.items():
            if identity not in self.ranks:
                self._add_landmark(identity, z)
        top = float(gains.max())
        self.log_evidence = top + float(np.log(before @ np.exp(gains - top)))
        self.log_weights += gains
        self.log_weights -= self.log_weights.max()
        if effective_sample_size(self.weights) < self.least_share * len(self.poses):
            self._resample_particles()

    def _move_by_odometry(self, u: Floats) -> Floats:
        """By odometry alone: every particle draws its own noise, and gains nothing yet (n,)."""
        drawn = self._rng.normal(size=(len(self.poses), 2)) * [self.noise.advance, self.noise.turn]
        self.poses = move_poses(self.poses, u + drawn)
        return np.zeros(len(self.poses))

    def _move_by_odometry_and_sightings(self, u: Floats, known: Mapping[int, Floats]) -> Floats:
        """By odometry and the sightings of known landmarks, (1) and (2): the logarithms (n,) of what particles gain."""
        n = len(self.poses)
        m, C, gains = np.zeros((n, 2)), np.tile(self.noise.motion_covariance, (n, 1, 1)), np.zeros(n)
        for rank, z in known.items():
            there = move_poses(self.poses, u + m)
            expected, by_pose, by_landmark = _expected_sightings_and_jacobians(there, self.means[:, rank])
            by_noise = by_pose @ _motion_noise_jacobians(self.poses, u + m)
            away = z - expected
            away[:, 1] = wrap_angle(away[:, 1])
            own = by_landmark @ self.covariances[:, rank] @ _transpose(by_landmark) + self.noise.sighting_covariance
            S = by_noise @ C @ _transpose(by_noise) + own
            K = C @ _transpose(by_noise) @ np.linalg.inv(S)
            gains += _log_normal_density(away, S)
            m = m + np.einsum("nij,nj->ni", K, away)
            C = C - K @ S @ _transpose(K)
        drawn = np.einsum("nij,nj->ni", _matrix_square_roots(C), self._rng.normal(size=(n, 2)))
        self.poses = move_poses(self.poses, u + m + drawn)
        return gains

    def _correct_landmark(self, rank: int, z: Floats) -> Floats:
        """Correct one landmark in every particle; the logarithms (n,) of the evidence, the poses taken for sure."""
        expected, _, H = _expected_sightings_and_jacobians(self.poses, self.means[:, rank])
        P = self.covariances[:, rank]
        away = z - expected
        away[:, 1] = wrap_angle(away[:, 1])
        S = H @ P @ _transpose(H) + self.noise.sighting_covariance
        K = P @ _transpose(H) @ np.linalg.inv(S)
        self.means[:, rank] += np.einsum("nij,nj->ni", K, away)
        self.covariances[:, rank] = P - K @ S @ _transpose(K)
        return _log_normal_density(away, S)

    def _add_landmark(self, identity: int, z: Floats) -> None:
        """l = (x + r cos(t + b), y + r sin(t + b)), and its covariance from that of the sighting alone."""
        heading = self.poses[:, 2] + z[1]
        c, s = np.cos(heading), np.sin(heading)
        by_z = np.stack([np.stack([c, -z[0] * s], axis=-1), np.stack([s, z[0] * c], axis=-1)], axis=-2)
        place = self.poses[:, :2] + z[0] * np.column_stack([c, s])
        self.ranks[identity] = self.means.shape[1]
        self.means = np.concatenate([self.means, place[:, None]], axis=1)
        own = by_z @ self.noise.sighting_covariance @ _transpose(by_z)
        self.covariances = np.concatenate([self.covariances, own[:, None]], axis=1)

    def _resample_particles(self) -> None:
        kept = systematic_resampling(self.weights, self._rng).ancestors
        self.poses, self.means, self.covariances = self.poses[kept], self.means[kept], self.covariances[kept]
        self.log_weights = np.zeros(len(kept))


def move_poses(poses: Floats, controls: Floats) -> Floats:
    """The poses (n, 3) after the controls (n, 2) = (advance, turn), the heading taken half-way through the turn."""
    middle = poses[:, 2] + 0.5 * controls[:, 1]
    x, y = poses[:, 0] + controls[:, 0] * np.cos(middle), poses[:, 1] + controls[:, 0] * np.sin(middle)
    return np.column_stack([x, y, wrap_angle(poses[:, 2] + controls[:, 1])])


def _motion_noise_jacobians(poses: Floats, controls: Floats) -> Floats:
    """V, the derivatives (n, 3, 2) of `move_poses` by the control."""
    middle = poses[:, 2] + 0.5 * controls[:, 1]
    c, s, advance = np.cos(middle), np.sin(middle), controls[:, 0]
    rows = [[c, -0.5 * advance * s], [s, 0.5 * advance * c], [np.zeros_like(c), np.ones_like(c)]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _expected_sightings_and_jacobians(poses: Floats, landmarks: Floats) -> tuple[Floats, Floats, Floats]:
    """Range and bearing (n, 2) of one landmark in each particle, and their derivatives by pose and by landmark."""
    dx, dy = (landmarks - poses[:, :2]).T
    q = dx**2 + dy**2
    if not np.all(q > 0.0):
        raise InvalidArgumentError("sightings", "are of a landmark where the robot stands: it has no bearing")
    r, none = np.sqrt(q), np.zeros_like(q)
    by_landmark = np.stack([np.stack([dx / r, dy / r], axis=-1), np.stack([-dy / q, dx / q], axis=-1)], axis=-2)
    by_heading = np.stack([none, none - 1.0], axis=-1)[:, :, None]
    expected = np.column_stack([r, np.arctan2(dy, dx) - poses[:, 2]])
    return expected, np.concatenate([-by_landmark, by_heading], axis=2), by_landmark


def _log_normal_density(away: Floats, S: Floats) -> Floats:
    """log N(away; 0, S), (n,)."""
    squares = np.einsum("ni,nij,nj->n", away, np.linalg.inv(S), away)
    return np.asarray(-0.5 * (squares + np.linalg.slogdet(S)[1]) - np.log(2.0 * np.pi))


def _matrix_square_roots(C: Floats) -> Floats:
    """Matrices (n, 2, 2) whose squares are the covariances: these may have lost a rank, where noise has none."""
    values, vectors = np.linalg.eigh(C)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :])


def _transpose(matrices: Floats) -> Floats:
    return np.swapaxes(matrices, -1, -2)


def _check_pair(argument: str, values: ArrayLike) -> Floats:
    pair = np.asarray(values, dtype=np.float64)
    if pair.shape != (2,) or not np.all(np.isfinite(pair)):
        raise InvalidArgumentError(argument, f"of shape {pair.shape} is not an array (2,) of finite numbers")
    return pair


def _check_sighting(values: ArrayLike) -> Floats:
    z = _check_pair("sightings", values)
    if not z[0] > 0.0:
        raise InvalidArgumentError("sightings", f"hold a range of {z[0]}")
    return z
