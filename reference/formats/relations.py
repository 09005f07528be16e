"""Relations between poses, measured by hand: the files of Freiburg's SLAM benchmark.

    time_1  time_2  x  y  z  roll  pitch  yaw

One relation a line: the pose of the robot at time_2 seen from where it was at time_1, in metres and radians; times in
seconds, those of the scans of a log. In the plane z, roll and pitch are zero.

Source: Kümmerle et al., "On measuring the accuracy of SLAM algorithms" (2009), and the data sets that come with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.text import decode_lines

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

NUMBERS = 8
PLANE = [2, 3, 7]
LEVEL = [4, 5, 6]


class RelationsError(InvalidArgumentError):
    """A text that holds no relations of the plane; the message tells the line."""


@dataclass(frozen=True, eq=False)
class Relations:
    """m relations: `times` (m, 2) in seconds and `T_1_2` (m, 3) = (x, y, theta)."""

    times: Floats
    T_1_2: Floats

    def __len__(self) -> int:
        return len(self.times)

    def select_between_times(self, times: ArrayLike, tolerance: float = 1e-3) -> tuple[Indices, Floats]:
        """The relations of which both times are among `times` (n,), to a tolerance: pairs (k, 2) of indices, (k, 3)."""
        stamps = np.asarray(times, dtype=np.float64)
        if not len(stamps) or not len(self):
            return np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3))
        order = np.argsort(stamps, kind="stable")
        after = np.clip(np.searchsorted(stamps, self.times, sorter=order), 1, max(len(stamps) - 1, 1))
        near = np.stack([order[after - 1], order[np.minimum(after, len(stamps) - 1)]], axis=-1)
        away = np.abs(stamps[near] - self.times[:, :, None])
        pairs = np.take_along_axis(near, away.argmin(axis=2)[:, :, None], axis=2)[:, :, 0]
        both = np.all(away.min(axis=2) <= tolerance, axis=1)
        return pairs[both], self.T_1_2[both]


def parse_relations(text: str | bytes) -> Relations:
    """The relations of a text; blank lines and those that begin with # are passed over. Raises RelationsError."""
    rows = []
    for line, words in enumerate(map(str.split, decode_lines(text, error=RelationsError)), 1):
        if not words or words[0].startswith("#"):
            continue
        try:
            row = [float(word) for word in words]
        except ValueError as error:
            raise RelationsError("text", f"line {line} holds what is no number: {error}") from error
        if len(row) != NUMBERS or not np.all(np.isfinite(row)):
            raise RelationsError("text", f"line {line} does not hold {NUMBERS} finite numbers")
        if any(row[k] for k in LEVEL):
            raise RelationsError("text", f"line {line} leaves the plane: z, roll or pitch is not zero")
        rows.append(row)
    table = np.array(rows, dtype=np.float64).reshape(-1, NUMBERS)
    return Relations(table[:, :2], table[:, PLANE])
