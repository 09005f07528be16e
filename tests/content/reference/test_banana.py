"""The crescent: its exact belief against closed forms and a grid of the plane, and filters where it is straight."""

import numpy as np
import pytest
from scipy.integrate import quad

from reference.errors import InvalidArgumentError
from reference.filters.banana import Banana
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.models import GaussianModel
from reference.filters.range_bearing import RangeBearingModel, RangeModel
from reference.filters.unscented import UnscentedKalmanFilter, UnscentedParameters

WIDE = Banana(10.0, 0.3, np.radians(25.0))
LANDMARKS = [[4.0, 8.5], [12.0, -3.0]]
RANGES = RangeModel(LANDMARKS, advance_sigma=0.3, turn_sigma=0.0, range_sigma=0.3)
BOTH = RangeBearingModel(LANDMARKS, advance_sigma=0.3, turn_sigma=0.0, range_sigma=0.3, bearing_sigma=0.1)


def test_before_the_measurement_the_moments_have_closed_forms() -> None:
    belief, s = WIDE.belief(), np.radians(25.0)
    assert belief.mean == pytest.approx([10.0 * np.exp(-(s**2) / 2.0), 0.0], abs=1e-6)
    square = 100.0 + 0.09
    across = square * (1.0 - np.exp(-2.0 * s**2)) / 2.0
    along = square * (1.0 + np.exp(-2.0 * s**2)) / 2.0 - belief.mean[0] ** 2
    np.testing.assert_allclose(belief.covariance, np.diag([along, across]), atol=1e-5)


@pytest.mark.parametrize(("model", "z"), [(RANGES, [6.0, 4.6]), (BOTH, [6.0, 1.5, 4.6, -1.3])])
def test_after_it_a_grid_of_the_plane_finds_the_same(model: GaussianModel, z: list[float]) -> None:
    side = np.arange(-4.0, 13.0, 0.05)
    across = np.arange(-12.0, 12.0, 0.05)
    places = np.stack(np.meshgrid(side, across), axis=-1).reshape(-1, 2)
    density = WIDE.density(places)
    assert density.sum() * 0.05**2 == pytest.approx(1.0, abs=1e-3)
    headings = np.arctan2(places[:, 1], places[:, 0])
    logs = model.log_likelihood(np.column_stack([places, headings]), np.array(z))
    weights = density * np.exp(logs - logs.max())
    weights /= weights.sum()
    found = WIDE.belief(model, np.array(z))
    np.testing.assert_allclose(found.mean, weights @ places, atol=2e-3)
    away = places - found.mean
    np.testing.assert_allclose(found.covariance, away.T @ (weights[:, None] * away), atol=2e-3)


def test_a_density_of_the_plane_is_that_of_the_samples() -> None:
    poses = WIDE.sample(40_000, np.random.default_rng(0))
    assert poses[:, 0].mean() == pytest.approx(WIDE.belief().mean[0], abs=0.03)
    ahead = quad(lambda x: WIDE.density(np.array([[x, 0.0]]))[0] * x, 7.0, 13.0)[0]
    assert ahead == pytest.approx(1.0 / (np.radians(25.0) * np.sqrt(2.0 * np.pi)), rel=1e-6)


def test_where_the_crescent_is_straight_the_filters_are_exact() -> None:
    straight, s = Banana(10.0, 0.3, 1e-3), 1e-3
    z = RANGES.observe(np.array([[10.1, 0.004, 0.0004]]))[0]
    exact = straight.belief(RANGES, z)
    start = np.zeros(3), np.diag([0.0, 0.0, s**2])
    for belief in (
        ExtendedKalmanFilter(RANGES, *start),
        UnscentedKalmanFilter(RANGES, *start, UnscentedParameters(beta=0.0, kappa=-2.0)),
    ):
        belief.predict([10.0, 0.0])
        belief.correct(z)
        np.testing.assert_allclose(belief.mean[:2], exact.mean, atol=6e-3)
        np.testing.assert_allclose(belief.covariance[:2, :2], exact.covariance, rtol=0.05, atol=2e-5)


def test_the_exact_belief_is_honest() -> None:
    """Its NEES is 2 on average, whatever its shape: the mean of 40, with a standard error near 0.3."""
    rng = np.random.default_rng(4)
    model = RangeModel(LANDMARKS[:1], advance_sigma=0.3, turn_sigma=0.0, range_sigma=0.3)
    small = Banana(10.0, 0.3, np.radians(25.0))
    found = []
    for pose in small.sample(40, rng):
        belief = small.belief(model, model.observe(pose[None, :])[0] + rng.normal(0.0, 0.3, 1))
        away = pose[:2] - belief.mean
        found.append(away @ np.linalg.solve(belief.covariance, away))
    assert 1.0 < np.mean(found) < 3.2


def test_ranges_alone_are_the_ranges_of_both_and_their_tangent_is_right() -> None:
    poses = np.array([[1.0, 2.0, 0.3], [-3.0, 0.5, 2.0]])
    assert RANGES.observe(poses) == pytest.approx(BOTH.observe(poses)[:, [0, 2]])
    step = 1e-6
    slopes = [(RANGES.observe(poses[:1] + h) - RANGES.observe(poses[:1] - h))[0] / (2 * step) for h in step * np.eye(3)]
    np.testing.assert_allclose(RANGES.observe_jacobian(poses[0]), np.array(slopes).T, atol=1e-7)
    assert RANGES.measurement_noise.shape == (2, 2)
    assert not RANGES.measurement_angles.any()


@pytest.mark.parametrize("wrong", [(0.0, 0.3, 0.4), (10.0, -0.3, 0.4), (10.0, 0.3, np.inf), (1.0, 0.3, 0.4)])
def test_a_crescent_that_cannot_be_is_refused(wrong: tuple[float, float, float]) -> None:
    with pytest.raises(InvalidArgumentError):
        Banana(*wrong)
