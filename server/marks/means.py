"""Means, the median, and the rounding of marks: pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

FULL_POINTS = 20.0
ROUNDING_NOISE = 1e-9
FORMULA = "Moyenne = Σ (coefficient × note) / Σ coefficients, bonus ajoutés, plafonnée à 20"


def weighted_mean(values: Sequence[tuple[float, float]]) -> float | None:
    """Return the mean of (points, weight) pairs, weights not negative; None where all weights are 0."""
    total = math.fsum(weight for _, weight in values)
    return math.fsum(points * weight for points, weight in values) / total if total > 0 else None


@dataclass(frozen=True)
class MeanTerm:
    """A mark in a student's mean: points out of 20, None where it does not count.

    A bonus is added as it is: its weight is not used.
    """

    points: float | None
    weight: float = 1.0
    bonus: bool = False


def mean_of_terms(terms: Iterable[MeanTerm]) -> float | None:
    """Return the weighted mean of what counts, plus the bonuses, at most 20; None where nothing but bonuses counts."""
    counted = [(term.points, term) for term in terms if term.points is not None]
    base = weighted_mean([(points, term.weight) for points, term in counted if not term.bonus])
    if base is None:
        return None
    bonus = math.fsum(points for points, term in counted if term.bonus)
    return max(base, min(FULL_POINTS, base + bonus))


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


def round_or_none(points: float | None) -> float | None:
    return None if points is None else round_points(points)


def format_number(value: float, decimal_sign: str = ",") -> str:
    """Format with at most two decimals, without trailing zeros: « 12,5 »."""
    return f"{value:.2f}".rstrip("0").rstrip(".").replace(".", decimal_sign)


def format_points(points: float) -> str:
    """Round points and format them in French."""
    return format_number(round_points(points))
