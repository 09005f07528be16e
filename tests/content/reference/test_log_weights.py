"""Log weights: against SciPy's logsumexp, far below the smallest float, and without meaning."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import logsumexp, softmax

from reference.filters.log_weights import normalise_log_weights
from reference.filters.resampling import InvalidWeightsError, effective_sample_size

logs = st.lists(st.floats(-1e5, 1e5), min_size=1, max_size=50)


@given(logs)
def test_weights_and_sum_are_those_of_scipy(values: list[float]) -> None:
    found = normalise_log_weights(values)
    assert np.allclose(found.weights, softmax(values), rtol=1e-12, atol=0.0)
    assert math.isclose(found.log_sum, logsumexp(values), rel_tol=1e-12, abs_tol=1e-12)
    assert math.isclose(found.weights.sum(), 1.0)


@given(st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=50), st.floats(-1e6, 1e6))
def test_a_common_factor_changes_the_sum_only(values: list[float], shift: float) -> None:
    moved = normalise_log_weights(np.array(values) + shift)
    assert np.allclose(moved.weights, normalise_log_weights(values).weights, atol=1e-9)
    assert math.isclose(moved.log_sum, normalise_log_weights(values).log_sum + shift, rel_tol=1e-9, abs_tol=1e-6)


def test_weights_that_underflow_as_products_survive_as_sums() -> None:
    """360 beams of likelihood 1e-3 and 2e-3: both products are zero in floating point, their ratio is 2^360."""
    one, other = np.full(360, 1e-3), np.full(360, 2e-3)
    assert np.prod(one) == np.prod(other) == 0.0
    found = normalise_log_weights([np.log(one).sum(), np.log(other).sum()])
    assert found.weights[1] / found.weights[0] == pytest.approx(2.0**360, rel=1e-9)


def test_an_impossible_particle_has_no_weight() -> None:
    found = normalise_log_weights([-np.inf, -2000.0, -2000.0])
    assert found.weights.tolist() == [0.0, 0.5, 0.5]
    assert effective_sample_size(found.weights) == 2.0


@pytest.mark.parametrize("values", [[], [[0.0]], [-np.inf, -np.inf], [0.0, math.nan], [math.inf, 0.0]])
def test_log_weights_without_meaning_are_refused(values: object) -> None:
    with pytest.raises(InvalidWeightsError) as refusal:
        normalise_log_weights(values)  # type: ignore[arg-type]
    assert refusal.value.argument == "weights"
