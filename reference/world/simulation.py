"""A differential robot with a lidar in a grid map: journeys, what its encoders count, and what its lidar reads.

All is in metres and radians in the world's frame. The robot does exactly what is asked; its encoders err, by the model
of `DifferentialDrive`, and its lidar by that of `SimulatedLidar`: odometry then drifts away from the truth.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), section 6.3, for the errors of a lidar.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.odometry import DifferentialDrive, Motion, integrate_poses
from reference.se2 import wrap_angle
from reference.world.grid_map import GridMap
from reference.world.scan import Scan, full_turn_angles

Floats = NDArray[np.float64]


class SimulationError(InvalidArgumentError):
    """A robot that cannot be built or driven as asked; `argument` names what is at fault."""


@dataclass(frozen=True, eq=False)
class SimulatedLidar:
    """Beams along `angles` (n,) from the heading, up to `max_range`.

    A beam that hits reads the distance with an error of standard deviation `sigma`. With probability `short` something
    that is not on the map stops it first, at a uniform distance; with probability `miss` it reads `max_range`; with
    probability `stray` any distance at all. Raises SimulationError.
    """

    angles: Floats
    max_range: float
    sigma: float = 0.0
    short: float = 0.0
    miss: float = 0.0
    stray: float = 0.0

    def __post_init__(self) -> None:
        angles = np.array(self.angles, dtype=np.float64)
        if angles.ndim != 1 or not np.all(np.isfinite(angles)):
            raise SimulationError("angles", f"of shape {angles.shape} are not finite angles (n,)")
        object.__setattr__(self, "angles", angles)
        if not 0.0 < self.max_range < np.inf:
            raise SimulationError("max_range", f"{self.max_range} is not a positive length")
        if not 0.0 <= self.sigma < np.inf:
            raise SimulationError("sigma", f"{self.sigma} is not a standard deviation")
        for name in ("short", "miss", "stray"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise SimulationError(name, f"{getattr(self, name)} is not a probability")
        if self.short + self.miss + self.stray > 1.0:
            raise SimulationError("stray", "with `short` and `miss` makes a probability above 1")

    @classmethod
    def full_turn(cls, beams: int, max_range: float, sigma: float = 0.0) -> SimulatedLidar:
        """A lidar of `beams` beams over a whole turn, without gross errors."""
        return cls(full_turn_angles(beams), max_range, sigma)

    def measure_ranges(self, grid_map: GridMap, poses: ArrayLike, rng: np.random.Generator) -> Floats:
        """Ranges (m, n), noisy, from poses (m, 3) of the world."""
        return self.add_noise(grid_map.cast_scans(poses, self.angles, self.max_range), rng)

    def add_noise(self, ranges: ArrayLike, rng: np.random.Generator) -> Floats:
        """What would have been read instead of perfect ranges (…)."""
        true = np.asarray(ranges, dtype=np.float64)
        hit = np.clip(true + self.sigma * rng.standard_normal(true.shape), 0.0, self.max_range)
        read = np.where(true < self.max_range, hit, self.max_range)
        fate, part = rng.random(true.shape), rng.random(true.shape)
        kinds = [fate < self.short, fate < self.short + self.miss, fate < self.short + self.miss + self.stray]
        return np.asarray(
            np.select(kinds, [part * true, np.full_like(true, self.max_range), part * self.max_range], read),
            dtype=np.float64,
        )


@dataclass(frozen=True, eq=False)
class SimulatedRun:
    """A simulated journey of n poses, one every `period` seconds.

    `truth` (n, 3); `wheels` (n - 1, 2), the paths (left, right) that the encoders counted between them; `odometry`
    (n, 3), what they add up to from the true first pose; `ranges` (n, beams), one scan a pose.
    """

    truth: Floats
    wheels: Floats
    odometry: Floats
    ranges: Floats
    drive: DifferentialDrive
    lidar: SimulatedLidar
    period: float

    def __len__(self) -> int:
        return len(self.truth)

    @property
    def times(self) -> Floats:
        """When each pose was passed, (n,), in seconds from the start."""
        return self.period * np.arange(len(self.truth), dtype=np.float64)

    def scan(self, index: int) -> Scan:
        """The scan taken at pose `index`."""
        return Scan(self.ranges[index], self.lidar.angles, self.lidar.max_range)


def simulate(
    grid_map: GridMap,
    motions: Sequence[Motion],
    start: ArrayLike,
    drive: DifferentialDrive,
    lidar: SimulatedLidar,
    rng: np.random.Generator,
    period: float = 0.1,
) -> SimulatedRun:
    """Drive `motions` from the pose `start` (3,), and write down what the encoders and the lidar say.

    Raises SimulationError when a pose on the way is not on a free cell.
    """
    if not 0.0 < period < np.inf:
        raise SimulationError("period", f"{period} is not a positive duration")
    paths = np.array([drive.wheel_paths(motion) for motion in motions]).reshape(-1, 2)
    truth = integrate_poses(drive, paths, start)
    blocked = np.flatnonzero(~grid_map.is_free(truth[:, :2]))
    if blocked.size:
        raise SimulationError("motions", f"lead off the free cells, at pose {blocked[0]}")
    counted = paths + drive.path_deviations(paths) * rng.standard_normal(paths.shape)
    ranges = lidar.measure_ranges(grid_map, truth, rng)
    return SimulatedRun(truth, counted, integrate_poses(drive, counted, start), ranges, drive, lidar, period)


def motions_through_waypoints(start: ArrayLike, waypoints: ArrayLike, step: float, turn: float) -> list[Motion]:
    """The motions that visit `waypoints` (k, 2) one after the other, turning on the spot before each straight line.

    None is longer than `step` metres, or turns by more than `turn` radians. Raises SimulationError.
    """
    pose, goals = np.array(start, dtype=np.float64), np.asarray(waypoints, dtype=np.float64)
    if pose.shape != (3,) or not np.all(np.isfinite(pose)):
        raise SimulationError("start", "is not a pose (3,) of finite numbers")
    if goals.ndim != 2 or goals.shape[1] != 2 or not np.all(np.isfinite(goals)):
        raise SimulationError("waypoints", f"of shape {goals.shape} are not finite points (k, 2)")
    _check_steps(step, turn)
    motions: list[Motion] = []
    for goal in goals:
        away = goal - pose[:2]
        distance = float(np.hypot(*away))
        if distance == 0.0:
            continue
        heading = float(np.arctan2(away[1], away[0]))
        motions += [Motion(0.0, part) for part in _equal_parts(wrap_angle(heading - float(pose[2])), turn)]
        motions += [Motion(part, 0.0) for part in _equal_parts(distance, step)]
        pose = np.array([*goal, heading])
    return motions


def random_walk(
    grid_map: GridMap, start: ArrayLike, count: int, step: float, turn: float, rng: np.random.Generator
) -> list[Motion]:
    """`count` motions of a robot that goes where there is room: ahead while it can, else towards a way that is open.

    It keeps about two steps from walls. It turns on the spot by at most `turn` at a time, towards one of 16 directions
    chosen at random, the more often the more open it is. Raises SimulationError.
    """
    _check_steps(step, turn)
    pose = np.array(start, dtype=np.float64)
    if pose.shape != (3,) or not np.all(np.isfinite(pose)) or not grid_map.is_free(pose[:2]):
        raise SimulationError("start", "is not a pose (3,) on a free cell")
    motions: list[Motion] = []
    sight = float(np.hypot(*grid_map.shape)) * grid_map.resolution
    sides, ahead = full_turn_angles(16), np.linspace(-0.5, 0.5, 7)
    while len(motions) < count:
        if grid_map.cast_scans([pose], ahead, sight).min() > 3.0 * step:
            pose[:2] += step * np.array([np.cos(pose[2]), np.sin(pose[2])])
            motions.append(Motion(step, 0.0))
            continue
        room = grid_map.cast_scans([pose], sides, sight)[0] + 1e-3 * sight
        chosen = wrap_angle(float(rng.choice(sides, p=room / room.sum())))
        motions += [Motion(0.0, part) for part in _equal_parts(chosen, turn)]
        pose[2] += chosen
    return motions[:count]


def _equal_parts(total: float, largest: float) -> list[float]:
    """Equal parts of `total`, none of them larger than `largest` either way."""
    count = int(np.ceil(abs(total) / largest - 1e-9))
    return [total / count] * count if count else []


def _check_steps(step: float, turn: float) -> None:
    if not 0.0 < step < np.inf:
        raise SimulationError("step", f"{step} is not a positive length")
    if not 0.0 < turn < np.inf:
        raise SimulationError("turn", f"{turn} is not a positive angle")
