"""Trajectories as text: TUM files (one line a pose: time, position, quaternion) and KITTI files (a 3 x 4 matrix).

Formats: TUM RGB-D benchmark, "File formats": `timestamp tx ty tz qx qy qz qw`, in seconds and metres, the quaternion of
norm 1, comments behind #; KITTI odometry benchmark: the 12 numbers of [R | t], row by row. In the plane, z is 0 and the
quaternion is (0, 0, sin(theta / 2), cos(theta / 2)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from reference.errors import InvalidArgumentError
from reference.text import decode_lines

Floats = NDArray[np.float64]

# A text of few digits holds unit quaternions and rotations to about 1e-3.
TOLERANCE = 1e-2


class TrajectoryFileError(InvalidArgumentError):
    """A text or a trajectory that is not one of the format; `argument` names it, and the message gives the line."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """`times` (n,) in seconds, `positions` (n, 3) in metres, and `quaternions` (n, 4) = (x, y, z, w), of norm 1.

    Raises TrajectoryFileError for arrays of other shapes, numbers that are not finite or quaternions far from norm 1;
    near ones are made so.
    """

    times: Floats
    positions: Floats
    quaternions: Floats

    def __post_init__(self) -> None:
        n = np.shape(self.times)[0] if np.ndim(self.times) else 0
        for name, shape in (("times", (n,)), ("positions", (n, 3)), ("quaternions", (n, 4))):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.shape != shape or not np.all(np.isfinite(values)):
                raise TrajectoryFileError(name, f"of shape {values.shape} are not finite numbers {shape}")
            object.__setattr__(self, name, values)
        norms = np.linalg.norm(self.quaternions, axis=1)
        if np.any(np.abs(norms - 1.0) > TOLERANCE):
            raise TrajectoryFileError("quaternions", f"are not of norm 1, at pose {np.argmax(np.abs(norms - 1.0))}")
        object.__setattr__(self, "quaternions", self.quaternions / norms[:, None])

    def __len__(self) -> int:
        return len(self.times)

    @classmethod
    def from_planar(cls, times: ArrayLike, poses: ArrayLike) -> Trajectory:
        """The trajectory of poses (n, 3) = (x, y, theta) at `times` (n,). Raises TrajectoryFileError."""
        rows = np.asarray(poses, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != 3:
            raise TrajectoryFileError("poses", f"has shape {rows.shape}, not (n, 3)")
        zero, half = np.zeros(len(rows)), rows[:, 2] / 2.0
        quaternions = np.column_stack([zero, zero, np.sin(half), np.cos(half)])
        return cls(np.asarray(times, dtype=np.float64), np.column_stack([rows[:, :2], zero]), quaternions)

    def to_planar(self) -> Floats:
        """The poses (n, 3) = (x, y, theta) seen from above: theta in ]-pi, pi] is the direction of the x axis."""
        x, y, z, w = self.quaternions.T
        theta = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return np.column_stack([self.positions[:, :2], np.where(theta == -np.pi, np.pi, theta)])

    def to_matrices(self) -> Floats:
        """The homogeneous matrices (n, 4, 4) of the poses."""
        found = np.tile(np.eye(4), (len(self), 1, 1))
        if len(self):
            found[:, :3, :3] = Rotation.from_quat(self.quaternions).as_matrix()
        found[:, :3, 3] = self.positions
        return found


def read_tum(text: str | bytes) -> Trajectory:
    """The trajectory of a TUM file; `#` starts a comment. Raises TrajectoryFileError, which names the line."""
    rows, lines = _parse_number_rows(text, 8, "a TUM line: time x y z qx qy qz qw")
    _check_quaternion_norms(rows, lines)
    return Trajectory(rows[:, 0], rows[:, 1:4], rows[:, 4:])


def write_tum(trajectory: Trajectory) -> str:
    """The TUM file of a trajectory, with all the digits of its numbers."""
    rows = np.column_stack([trajectory.times, trajectory.positions, trajectory.quaternions])
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows.tolist())


def read_kitti(text: str | bytes) -> Floats:
    """The homogeneous matrices (n, 4, 4) of a KITTI file. Raises TrajectoryFileError for a matrix that is not rigid."""
    rows, lines = _parse_number_rows(text, 12, "a KITTI line: the 12 numbers of [R | t]")
    matrices = np.tile(np.eye(4), (len(rows), 1, 1))
    matrices[:, :3] = rows.reshape(-1, 3, 4)
    R = matrices[:, :3, :3]
    gaps = np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    wrong = np.flatnonzero((gaps > TOLERANCE) | (np.linalg.det(R) < 0.0))
    if wrong.size:
        raise TrajectoryFileError("text", f"line {lines[wrong[0]]} holds a matrix that is no rotation")
    return matrices


def write_kitti(matrices: ArrayLike) -> str:
    """The KITTI file of homogeneous matrices (n, 4, 4). Raises TrajectoryFileError."""
    values = np.asarray(matrices, dtype=np.float64)
    if values.ndim != 3 or values.shape[1:] != (4, 4) or not np.all(np.isfinite(values)):
        raise TrajectoryFileError("matrices", f"of shape {values.shape} are not finite matrices (n, 4, 4)")
    return "".join(" ".join(map(repr, row)) + "\n" for row in values[:, :3].reshape(-1, 12).tolist())


def _parse_number_rows(text: str | bytes, columns: int, expected: str) -> tuple[Floats, list[int]]:
    """Return the numbers of the lines that hold some, (n, columns), and which lines these are."""
    rows: list[list[float]] = []
    lines: list[int] = []
    for number, line in enumerate(decode_lines(text, error=TrajectoryFileError), start=1):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) != columns or not np.all(np.isfinite(row)):
            raise TrajectoryFileError("text", f"line {number} is not {expected}")
        rows.append(row)
        lines.append(number)
    return np.array(rows, dtype=np.float64).reshape(-1, columns), lines


def _check_quaternion_norms(rows: Floats, lines: list[int]) -> None:
    wrong = np.flatnonzero(np.abs(np.linalg.norm(rows[:, 4:], axis=1) - 1.0) > TOLERANCE)
    if wrong.size:
        raise TrajectoryFileError(
            "text", f"line {lines[wrong[0]]}: pose {wrong[0] + 1} has a quaternion that is not of norm 1"
        )
