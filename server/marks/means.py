"""Means, the median, and the rounding of marks: pure."""

from __future__ import annotations

import math
from collections.abc import Sequence

FULL_POINTS = 20.0
ROUNDING_NOISE = 1e-9


def weighted_mean(values: Sequence[tuple[float, float]]) -> float | None:
    """Return the mean of (points, weight) pairs, weights not negative; None where all weights are 0."""
    total = math.fsum(weight for _, weight in values)
    return math.fsum(points * weight for points, weight in values) / total if total > 0 else None


def mean(values: Sequence[float]) -> float | None:
    return weighted_mean([(value, 1.0) for value in values])


def median(values: Sequence[float]) -> float | None:
    """Return the median, of an even number the mean of the two in the middle; None for no values."""
    if not values:
        return None
    ordered, middle = sorted(values), len(values) // 2
    return ordered[middle] if len(values) % 2 else (ordered[middle - 1] + ordered[middle]) / 2


def round_points(points: float) -> float:
    """Round to the nearest hundredth, halves up. Less than full points is never rounded to full."""
    if points >= FULL_POINTS - ROUNDING_NOISE:
        return FULL_POINTS
    return min(math.floor(points * 100 + 0.5 + ROUNDING_NOISE) / 100, FULL_POINTS - 0.01)


def format_number(value: float, decimal_sign: str = ",") -> str:
    """Format with at most two decimals, without trailing zeros: « 12,5 »."""
    return f"{value:.2f}".rstrip("0").rstrip(".").replace(".", decimal_sign)


def format_points(points: float) -> str:
    """Round points and format them in French."""
    return format_number(round_points(points))
