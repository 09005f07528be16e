"""One turn of a lidar: distances, the angles of their beams, and the points they show.

Angles are in radians from the robot's heading, counter-clockwise; lengths are in metres, or in cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]


class ScanError(InvalidArgumentError):
    """Something that no lidar measures; `argument` names it."""


@dataclass(frozen=True, eq=False)
class Scan:
    """`ranges` (n,) in [0, max_range] along `angles` (n,); a beam that reads `max_range` touched nothing.

    The arrays are copied and cannot be written to. An empty scan is a scan; what needs points refuses it. Raises
    ScanError for a range that is not a number of [0, max_range], or an angle that is not finite.
    """

    ranges: Floats
    angles: Floats
    max_range: float

    def __post_init__(self) -> None:
        if not 0.0 < self.max_range < np.inf:
            raise ScanError("max_range", f"{self.max_range} is not a positive length")
        ranges, angles = np.array(self.ranges, dtype=np.float64), np.array(self.angles, dtype=np.float64)
        if ranges.ndim != 1 or not np.all((ranges >= 0.0) & (ranges <= self.max_range)):
            raise ScanError("ranges", f"of shape {ranges.shape} is not an array (n,) of lengths in [0, max_range]")
        if angles.shape != ranges.shape or not np.all(np.isfinite(angles)):
            raise ScanError("angles", f"of shape {angles.shape} is not an array ({len(ranges)},) of finite angles")
        for name, values in (("ranges", ranges), ("angles", angles)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @classmethod
    def from_sensor(cls, ranges: ArrayLike, angles: ArrayLike, max_range: float) -> Scan:
        """A scan from raw readings: infinity, NaN, zero or less, `max_range` or more are beams that saw nothing."""
        readings = np.asarray(ranges, dtype=np.float64)
        seen = (readings > 0.0) & (readings < max_range)
        return cls(np.where(seen, readings, max_range), np.asarray(angles, dtype=np.float64), max_range)

    @classmethod
    def full_turn(cls, ranges: ArrayLike, max_range: float) -> Scan:
        """A scan over a whole turn: beam k of n points at 2 pi k / n from the heading."""
        readings = np.asarray(ranges, dtype=np.float64)
        return cls(readings, turn_angles(readings.size), max_range)

    def __len__(self) -> int:
        return len(self.ranges)

    @property
    def hits(self) -> NDArray[np.bool_]:
        """Which beams (n,) touched something, away from the lidar itself."""
        return (self.ranges > 0.0) & (self.ranges < self.max_range)

    def points(self) -> Floats:
        """Where the beams that hit something ended, (k, 2) = (x, y) in the robot's frame, in the order of the beams."""
        hits = self.hits
        ranges, angles = self.ranges[hits], self.angles[hits]
        points = np.empty((len(ranges), 2))
        np.multiply(ranges, np.cos(angles), out=points[:, 0])
        np.multiply(ranges, np.sin(angles), out=points[:, 1])
        return points

    def every(self, step: int) -> Scan:
        """The scan of one beam out of `step`, the first one included. Raises ScanError."""
        if step < 1:
            raise ScanError("step", f"{step} keeps no beam")
        return Scan(self.ranges[::step], self.angles[::step], self.max_range)


def turn_angles(beams: int) -> Floats:
    """The angles (beams,) of beams spread evenly over a whole turn, the first one straight ahead. Raises ScanError."""
    if beams < 0:
        raise ScanError("beams", f"{beams} beams make no scan")
    return 2.0 * np.pi * np.arange(beams) / max(beams, 1)
