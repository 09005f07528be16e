"""A matrix of the plane as three gestures: turn, stretch along the axes, turn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.se2 import rotation_matrix, wrap_angle

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Gestures:
    """A = R(last) diag(long, short) R(first), `long` >= |short|; `short` is negative where A turns the plane over.

    Angles in radians, `first` in ]-pi/2, pi/2].
    """

    first: float
    long: float
    short: float
    last: float

    def after(self, first: float, stretch: float, last: float) -> Floats:
        """The matrix (2, 2) when each gesture is done in part, from 0 to 1."""
        widths = 1.0 + stretch * (np.array([self.long, self.short]) - 1.0)
        return np.asarray(rotation_matrix(last * self.last) @ np.diag(widths) @ rotation_matrix(first * self.first))


def gestures(matrix: Floats) -> Gestures:
    """The three gestures of a matrix (2, 2), by its singular values."""
    left, values, right = np.linalg.svd(matrix)
    short = float(values[1])
    if np.linalg.det(right) < 0:
        right, short = np.diag([1.0, -1.0]) @ right, -short
    if np.linalg.det(left) < 0:
        left, short = left @ np.diag([1.0, -1.0]), -short
    first = math.atan2(right[1, 0], right[0, 0])
    last = math.atan2(left[1, 0], left[0, 0])
    if first > math.pi / 2:
        first, last = first - math.pi, wrap_angle(last + math.pi)
    if first <= -math.pi / 2:  # rounding may have brought it there just now
        first, last = first + math.pi, wrap_angle(last + math.pi)
    return Gestures(first, float(values[0]), short, last)
