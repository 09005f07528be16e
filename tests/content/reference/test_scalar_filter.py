"""The Kalman filter of a single number, against the general one, grids of densities, and simulated runs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.errors import InvalidArgumentError
from reference.filters.kalman import KalmanFilter
from reference.filters.models import LinearGaussian
from reference.filters.scalar import ScalarBelief, kalman_gain, mean_nees_band, steady_state_variance

variances = st.floats(0.01, 10.0)
places = st.floats(-5.0, 5.0)


@settings(max_examples=25, deadline=None)
@given(places, variances, places, variances, places, variances)
def test_it_is_the_general_filter(m: float, v: float, u: float, q: float, z: float, r: float) -> None:
    model = LinearGaussian(F=[[1.0]], B=[[1.0]], Q=[[q]], H=[[1.0]], R=[[r]])
    general = KalmanFilter(model, [m], [[v]])
    general.predict([u])
    general.correct([z])
    found = ScalarBelief(np.array([m, m + 1.0]), v).predict(u, q).correct(np.array([z, z]), r)
    assert found.mean[0] == pytest.approx(general.mean[0])
    assert found.variance == pytest.approx(general.covariance[0, 0])
    assert found.nees([0.3, 0.3])[0] == pytest.approx(general.nees([0.3]))


def test_correcting_is_multiplying_densities() -> None:
    x = np.linspace(-12.0, 12.0, 24_001)
    product = np.exp(-((x - 1.0) ** 2) / (2 * 0.8) - (x - 2.5) ** 2 / (2 * 0.3))
    product /= product.sum()
    found = ScalarBelief(np.array([1.0]), 0.8).correct([2.5], 0.3)
    assert found.mean[0] == pytest.approx(product @ x)
    assert found.variance == pytest.approx(product @ (x - product @ x) ** 2)
    assert found.sigma == pytest.approx(found.variance**0.5)


@given(variances, variances, st.floats(0.0, 1.0))
def test_no_gain_leaves_less_doubt_than_kalman_s(v: float, r: float, gain: float) -> None:
    belief, z = ScalarBelief(np.zeros(1), v), np.zeros(1)
    best = belief.correct(z, r)
    assert best.variance <= belief.correct(z, r, gain).variance * (1 + 1e-12)
    assert best.variance == pytest.approx(kalman_gain(v, r) * r)
    assert 1.0 / best.variance == pytest.approx(1.0 / v + 1.0 / r)


@pytest.mark.parametrize("gain", [0.1, 0.6, 1.0])
def test_any_gain_tells_the_variance_of_its_errors(gain: float) -> None:
    rng = np.random.default_rng(0)
    truth = rng.normal(0.0, 2.0, 40_000)
    found = ScalarBelief(np.zeros(40_000), 4.0).correct(truth + rng.normal(0.0, 1.5, 40_000), 2.25, gain)
    assert np.mean((found.mean - truth) ** 2) == pytest.approx(found.variance, rel=0.03)


@given(variances, variances)
def test_where_it_settles_a_step_changes_nothing(q: float, r: float) -> None:
    settled = ScalarBelief(np.zeros(1), steady_state_variance(q, r))
    assert settled.predict(0.0, q).correct([0.0], r).variance == pytest.approx(settled.variance)


def test_without_noise_in_the_motion_doubt_vanishes() -> None:
    assert steady_state_variance(0.0, 1.0) == 0.0


@pytest.mark.parametrize(("runs", "dimension"), [(50, 1), (10, 2), (1, 3)])
def test_the_band_holds_its_share_of_drawn_means(runs: int, dimension: int) -> None:
    rng = np.random.default_rng(1)
    means = (rng.standard_normal((20_000, runs, dimension)) ** 2).sum(axis=2).mean(axis=1)
    low, high = mean_nees_band(runs, dimension)
    assert np.mean(means < low) == pytest.approx(0.025, abs=0.004)
    assert np.mean(means > high) == pytest.approx(0.025, abs=0.004)


def test_what_is_no_filter_is_refused() -> None:
    for wrong in (
        lambda: ScalarBelief(np.zeros(1), -1.0),
        lambda: ScalarBelief(np.zeros(1), 1.0).predict(0.0, float("nan")),
        lambda: kalman_gain(0.0, 0.0),
        lambda: steady_state_variance(0.1, 0.0),
        lambda: mean_nees_band(0),
        lambda: mean_nees_band(5, level=1.0),
    ):
        with pytest.raises(InvalidArgumentError):
            wrong()
