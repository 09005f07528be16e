"""One turn of a lidar: distances, the angles of their beams, and the points they show.

Angles are in radians from the robot's heading, counter-clockwise; lengths are in metres, or in cells.

A beam is stopped (a range below `max_range`), or else one of three things, for each of which REP 117 has a value: it
meets nothing as far as the lidar sees (`max_range`, +Inf: the way is free); it was not measured (NaN), which says
nothing at all; or something is too close to be measured (-Inf, or a reading under the least range): where it is nobody
knows, but the way is not free. The last two are no measurements of a length: no map and no belief learns from them.

Source: REP 117, "Informational Distance Measurements" (ROS, 2011).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError, check_choice

Floats = NDArray[np.float64]
Zero = Literal["no measurement", "too close", "nothing seen"]


class ScanError(InvalidArgumentError):
    """Something that no lidar measures; `argument` names it."""


@dataclass(frozen=True, eq=False)
class Scan:
    """`ranges` (n,) in [0, max_range] along `angles` (n,); a beam that reads `max_range` touched nothing.

    `measured` (n,): which beams say something; all do unless told otherwise, and what the others read has no meaning.
    `too_close` (n,): which of those others were stopped nearer than the lidar can measure. The arrays are copied and
    cannot be written to. An empty scan is a scan; what needs points refuses it. Raises ScanError for a range that is
    not a number of [0, max_range], or an angle that is not finite.
    """

    ranges: Floats
    angles: Floats
    max_range: float
    measured: NDArray[np.bool_] = field(default_factory=lambda: np.array(True))
    too_close: NDArray[np.bool_] = field(default_factory=lambda: np.array(False))

    def __post_init__(self) -> None:
        if not 0.0 < self.max_range < np.inf:
            raise ScanError("max_range", f"{self.max_range} is not a positive length")
        ranges, angles = np.array(self.ranges, dtype=np.float64), np.array(self.angles, dtype=np.float64)
        if ranges.ndim != 1 or not np.all((ranges >= 0.0) & (ranges <= self.max_range)):
            raise ScanError("ranges", f"of shape {ranges.shape} is not an array (n,) of lengths in [0, max_range]")
        if angles.shape != ranges.shape or not np.all(np.isfinite(angles)):
            raise ScanError("angles", f"of shape {angles.shape} is not an array ({len(ranges)},) of finite angles")
        close = self._check_mask("too_close", self.too_close, ranges.shape)
        measured = self._check_mask("measured", self.measured, ranges.shape) & ~close
        for name, values in (("ranges", ranges), ("angles", angles), ("measured", measured), ("too_close", close)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @staticmethod
    def _check_mask(name: str, truths: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.bool_]:
        mask = np.array(truths, dtype=np.bool_)
        if mask.shape not in ((), shape):
            raise ScanError(name, f"of shape {mask.shape} is not an array ({shape[0]},) of truths")
        return np.array(np.broadcast_to(mask, shape))

    @classmethod
    def from_sensor(
        cls,
        ranges: ArrayLike,
        angles: ArrayLike,
        max_range: float,
        min_range: float = 0.0,
        *,
        zero: Zero = "no measurement",
    ) -> Scan:
        """A scan from raw readings: +Inf, `max_range` or more met nothing up to there.

        -Inf, and a length below `min_range`, are too close; NaN and negative lengths are no measurements. What a 0
        stands for differs from driver to driver: `zero` tells. Raises ScanError.
        """
        if not 0.0 <= min_range < max_range:
            raise ScanError("min_range", f"{min_range} is not a length below max_range")
        check_choice("zero", zero, Zero, ScanError)
        readings = np.asarray(ranges, dtype=np.float64)
        if zero == "nothing seen":
            readings = np.where(readings == 0.0, np.inf, readings)
        measured = (readings > 0.0) & (readings >= min_range)
        close = (readings == -np.inf) | ((readings > 0.0) & (readings < min_range))
        if zero == "too close":
            close |= readings == 0.0
        lengths = np.where(measured & (readings < max_range), readings, max_range)
        return cls(lengths, np.asarray(angles, dtype=np.float64), max_range, measured, close)

    @classmethod
    def full_turn(cls, ranges: ArrayLike, max_range: float) -> Scan:
        """A scan over a whole turn: beam k of n points at 2 pi k / n from the heading."""
        readings = np.asarray(ranges, dtype=np.float64)
        return cls(readings, full_turn_angles(readings.size), max_range)

    def __len__(self) -> int:
        return len(self.ranges)

    @property
    def hit_mask(self) -> NDArray[np.bool_]:
        """Which beams (n,) touched something, away from the lidar itself."""
        return self.measured & (self.ranges > 0.0) & (self.ranges < self.max_range)

    def points(self) -> Floats:
        """Where the beams that hit something ended, (k, 2) = (x, y) in the robot's frame, in the order of the beams."""
        hits = self.hit_mask
        ranges, angles = self.ranges[hits], self.angles[hits]
        points = np.empty((len(ranges), 2))
        np.multiply(ranges, np.cos(angles), out=points[:, 0])
        np.multiply(ranges, np.sin(angles), out=points[:, 1])
        return points

    def take_every(self, step: int) -> Scan:
        """The scan of one beam out of `step`, the first one included. Raises ScanError."""
        if step < 1:
            raise ScanError("step", f"{step} keeps no beam")
        return self.select_beams(np.arange(0, len(self), step))

    def select_beams(self, beams: ArrayLike) -> Scan:
        """The scan of some beams: indices (k,) or a mask (n,)."""
        kept = np.asarray(beams)
        return Scan(self.ranges[kept], self.angles[kept], self.max_range, self.measured[kept], self.too_close[kept])

    def only_measured(self) -> Scan:
        """The scan of the beams that say something; the scan itself where all do."""
        return self if self.measured.all() else self.select_beams(self.measured)

    def filled_ranges(self) -> Floats:
        """The ranges (n,) of a whole turn, those that were not measured drawn between their measured neighbours.

        For what needs a length for every beam. Where none was measured, all read `max_range`.
        """
        beams = np.flatnonzero(self.measured)
        if len(beams) in (0, len(self)):
            return self.ranges if len(beams) else np.full(len(self), self.max_range)
        return np.asarray(np.interp(np.arange(len(self)), beams, self.ranges[beams], period=len(self)))


def full_turn_angles(beams: int) -> Floats:
    """The angles (beams,) of beams spread evenly over a whole turn, the first one straight ahead. Raises ScanError."""
    if beams < 0:
        raise ScanError("beams", f"{beams} beams make no scan")
    return 2.0 * np.pi * np.arange(beams) / max(beams, 1)
