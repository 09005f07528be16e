"""Means, a median, and how marks are rounded when they are written: pure."""

from __future__ import annotations

import math
from collections.abc import Sequence

FULL = 20.0
WHOLE = 1e-9  # what rounding may take from a full mark


def weighted_mean(values: Sequence[tuple[float, float]]) -> float | None:
    """Of points with their weights (not negative); None where nothing weighs anything."""
    total = math.fsum(weight for _, weight in values)
    return math.fsum(points * weight for points, weight in values) / total if total > 0 else None


def mean(values: Sequence[float]) -> float | None:
    return weighted_mean([(value, 1.0) for value in values])


def median(values: Sequence[float]) -> float | None:
    """The mean of the two in the middle, of an even number."""
    if not values:
        return None
    ordered, middle = sorted(values), len(values) // 2
    return ordered[middle] if len(values) % 2 else (ordered[middle - 1] + ordered[middle]) / 2


def round_points(points: float) -> float:
    """To the nearest hundredth, a half upwards. Less than all points is never written as all of them."""
    if points >= FULL - WHOLE:
        return FULL
    return min(math.floor(points * 100 + 0.5 + WHOLE) / 100, FULL - 0.01)


def format_number(value: float, sign: str = ",") -> str:
    """At most two decimals, without needless zeros: « 12,5 »."""
    return f"{value:.2f}".rstrip("0").rstrip(".").replace(".", sign)


def format_points(points: float) -> str:
    """Points as they are read in French, rounded."""
    return format_number(round_points(points))
