"""KLD-sampling: against SciPy's chi-square, against Fox's loop one draw at a time, and against what it promises."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from reference.errors import InvalidArgumentError
from reference.localisation.kld_sampling import KldSampling


@pytest.mark.parametrize("epsilon", [0.01, 0.05, 0.15])
@pytest.mark.parametrize("delta", [0.01, 0.05, 0.5])
def test_the_bound_is_half_a_quantile_of_chi_square(epsilon: float, delta: float) -> None:
    kld = KldSampling(epsilon=epsilon, delta=delta, least=1, most=10**7)
    bins = np.arange(2, 2000)
    exact = chi2.ppf(1.0 - delta, bins - 1) / (2.0 * epsilon)
    assert np.allclose(kld.particles_needed(bins)[8:], exact[8:], rtol=2e-3, atol=1.0)
    assert np.allclose(kld.particles_needed(bins), exact, rtol=0.05, atol=1.0)
    assert np.all(np.diff(kld.particles_needed(bins)) >= 0)


def test_the_bound_is_clamped() -> None:
    kld = KldSampling(least=50, most=900)
    assert kld.particles_needed(1) == 50
    assert kld.particles_needed(10_000) == 900


def loop_of_fox(kld: KldSampling, poses: np.ndarray) -> int:
    """One draw at a time, as published."""
    filled: set[tuple[int, ...]] = set()
    for m, pose in enumerate(poses, start=1):
        filled.add(tuple(kld.bin_indices(pose[None, :])[0].tolist()))
        if m >= kld.particles_needed(len(filled)):
            return m
    return len(poses)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 3.0))
def test_counting_all_at_once_is_counting_one_by_one(seed: int, spread: float) -> None:
    kld = KldSampling(epsilon=0.3, delta=0.1, least=5, most=400)
    poses = np.random.default_rng(seed).normal(0.0, spread, (150, 3))
    assert kld.count_needed_poses(poses) == loop_of_fox(kld, poses)


def test_a_gathered_belief_needs_fewer_particles_than_a_scattered_one() -> None:
    rng, kld = np.random.default_rng(1), KldSampling()
    counts = [kld.count_needed_poses(rng.normal([0.25, 0.25, 0.09], spread, (5000, 3))) for spread in (0.01, 0.3, 3.0)]
    assert counts[0] == kld.least
    assert counts[0] < counts[1] < counts[2]


def test_the_promise_is_kept() -> None:
    """A histogram of `particles_needed` draws is farther than epsilon from the truth in at most delta of the runs."""
    rng, bins, delta, runs = np.random.default_rng(3), 40, 0.1, 2000
    kld = KldSampling(epsilon=0.01, delta=delta, least=1)
    truth = rng.dirichlet(np.full(bins, 4.0))
    n = int(kld.particles_needed(bins))
    shares = rng.multinomial(n, truth, size=runs) / n
    divergence = np.sum(np.where(shares > 0, shares * np.log(np.maximum(shares, 1e-300) / truth), 0.0), axis=1)
    exceeded = np.mean(divergence > kld.epsilon)
    assert exceeded <= delta + 4.0 * math.sqrt(delta * (1 - delta) / runs)


def test_headings_across_the_cut_share_their_bin_with_themselves() -> None:
    kld = KldSampling()
    assert np.array_equal(kld.bin_indices([[0.1, 0.1, 3.0]]), kld.bin_indices([[0.1, 0.1, 3.0 - 2 * np.pi]]))


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("epsilon", lambda: KldSampling(epsilon=0.0)),
        ("cell", lambda: KldSampling(cell=math.nan)),
        ("sector", lambda: KldSampling(sector=-1.0)),
        ("delta", lambda: KldSampling(delta=1.0)),
        ("least", lambda: KldSampling(least=0)),
        ("least", lambda: KldSampling(least=20, most=10)),
        ("poses", lambda: KldSampling().count_needed_poses(np.empty((0, 3)))),
        ("poses", lambda: KldSampling().count_needed_poses([[0.0, math.nan, 0.0]])),
        ("poses", lambda: KldSampling().bin_indices([0.0, 0.0, 0.0])),
    ],
)
def test_input_without_meaning_is_named(argument: str, call: object) -> None:
    with pytest.raises(InvalidArgumentError) as refusal:
        call()  # type: ignore[operator]
    assert refusal.value.argument == argument
