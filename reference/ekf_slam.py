"""EKF-SLAM: the pose of the robot and the places of landmarks, known together as one Gaussian.

The state is (x, y, theta, l_0x, l_0y, l_1x, …), of dimension N = 3 + 2 n for n landmarks. One sighting touches two
numbers, and H, its Jacobian, has five columns that are not zero. So P H^T costs O(N), S is 2 x 2, and

    P <- (I - K H) P  =  P - (P H^T) S^-1 (P H^T)^T  =  P - W W^T,    W (N, 2) = P H^T L^-T,  S = L L^T        (1)

is a change of rank two: O(N^2) = O(n^2), done in place. The textbook forms I - K H, a full matrix, and multiplies two
matrices (N, N): O(n^3). Both are here, as are a third for the sake of its rounding, that of Joseph.

Sources: Smith, Self, Cheeseman, "Estimating Uncertain Spatial Relationships in Robotics" (1990); Thrun, Burgard, Fox,
"Probabilistic Robotics" (2005), table 10.1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg.blas import dgemm

from reference.errors import InvalidArgumentError
from reference.filters.gaussian import Innovation, joseph_update
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class SlamNoise:
    """Standard deviations: of an advance (metres) and a turn (radians), of a range (metres) and a bearing (radians).

    Raises InvalidArgumentError.
    """

    advance: float
    turn: float
    range: float
    bearing: float

    def __post_init__(self) -> None:
        for argument, value in vars(self).items():
            least = 0.0 if argument in ("advance", "turn") else np.finfo(np.float64).tiny
            if not least <= value < np.inf:
                raise InvalidArgumentError(argument, f"{value} is not a standard deviation")

    @property
    def motion_covariance(self) -> Floats:
        return np.diag([self.advance**2, self.turn**2])

    @property
    def sighting_covariance(self) -> Floats:
        return np.diag([self.range**2, self.bearing**2])


@dataclass(frozen=True, eq=False)
class Sighting:
    """What correcting needs of one sighting: `columns` (5,) of the state that it depends on, `H` (2, 5) there, and the
    innovation."""

    columns: Integers
    H: Floats
    innovation: Innovation


Update = Callable[[Floats, Sighting, Floats], Floats]


def update_covariance_in_place(P: Floats, sighting: Sighting, R: Floats) -> Floats:
    """(1), in place when P (N, N) is in Fortran's order: returns P - W W^T."""
    PHt = P[:, sighting.columns] @ sighting.H.T
    W = np.linalg.solve(np.linalg.cholesky(sighting.innovation.covariance), PHt.T).T
    return np.asarray(dgemm(-1.0, W, W, beta=1.0, c=P, trans_b=True, overwrite_c=True))


def updated_covariance_textbook(P: Floats, sighting: Sighting, R: Floats) -> Floats:
    """(I - K H) P, as it is written: two products of matrices (N, N), O(n^3)."""
    H = full_jacobian(sighting, len(P))
    K = P @ H.T @ np.linalg.inv(sighting.innovation.covariance)
    return np.asarray((np.eye(len(P)) - K @ H) @ P)


def updated_covariance_joseph(P: Floats, sighting: Sighting, R: Floats) -> Floats:
    """(I - K H) P (I - K H)^T + K R K^T: O(n^3) as well, and positive in spite of rounding."""
    H = full_jacobian(sighting, len(P))
    return joseph_update(P, P @ H.T @ np.linalg.inv(sighting.innovation.covariance), H, R)


def full_jacobian(sighting: Sighting, size: int) -> Floats:
    """H with all its columns, (2, size)."""
    H = np.zeros((2, size))
    H[:, sighting.columns] = sighting.H
    return H


