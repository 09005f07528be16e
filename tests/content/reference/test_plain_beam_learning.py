"""EM for the beam model as the course writes it: against SciPy's optimiser on the very same likelihood."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from reference.errors import InvalidArgumentError
from reference.sensors.beam import BeamModel, plain_densities, plain_log_likelihood
from reference.sensors.plain_beam_learning import plain_em_round, plain_responsibilities

TRUTH = BeamModel(max_range=12.0, hit=0.6, short=0.2, beyond=0.08, random=0.12, sigma=0.3, rate=0.8)
START = BeamModel(12.0, 0.25, 0.25, 0.25, 0.25, 1.0, 1.0)


def told(model: BeamModel, z: np.ndarray, expected: np.ndarray) -> float:
    return plain_log_likelihood(z, expected, model.sigma, model.max_range, model.shares, model.rate)


def drawn(seed: int, count: int = 300) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    expected = rng.uniform(2.0, 9.0, count)
    return TRUTH.sample(expected, rng), expected


def of(point: np.ndarray) -> BeamModel:
    """Shares by their logarithms, up to a constant; then those of sigma and rate."""
    shares = np.exp(np.append(point[:3], 0.0))
    hit, short, beyond, random = (shares / shares.sum()).tolist()
    return BeamModel(12.0, hit, short, beyond, random, *np.exp(point[3:]).tolist())


def test_em_ends_where_an_optimiser_does() -> None:
    z, expected = drawn(1)
    model = START
    for _ in range(200):
        model = plain_em_round(model, z, expected)
    found = minimize(lambda point: -told(of(point), z, expected), np.zeros(5), method="BFGS")
    assert told(model, z, expected) == pytest.approx(-found.fun, abs=1e-4)
    other = of(found.x)
    np.testing.assert_allclose(model.shares, other.shares, atol=1e-3)
    np.testing.assert_allclose([model.sigma, model.rate], [other.sigma, other.rate], rtol=5e-3)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_a_round_never_lowers_the_likelihood_and_causes_sum_to_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    z, expected = drawn(seed, 80)
    hit, short, beyond, random = (0.02 + 0.92 * rng.dirichlet(np.ones(4))).tolist()
    model = BeamModel(12.0, hit, short, beyond, random, *np.exp(rng.uniform(-2.0, 1.0, 2)).tolist())
    for _ in range(4):
        np.testing.assert_allclose(plain_responsibilities(model, z, expected).sum(axis=0), 1.0, rtol=1e-12)
        better = plain_em_round(model, z, expected)
        assert told(better, z, expected) >= told(model, z, expected) - 1e-9
        model = better


def test_a_share_that_is_nothing_stays_so_and_what_witnesses_nothing_is_kept() -> None:
    z, expected = drawn(2)
    sure = plain_em_round(replace(START, short=0.0, random=0.5), z, expected)
    assert sure.short == 0.0
    assert sure.rate == START.rate
    alone = plain_em_round(START, [12.0, 12.0], [12.0, 12.0])
    assert alone.sigma == pytest.approx(1e-3), "a spike is held"


def test_the_causes_are_those_of_the_formula() -> None:
    hit, short, beyond, random = plain_densities(TRUTH, [2.0, 6.0, 12.0], [5.0, 5.0, 12.0])
    assert short.tolist() == pytest.approx([0.8 * np.exp(-1.6), 0.0, 0.8 * np.exp(-9.6)])
    assert beyond.tolist() == [0.0, 0.0, 1.0]
    assert random.tolist() == pytest.approx([1 / 12] * 3)
    assert hit[2] == pytest.approx(1 / (0.3 * np.sqrt(2 * np.pi)))


def test_ranges_that_cannot_be_are_refused() -> None:
    sure = replace(START, hit=1.0, short=0.0, beyond=0.0, random=0.0, sigma=0.01)
    with pytest.raises(InvalidArgumentError):
        plain_em_round(sure, [1.0], [9.0])
    with pytest.raises(InvalidArgumentError):
        plain_em_round(START, [1.0, 2.0], [9.0])
