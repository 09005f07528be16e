"""Poses (3,): x and y in metres or cells, theta in radians; compared as the contract says, simplified to be read."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.comparison import (
    TOLERANCE,
    WELL_BEYOND,
    WELL_WITHIN,
    Mismatch,
    RowComparator,
    are_close,
    row_errors,
    shape_mismatch,
    unreadable,
)
from graders.core.compare.shrinking import shrink_number
from graders.core.compare.told_apart import angle_instead_of_expected_text
from graders.core.contract.values import Floats, UnreadableError, Value, read_array

#: Radians within which reducing an angle loses nothing that a tolerance would see.
FEW_TURNS = 20.0


@dataclass(frozen=True)
class SamePose(RowComparator):
    """Poses (3,): x and y within the tolerance, theta modulo 2 pi but brought back to [-pi, pi].

    With `any_turn`, an angle out of this range is let pass: for checks of a formula, beside one of the range. With
    `heading_only`, only theta counts: a wrong position then costs the points of one check, not of both.
    """

    tolerance: float = TOLERANCE
    any_turn: bool = False
    heading_only: bool = False

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            pose = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        if pose.shape != (3,):
            return shape_mismatch(wanted, pose)
        *where, theta = pose.tolist()  # of three numbers, Python makes shorter work than arrays
        *there, angle = wanted.tolist()
        if self.heading_only:
            where = there
        if not all(map(math.isfinite, (*where, theta))):
            return Mismatch("Une des coordonnées n'est pas un nombre fini.", "nan")
        if not all(abs(a - b) <= self.tolerance * max(1.0, abs(b)) for a, b in zip(where, there, strict=True)):
            return Mismatch(lambda: self._position_message(wanted, pose))
        return self._angle_mismatch(angle, theta)

    def row_errors(self, expected: Floats, got: Floats) -> Floats | None:
        if got.ndim != 2 or got.shape[1] != 3:
            return None
        judged = slice(0 if self.heading_only else 2)
        apart, theta = row_errors(expected[:, judged], got[:, judged], self.tolerance), np.abs(got[:, 2])
        with np.errstate(invalid="ignore", over="ignore"):
            turns = (got[:, 2] - expected[:, 2]) / math.tau
            off = np.abs(turns - np.round(turns)) * math.tau / self.tolerance
            beyond = (theta - math.pi) / TOLERANCE
        # Beyond a few turns, and at the ends of the range, rows must be compared alone.
        unsure = theta > FEW_TURNS if self.any_turn else (beyond > WELL_WITHIN) & (beyond < WELL_BEYOND)
        out = np.isnan(off) if self.any_turn else np.isnan(off) | (beyond >= WELL_BEYOND)
        gaps = np.maximum(apart, np.where(out, np.inf, off))
        return np.asarray(np.where(unsure & (apart < WELL_BEYOND), 1.0, gaps))

    @staticmethod
    def _position_message(wanted: Floats, pose: Floats) -> str:
        axes = [axis for axis, a, b in zip("xy", wanted, pose, strict=False) if not are_close(a, b)]
        which = f"La coordonnée {axes[0]} est fausse" if len(axes) == 1 else "La position est fausse"
        return f"{which} : l'écart est de {render.number(math.hypot(*(pose[:2] - wanted[:2])), 3)}."

    def _angle_mismatch(self, wanted: float, theta: float) -> Mismatch | None:
        if abs(math.remainder(theta - wanted, math.tau)) <= self.tolerance:
            if self.any_turn or abs(theta) <= math.pi + TOLERANCE:
                return None
            return Mismatch(f"L'angle {render.angle(theta)} sort de l'intervalle [−π, π].", "angle_non_ramene")

        def gap() -> str:
            return f"Le cap est faux : {angle_instead_of_expected_text(wanted, theta)}."

        is_degrees = abs(math.remainder(math.radians(theta) - wanted, math.tau)) <= 1e-6
        return Mismatch(gap, "degres" if is_degrees else "oppose" if abs(theta + wanted) <= self.tolerance else None)


def shrink_pose(value: Value) -> Iterator[Value]:
    """x and y as numbers, theta as an angle."""
    pose = np.asarray(value, dtype=np.float64)
    for index, shrinker in ((0, shrink_number), (1, shrink_number), (2, shrink_angle)):
        for candidate in shrinker(float(pose[index])):
            simpler = pose.copy()
            simpler[index] = candidate
            yield simpler


def shrink_angle(value: float) -> Iterator[float]:
    """0, then the nearest multiples of a quarter, an eighth and a twelfth of a turn."""
    return iter(_simpler_angles(value))


@lru_cache(maxsize=4096)
def _simpler_angles(value: float) -> Sequence[float]:
    angles = (0.0, *(_nearest(value, math.pi / k) for k in (2, 4, 6)))
    return [angle for angle in angles if angle_complexity(angle) < angle_complexity(value)]


def _nearest(value: float, step: float) -> float:
    nearest = round(value / step) * step
    return nearest if -math.pi < nearest <= math.pi else math.pi


def angle_complexity(value: float) -> float:
    """As `reading_cost`, for fractions of a turn."""
    if value == 0:
        return -1.0
    rank = next((r for r, k in enumerate((2, 4, 6)) if math.isclose(value, _nearest(value, math.pi / k))), 5)
    return 10.0 * rank + abs(value) / 10.0
