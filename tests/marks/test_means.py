"""Means against exact fractions; how marks are rounded and written."""

from __future__ import annotations

import math
from fractions import Fraction
from statistics import median as statistics_median

from hypothesis import given
from hypothesis import strategies as st

from server.marks.means import FULL_POINTS, format_points, mean, median, round_points, weighted_mean

points = st.floats(0, 20)
weights = st.sampled_from([0.0, 0.5, 1.0, 2.0, 3.0])


@given(st.lists(st.tuples(points, weights), max_size=9))
def test_a_weighted_mean_is_that_of_fractions(values: list[tuple[float, float]]) -> None:
    total = sum(Fraction(weight) for _, weight in values)
    found = weighted_mean(values)
    if not total:
        assert found is None
    else:
        exact = sum(Fraction(point) * Fraction(weight) for point, weight in values) / total
        assert found is not None
        assert math.isclose(found, exact, rel_tol=1e-12, abs_tol=1e-12)


@given(st.lists(points, max_size=9))
def test_the_median_and_the_mean(values: list[float]) -> None:
    assert median(values) == (statistics_median(values) if values else None)
    assert (mean(values) is None) == (not values)


@given(points)
def test_rounding_moves_by_half_a_hundredth_and_makes_nothing_full(value: float) -> None:
    assert abs(round_points(value) - value) <= 0.01
    assert (round_points(value) == FULL_POINTS) == (value >= FULL_POINTS - 1e-9)
    assert float(format_points(value).replace(",", ".")) == round_points(value)
    assert "." not in format_points(value)


def test_rounding_examples() -> None:
    assert [format_points(one) for one in (12.345, 12.5, 20.0, 19.996, 0.0, 0.004, 10.0)] == [
        "12,35", "12,5", "20", "19,99", "0", "0", "10",
    ]  # fmt: skip
