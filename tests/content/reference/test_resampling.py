"""Resampling: against brute force, an independent search, exact expectations, and degenerate weights."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from reference.errors import InvalidArgumentError
from reference.filters.resampling import (
    InvalidOffsetError,
    InvalidWeightsError,
    Scheme,
    comb_resampling,
    effective_sample_size,
    multinomial_resampling,
    residual_resampling,
    stratified_resampling,
    systematic_resampling,
)

SCHEMES: list[Scheme] = [systematic_resampling, stratified_resampling, residual_resampling, multinomial_resampling]

weight_lists = st.lists(st.integers(0, 12), min_size=1, max_size=40).filter(any)
sixteenths = st.integers(0, 15)
LAST_OFFSET = 1.0 - 2.0**-53


def exact_copies(weights: list[int], offset: Fraction) -> list[int]:
    """By definition, in exact arithmetic: tooth m falls in [n C_(i-1), n C_i[."""
    n, total = len(weights), sum(weights)
    ends = [Fraction(n * sum(weights[: i + 1]), total) for i in range(n)]
    ancestors = [next(i for i, end in enumerate(ends) if m + offset < end) for m in range(n)]
    return [ancestors.count(i) for i in range(n)]


@given(weight_lists, sixteenths)
def test_copies_are_those_of_the_definition(weights: list[int], k: int) -> None:
    # A sum that is a power of two keeps the floats exact, teeth on boundaries included.
    padded = [*weights, (1 << sum(weights).bit_length()) - sum(weights)]
    padded += [0] * ((1 << len(padded).bit_length()) - len(padded))
    assert comb_resampling(padded, k / 16).copies.tolist() == exact_copies(padded, Fraction(k, 16))


@given(weight_lists, st.floats(1e-6, 1.0 - 1e-6))
def test_ancestors_are_those_that_a_search_finds(weights: list[int], offset: float) -> None:
    n = len(weights)
    ends = np.cumsum(weights) / np.sum(weights)
    teeth = (np.arange(n) + offset) / n
    if np.min(np.abs(teeth[:, None] - ends[None, :])) > 1e-12:
        assert comb_resampling(weights, offset).ancestors.tolist() == np.searchsorted(ends, teeth).tolist()


@given(
    st.lists(st.floats(0.0, 1e6), min_size=1, max_size=60).filter(lambda w: sum(w) > 1e-3), st.floats(0.0, LAST_OFFSET)
)
@example([1.0, 0.0, 0.0], LAST_OFFSET)
@example([0.0, 0.0, 1.0], 0.0)
@example([0.1] * 10, LAST_OFFSET)
@example([0.1] * 10, 0.0)
def test_every_particle_has_the_floor_or_the_ceil_of_its_share(weights: list[float], offset: float) -> None:
    found = comb_resampling(weights, offset)
    shares = len(weights) * np.array(weights) / sum(weights)
    assert found.copies.sum() == found.ancestors.size == len(weights)
    assert np.all(np.diff(found.ancestors) >= 0)
    assert np.all(found.copies >= np.floor(shares - 1e-9))
    assert np.all(found.copies <= np.ceil(shares + 1e-9))
    assert np.all(found.copies[np.array(weights) == 0.0] == 0)


@given(weight_lists)
def test_copies_average_to_the_share_over_all_offsets(weights: list[int]) -> None:
    """The mean over the offset of a step function whose steps lie at the fractional parts of n C_i."""
    n, total = len(weights), sum(weights)
    steps = sorted({Fraction(n * sum(weights[:i]), total) % 1 for i in range(n)} | {Fraction(0), Fraction(1)})
    mean = np.zeros(n)
    for low, high in pairwise(steps):
        mean += float(high - low) * comb_resampling(weights, float((low + high) / 2)).copies
    assert np.allclose(mean, n * np.array(weights) / total, atol=1e-9)


@given(st.integers(1, 400), st.floats(1e-9, 1.0 - 1e-9))
def test_equal_weights_keep_every_particle(n: int, offset: float) -> None:
    assert comb_resampling(np.full(n, 1.0 / n), offset).copies.tolist() == [1] * n


def test_a_million_particles_whose_sum_falls_short_of_one() -> None:
    weights = np.full(1_000_000, 1e-6)
    weights[-1] = 0.0
    assert np.cumsum(weights)[-1] < 1.0
    for offset in (0.0, 0.5, LAST_OFFSET):
        found = comb_resampling(weights, offset)
        assert found.ancestors.size == found.copies.sum() == 1_000_000
        assert found.ancestors[-1] == 999_998


def test_one_draw_decides_everything() -> None:
    weights = np.array([0.1, 0.2, 0.3, 0.4])
    ours, theirs = np.random.default_rng(5), np.random.default_rng(5)
    assert np.array_equal(
        systematic_resampling(weights, ours).ancestors, comb_resampling(weights, theirs.random()).ancestors
    )
    assert ours.random() == theirs.random()


@pytest.mark.parametrize("scale", [5e-324, 1e-300, 1e300])
def test_weights_of_any_size(scale: float) -> None:
    assert comb_resampling(np.array([2.0, 1.0, 1.0, 0.0]) * scale, 0.4).copies.tolist() == [2, 1, 1, 0]
    assert effective_sample_size(np.array([2.0, 2.0, 0.0]) * scale) == pytest.approx(2.0)


def test_the_weights_are_left_alone() -> None:
    weights = np.array([0.5, 0.25, 0.25])
    comb_resampling(weights, 0.3)
    effective_sample_size(weights)
    assert weights.tolist() == [0.5, 0.25, 0.25]


@given(weight_lists)
def test_effective_sample_size_against_exact_fractions(weights: list[int]) -> None:
    exact = Fraction(sum(weights) ** 2, sum(w * w for w in weights))
    assert math.isclose(effective_sample_size(weights), exact, rel_tol=1e-12)
    assert 1.0 - 1e-12 <= effective_sample_size(weights) <= len(weights) * (1.0 + 1e-12)


@pytest.mark.parametrize(
    "weights",
    [
        [],
        [[1.0]],
        1.0,
        [0.0, 0.0],
        [0.5, math.nan],
        [math.nan],
        [1.5, -0.5],
        [math.inf, 1.0],
        [1e308] * 3,
    ],
)
def test_weights_that_mean_nothing_are_refused_by_name(weights: object) -> None:
    for function in (effective_sample_size, lambda w: comb_resampling(w, 0.5)):
        with np.errstate(over="ignore"), pytest.raises(InvalidWeightsError) as refusal:
            function(weights)
        assert refusal.value.argument == "weights"


@pytest.mark.parametrize("offset", [-1e-9, 1.0, math.nan])
def test_offsets_outside_of_a_tooth_are_refused_by_name(offset: float) -> None:
    with pytest.raises(InvalidOffsetError) as refusal:
        comb_resampling([1.0, 1.0], offset)
    assert refusal.value.argument == "offset"


@pytest.mark.parametrize("scheme", SCHEMES)
def test_lengths_are_right_for_every_size(scheme: Scheme) -> None:
    rng = np.random.default_rng(17)
    for n in range(1, 2001):
        weights = rng.random(n) * (rng.random(n) < 0.7)
        weights[rng.integers(n)] = 0.5
        found = scheme(weights, rng, None)
        assert found.ancestors.size == n
        assert found.ancestors[0] >= 0
        assert weights[found.ancestors].min() > 0.0
        assert np.all(np.diff(found.ancestors) >= 0)


@pytest.mark.parametrize("count", [1, 3, 7, 40, 1000])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_scheme_is_unbiased(scheme: Scheme, count: int) -> None:
    """Over 3000 seeded runs the mean copies stay within 5 standard errors of count w (multinomial, the widest)."""
    weights, runs = np.array([0.3, 0.0, 1e-3, 0.05, 0.449, 0.2]), 3000
    rng = np.random.default_rng(count)
    copies = np.array([scheme(7.0 * weights, rng, count).copies for _ in range(runs)])
    assert np.all(copies.sum(axis=1) == count)
    spread = np.sqrt(count * weights * (1.0 - weights) / runs)
    assert np.all(np.abs(copies.mean(axis=0) - count * weights) <= 5.0 * spread + 1e-12)


class _Offsets(np.random.Generator):
    """A generator whose uniform numbers are given."""

    def __init__(self, values: list[float]) -> None:
        super().__init__(np.random.PCG64(0))
        self.values = values

    def random(self, size: int | None = None) -> np.ndarray:  # type: ignore[override]
        assert size == len(self.values)
        return np.array(self.values)


@given(weight_lists, st.data())
def test_stratified_copies_are_those_that_a_search_finds(weights: list[int], data: st.DataObject) -> None:
    n, exponent = len(weights), 10
    offsets = data.draw(st.lists(st.integers(0, 2**exponent - 1), min_size=n, max_size=n))
    ends = [Fraction(n * sum(weights[: i + 1]), sum(weights)) for i in range(n)]
    # Away from the boundaries, where rounding may choose.
    teeth = [m + Fraction(2 * k + 1, 2 ** (exponent + 1)) for m, k in enumerate(offsets)]
    expected = [next(i for i, end in enumerate(ends) if tooth < end) for tooth in teeth]
    if min(abs(tooth - end) for tooth in teeth for end in ends) > Fraction(1, 10**9):
        rng = _Offsets([float(tooth % 1) for tooth in teeth])
        assert stratified_resampling(weights, rng).ancestors.tolist() == expected


def test_the_expected_copies_of_a_stratified_draw_are_the_shares() -> None:
    """The mean of (2) over the two offsets that matter, by a midpoint rule that is exact here."""
    weights = np.array([5.0, 1.0, 2.0])
    grid = (np.arange(64) + 0.5) / 64
    copies = np.zeros(3)
    for first in grid:
        for second in grid:
            copies += stratified_resampling(weights, _Offsets([0.5, first, second])).copies / 64**2
    assert np.allclose(copies, 3 * weights / 8)


@given(weight_lists, st.integers(1, 90), st.integers(0, 2**32 - 1))
def test_residual_copies_are_never_below_the_whole_part(weights: list[int], count: int, seed: int) -> None:
    found = residual_resampling(weights, np.random.default_rng(seed), count)
    assert found.copies.sum() == count
    for copies, weight in zip(found.copies.tolist(), weights, strict=True):
        assert copies >= count * weight // sum(weights)


def test_schemes_spread_as_theory_orders_them() -> None:
    """The variance of the resampled mean of a smooth function is least for comb and strata."""
    rng = np.random.default_rng(2)
    states = np.sort(rng.normal(size=200))
    weights = np.exp(-0.5 * (states - 0.4) ** 2 / 0.5)
    spread = {
        scheme.__name__: np.var([states[scheme(weights, rng, None).ancestors].mean() for _ in range(800)])
        for scheme in SCHEMES
    }
    assert spread["systematic_resampling"] < 0.1 * spread["multinomial_resampling"]
    assert spread["stratified_resampling"] < 0.1 * spread["multinomial_resampling"]
    assert spread["residual_resampling"] < spread["multinomial_resampling"]


def test_large_sets_are_the_same_as_one_search() -> None:
    """Over many blocks, in skewed and in even company, no tooth moves but those on a boundary."""
    rng = np.random.default_rng(8)
    for weights in (rng.random(200_000), rng.random(200_000) ** 60, np.r_[np.zeros(70_000), 1.0, np.zeros(70_000)]):
        ends = np.cumsum(weights) / weights.sum() * weights.size
        teeth = np.arange(weights.size) + 0.37
        expected = np.searchsorted(ends, teeth)
        found = comb_resampling(weights, 0.37).ancestors
        moved = np.flatnonzero(found != expected)
        assert all(np.min(np.abs(ends - teeth[m])) < 1e-6 for m in moved)
        assert moved.size < 5


@pytest.mark.parametrize("k", [0, 5, 15])
def test_large_sets_keep_the_teeth_that_fall_on_boundaries(k: int) -> None:
    """Whole numbers that sum to twice their count, a power of two: nothing rounds, and many teeth are on boundaries."""
    n = 2**18
    weights = np.random.default_rng(k).permutation(np.repeat([0, 1, 3, 4], n // 4))
    ends = np.cumsum(weights) / 2
    assert (
        comb_resampling(weights, k / 16).ancestors.tolist()
        == np.searchsorted(ends, np.arange(n) + k / 16, "right").tolist()
    )


@pytest.mark.parametrize("scheme", SCHEMES)
def test_counts_and_weights_without_meaning_are_refused(scheme: Scheme) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(InvalidArgumentError) as refusal:
        scheme([1.0, 2.0], rng, 0)
    assert refusal.value.argument == "count"
    for weights in ([0.0, 0.0], [math.nan, 1.0], [-1.0, 2.0], []):
        with pytest.raises(InvalidWeightsError):
            scheme(weights, rng, None)
