"""Laser logs of the CARMEN toolkit: the FLASER and ODOM lines of a text.

    FLASER n  r_1 ... r_n  x y theta  odom_x odom_y odom_theta  ipc_timestamp  hostname  logger_timestamp
    ODOM  x y theta  tv rv accel  ipc_timestamp  hostname  logger_timestamp

Metres, radians, seconds. (x, y, theta) of a FLASER line is the pose of the laser, (odom_x, ...) that of the robot. The
beams look ahead over half a turn, from the right: an even number of them, 180 or 360, stops one step short of the left,
an odd number reaches it.

The lidars are SICK's, which read centimetres up to 81.83 m (nothing seen up to there); 81.84 to 81.91 m are the codes
of faults, dazzled or not valid: no measurements, and not a free way through the wall.

Corrected logs hold corrected poses in their FLASER lines. The odometry is there all the same: the first ODOM line after
a FLASER line restates its pose, and those that follow carry on from there by the wheels, up to the next FLASER line.

Source: the message formats of CARMEN's logger, as in the logs of the Radish repository and Freiburg's data sets.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.se2 import compose, relative
from reference.text import decode_lines
from reference.world.scan import Scan, Zero

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Place = tuple[float, float, float]

# Numbers behind the ranges, and words behind these: the name of the host and the time of the logger.
AFTER_RANGES, AFTER_NUMBERS = 7, 2
# Numbers of an ODOM line, and words behind these.
OF_ODOM, AFTER_ODOM = 7, 2
# The span of ODOM lines where there are none.
UNTOLD: tuple[Place, Place] = ((np.nan, np.nan, np.nan), (np.nan, np.nan, np.nan))

# Readings in metres that are codes of faults of SICK's LMS: 8184 to 8191 cm, with half a centimetre to spare.
FAULTS = (81.835, 81.915)


class LogError(InvalidArgumentError):
    """A text that is no CARMEN log, or not one of what is asked of it; the message tells the line."""


@dataclass(frozen=True, eq=False)
class LaserLog:
    """m scans in the order of the text; the poses (m, 3) of the laser and of the robot; `times` (m,) in seconds.

    `lines` (m,): those of the scans, from 1. `T_odom_span` (m, 2, 3): the first and the last ODOM pose between a scan
    and the next; NaN where there is none.
    """

    scans: tuple[Scan, ...]
    T_world_laser: Floats
    T_odom_robot: Floats
    times: Floats
    lines: Indices
    T_odom_span: Floats

    def __len__(self) -> int:
        return len(self.scans)

    def wheel_poses(self) -> Floats:
        """Where the wheels alone lead (m, 3), from the zero pose at the first scan, whatever has corrected the log.

        From a scan to the next: from the first to the last ODOM line between them. Raises LogError where there is none.
        """
        missing = np.flatnonzero(np.isnan(self.T_odom_span[:-1]).any(axis=(1, 2)))
        if missing.size:
            line = self.lines[missing[0]]
            raise LogError("text", f"no ODOM line follows the scan of line {line}: nothing tells how it moved on")
        poses = [np.zeros(3)]
        for step in relative(self.T_odom_span[:-1, 0], self.T_odom_span[:-1, 1]):
            poses.append(compose(poses[-1], step))
        return np.array(poses[: len(self)]).reshape(-1, 3)

    def increasing_times(self) -> Floats:
        """The times (m,), for what needs an order. Raises LogError where one does not come after the one before."""
        late = np.flatnonzero(np.diff(self.times) <= 0.0)
        if late.size:
            k = int(late[0])
            told = f"the scan of line {self.lines[k + 1]} is dated {self.times[k + 1]} s"
            raise LogError("text", f"{told}, which is not after the {self.times[k]} s of line {self.lines[k]}")
        return self.times


def parse_flaser(
    text: str | bytes, max_range: float, *, min_range: float = 0.0, zero: Zero = "no measurement"
) -> LaserLog:
    """The FLASER lines of a log and the ODOM lines between; others are passed over. Ranges as `Scan.from_sensor`'s.

    Readings that are codes of faults are no measurements.

    Raises LogError for a line that is cut short, holds what is no number, or repeats the scan before it to the last
    digit, date included; and for a text without any scan.
    """
    scans: list[Scan] = []
    numbers: list[list[float]] = []
    lines: list[int] = []
    spans: list[tuple[Place, Place]] = []
    previous: list[str] = []
    line = 0
    for line, words in enumerate(map(str.split, decode_lines(text, error=LogError)), 1):
        if words[:1] == ["ODOM"]:
            pose = _parse_odom_line(line, words[1:])
            if spans:
                spans[-1] = (pose if spans[-1] is UNTOLD else spans[-1][0], pose)
        elif words[:1] == ["FLASER"]:
            ranges, row = _parse_flaser_line(line, words[1:])
            if words == previous:
                raise LogError("text", f"line {line} repeats the scan of line {lines[-1]}, date included")
            readings = np.array(ranges)
            readings[(readings > FAULTS[0]) & (readings < FAULTS[1])] = np.nan
            scans.append(Scan.from_sensor(readings, beam_angles(len(readings)), max_range, min_range, zero=zero))
            numbers.append(row)
            lines.append(line)
            spans.append(UNTOLD)
            previous = words
    if not scans:
        raise LogError("text", f"ends at line {line} without any FLASER line: no scan was read")
    rows = np.array(numbers).reshape(-1, AFTER_RANGES)
    of_odom = np.array(spans, dtype=np.float64).reshape(-1, 2, 3)
    return LaserLog(tuple(scans), rows[:, 0:3], rows[:, 3:6], rows[:, 6], np.array(lines, dtype=np.int64), of_odom)


def beam_angles(n: int) -> Floats:
    """The angles (n,) of the beams of a front laser, from -pi/2 on."""
    return -np.pi / 2.0 + np.pi * np.arange(n) / max(n - n % 2, 1)


def _parse_flaser_line(line: int, words: list[str]) -> tuple[list[float], list[float]]:
    """The ranges of a FLASER line, and the seven numbers behind."""
    n = int(words[0]) if words and words[0].isdecimal() else 0
    values = _parse_numbers(line, words[1 : 1 + n + AFTER_RANGES])
    announced = 1 + n + AFTER_RANGES
    if n < 1 or not announced <= len(words) <= announced + AFTER_NUMBERS or not np.all(np.isfinite(values[n:])):
        told = f"the {n} ranges that it announces" if n else "a number of ranges"
        raise LogError("text", f"line {line} does not hold {told}, and {AFTER_RANGES} numbers behind them")
    return values[:n], values[n:]


def _parse_odom_line(line: int, words: list[str]) -> Place:
    """The pose of an ODOM line."""
    values = _parse_numbers(line, words[:OF_ODOM])
    if not OF_ODOM <= len(words) <= OF_ODOM + AFTER_ODOM or not np.all(np.isfinite(values)):
        raise LogError("text", f"line {line} does not hold the {OF_ODOM} numbers of an ODOM line")
    x, y, theta, *_ = values
    return x, y, theta


def _parse_numbers(line: int, words: list[str]) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise LogError("text", f"line {line} holds what is no number: {error}") from error