class EkfSlam:
    """A map that grows: the robot starts at `pose` (3,), exactly known, which fixes the frame.

    `update` is the form of the covariance's correction. Raises InvalidArgumentError.
    """

    def __init__(
        self, noise: SlamNoise, pose: ArrayLike = (0.0, 0.0, 0.0), update: Update = update_covariance_in_place
    ) -> None:
        self.noise, self.update = noise, update
        self.mean = _check_vector("pose", pose, 3).copy()
        self.covariance: Floats = np.zeros((3, 3), order="F")
        self.slots: dict[int, int] = {}
        self.innovation: Innovation | None = None

    @property
    def pose(self) -> Floats:
        return self.mean[:3].copy()

    def landmark_position(self, identity: int) -> Floats:
        """Where a landmark (2,) is. Raises InvalidArgumentError for one never seen."""
        if identity not in self.slots:
            raise InvalidArgumentError("identity", f"{identity} was never seen")
        slot = self.slots[identity]
        return self.mean[slot : slot + 2].copy()

    def predict(self, control: ArrayLike) -> None:
        """Move by (advance, turn): only the robot's rows and columns of P change, O(n).

        x' = x + s cos(t + r / 2), y' = y + s sin(t + r / 2), t' = t + r                                       (2)
        """
        advance, turn = _check_vector("control", control, 2)
        middle = self.mean[2] + 0.5 * turn
        c, s = np.cos(middle), np.sin(middle)
        F = np.array([[1.0, 0.0, -advance * s], [0.0, 1.0, advance * c], [0.0, 0.0, 1.0]])
        V = np.array([[c, -0.5 * advance * s], [s, 0.5 * advance * c], [0.0, 1.0]])
        self.mean[:3] += [advance * c, advance * s, turn]
        self.mean[2] = wrap_angle(float(self.mean[2]))
        P = self.covariance
        P[:3, 3:] = F @ P[:3, 3:]
        P[3:, :3] = P[:3, 3:].T
        P[:3, :3] = F @ P[:3, :3] @ F.T + V @ self.noise.motion_covariance @ V.T

    def observe(self, identity: int, measurement: ArrayLike) -> float:
        """Take in the (range, bearing) of a landmark: the first time it enters the map, then it corrects.

        Returns the log evidence; 0 for a first sighting, which has nothing to be compared with.
        """
        z = _check_vector("measurement", measurement, 2)
        if not z[0] > 0.0:
            raise InvalidArgumentError("measurement", f"has a range of {z[0]}")
        if identity not in self.slots:
            self._add_landmark(identity, z)
            return 0.0
        return self._correct_with_sighting(self.slots[identity], z)

    def _add_landmark(self, identity: int, z: Floats) -> None:
        """l = (x + r cos(t + b), y + r sin(t + b)): its covariances follow from those of the robot.           (3)"""
        size, heading = self.mean.size, self.mean[2] + z[1]
        ray = np.array([np.cos(heading), np.sin(heading)])
        by_pose = np.array([[1.0, 0.0, -z[0] * ray[1]], [0.0, 1.0, z[0] * ray[0]]])
        by_z = np.array([[ray[0], -z[0] * ray[1]], [ray[1], z[0] * ray[0]]])
        larger = np.empty((size + 2, size + 2), order="F")
        larger[:size, :size] = self.covariance
        larger[size:, :size] = by_pose @ self.covariance[:3]
        larger[:size, size:] = larger[size:, :size].T
        larger[size:, size:] = (
            by_pose @ self.covariance[:3, :3] @ by_pose.T + by_z @ self.noise.sighting_covariance @ by_z.T
        )
        self.slots[identity] = size
        self.mean = np.concatenate([self.mean, self.mean[:2] + z[0] * ray])
        self.covariance = larger

    def _correct_with_sighting(self, slot: int, z: Floats) -> float:
        sighting = self.predict_sighting(slot, z)
        evidence = sighting.innovation.log_density
        PHt = self.covariance[:, sighting.columns] @ sighting.H.T
        self.mean += PHt @ np.linalg.solve(sighting.innovation.covariance, sighting.innovation.difference)
        self.mean[2] = wrap_angle(float(self.mean[2]))
        self.covariance = self.update(self.covariance, sighting, self.noise.sighting_covariance)
        self.innovation = sighting.innovation
        return evidence

    def predict_sighting(self, slot: int, z: Floats) -> Sighting:
        """What was seen, (2,), against what was expected of the landmark at `slot` of the state:

        range sqrt(q), bearing atan2(dy, dx) - t, with (dx, dy) = l - (x, y) and q = dx^2 + dy^2               (4)
        """
        columns = np.array([0, 1, 2, slot, slot + 1])
        dx, dy = self.mean[slot : slot + 2] - self.mean[:2]
        q = dx**2 + dy**2
        if not q > 0.0:
            raise InvalidArgumentError("measurement", "is of a landmark where the robot stands: it has no bearing")
        r = np.sqrt(q)
        expected = np.array([r, np.arctan2(dy, dx) - self.mean[2]])
        H = np.array([[-dx / r, -dy / r, 0.0, dx / r, dy / r], [dy / q, -dx / q, -1.0, -dy / q, dx / q]])
        S = H @ self.covariance[np.ix_(columns, columns)] @ H.T + self.noise.sighting_covariance
        away = z - expected
        away[1] = wrap_angle(float(away[1]))
        return Sighting(columns, H, Innovation(away, S))


def _check_vector(argument: str, values: ArrayLike, size: int) -> Floats:
    vector = np.asarray(values, dtype=np.float64)
    if vector.shape != (size,) or not np.all(np.isfinite(vector)):
        raise InvalidArgumentError(argument, f"of shape {vector.shape} is not an array ({size},) of finite numbers")
    return vector
