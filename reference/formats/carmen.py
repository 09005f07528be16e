"""Laser logs of the CARMEN toolkit: the FLASER lines of a text.

    FLASER n  r_1 ... r_n  x y theta  odom_x odom_y odom_theta  ipc_timestamp  hostname  logger_timestamp

Metres, radians, seconds. (x, y, theta) is the pose of the laser, (odom_x, ...) that of the robot; corrected logs hold
corrected poses. The beams look ahead over half a turn, from the right: an even number of them, 180 or 360, stops one
step short of the left, an odd number reaches it.

Source: the message formats of CARMEN's logger, as in the logs of the Radish repository and Freiburg's data sets.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.text import split_lines
from reference.world.scan import Scan

Floats = NDArray[np.float64]

# Numbers behind the ranges, and words behind these: the name of the host and the time of the logger.
AFTER_RANGES, AFTER_NUMBERS = 7, 2


class LogError(InvalidArgumentError):
    """A text that is no CARMEN log; the message tells the line."""


@dataclass(frozen=True, eq=False)
class LaserLog:
    """m scans in the order of the text; the poses (m, 3) of the laser and of the robot; `times` (m,) in seconds."""

    scans: tuple[Scan, ...]
    T_world_laser: Floats
    T_odom_robot: Floats
    times: Floats

    def __len__(self) -> int:
        return len(self.scans)


def parse_flaser(text: str | bytes, max_range: float) -> LaserLog:
    """The FLASER lines of a log; other lines are passed over. Ranges are those of `Scan.from_sensor`.

    Raises LogError for a line that is cut short or holds what is no number.
    """
    lines = ((number, line.split()) for number, line in enumerate(split_lines(text, error=LogError), 1))
    readings = [_reading(number, words[1:], max_range) for number, words in lines if words[:1] == ["FLASER"]]
    rows = np.array([row for _, row in readings]).reshape(-1, AFTER_RANGES)
    return LaserLog(tuple(scan for scan, _ in readings), rows[:, 0:3], rows[:, 3:6], rows[:, 6])


def beam_angles(n: int) -> Floats:
    """The angles (n,) of the beams of a front laser, from -pi/2 on."""
    return -np.pi / 2.0 + np.pi * np.arange(n) / max(n - n % 2, 1)


def _reading(number: int, words: list[str], max_range: float) -> tuple[Scan, list[float]]:
    try:
        n = int(words[0])
        values = [float(word) for word in words[1 : 1 + n + AFTER_RANGES]]
    except (ValueError, IndexError) as error:
        raise LogError("text", f"line {number} holds what is no number: {error}") from error
    announced = 1 + n + AFTER_RANGES
    if n < 1 or not announced <= len(words) <= announced + AFTER_NUMBERS or not np.all(np.isfinite(values[n:])):
        raise LogError(
            "text", f"line {number} does not hold the {n} ranges that it announces, and {AFTER_RANGES} numbers"
        )
    return Scan.from_sensor(values[:n], beam_angles(n), max_range), values[n:]
