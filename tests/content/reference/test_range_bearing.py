"""Extended and unscented filters and particles on one nonlinear problem: Jacobians, angles, agreement, consistency."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2, multivariate_normal

from reference.errors import InvalidArgumentError
from reference.filters.bayes import BayesFilter
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.gaussian import compute_gain, joseph_update
from reference.filters.models import log_normal
from reference.filters.moments import subtract_vectors, weighted_covariance, weighted_mean
from reference.filters.particles import ParticleFilter
from reference.filters.range_bearing import RangeBearingModel
from reference.filters.unscented import SigmaPoints, UnscentedKalmanFilter, UnscentedParameters

LANDMARKS = np.array([[4.0, 1.0], [-2.0, 5.0], [1.0, -4.0]])
MODEL = RangeBearingModel(LANDMARKS, advance_sigma=0.05, turn_sigma=0.03, range_sigma=0.15, bearing_sigma=0.04)
START, SPREAD = np.array([0.0, 0.0, 3.0]), np.diag([0.2, 0.2, 0.1]) ** 2
STEPS = 25

coordinates = st.floats(-20.0, 20.0)
headings = st.floats(-math.pi, math.pi)


def drive(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Controls (n, 2), true states (n, 3) and measurements (n, 6): round and round, across the cut of the headings."""
    rng = np.random.default_rng(seed)
    state = rng.multivariate_normal(START, SPREAD)
    controls = np.tile([0.4, 0.25], (STEPS, 1))
    states = np.array([state := MODEL.sample_motion(state[None, :], control, rng)[0] for control in controls])
    noise = rng.multivariate_normal(np.zeros(6), MODEL.measurement_noise, size=STEPS)
    return controls, states, MODEL.observe(states) + noise


def run(robot: BayesFilter[np.ndarray, np.ndarray], seed: int) -> np.ndarray:
    """The means after each step (n, 3)."""
    controls, _, measurements = drive(seed)
    means = []
    for control, measurement in zip(controls, measurements, strict=True):
        robot.predict(control)
        robot.correct(measurement)
        means.append(robot.mean)
    return np.array(means)


def extended() -> ExtendedKalmanFilter:
    return ExtendedKalmanFilter(MODEL, START, SPREAD)


def unscented() -> UnscentedKalmanFilter:
    return UnscentedKalmanFilter(MODEL, START, SPREAD)


def particles(seed: int, count: int = 3000) -> ParticleFilter[np.ndarray]:
    rng = np.random.default_rng(seed)
    return ParticleFilter(MODEL, rng.multivariate_normal(START, SPREAD, size=count), rng)


def slopes(function: object, at: np.ndarray, angles: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """The derivative (m, d) by central differences."""
    columns = [
        subtract_vectors(function(at + step * axis), function(at - step * axis), angles) / (2 * step)  # type: ignore[operator]
        for axis in np.eye(at.size)
    ]
    return np.column_stack(columns)


@given(coordinates, coordinates, headings, st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_jacobians_are_finite_differences(x: float, y: float, heading: float, advance: float, turn: float) -> None:
    state, control = np.array([x, y, heading]), np.array([advance, turn])
    by_state, by_noise = MODEL.move_jacobians(state, control)

    def moved(at: np.ndarray) -> np.ndarray:
        return MODEL.move(at[None, :3], control, at[None, 3:])[0]

    found = slopes(moved, np.concatenate([state, np.zeros(2)]), MODEL.state_angles)
    assert np.allclose(np.hstack([by_state, by_noise]), found, atol=1e-7)
    if np.min(np.hypot(*(LANDMARKS - state[:2]).T)) > 0.3:
        seen = slopes(lambda at: MODEL.observe(at[None, :])[0], state, MODEL.measurement_angles)
        assert np.allclose(MODEL.observe_jacobian(state), seen, atol=1e-6)


def test_bearings_are_compared_the_short_way_round() -> None:
    """A landmark straight behind, seen at 179 degrees and expected at -179: two degrees of surprise, not 358."""
    model = RangeBearingModel(
        [[-5.0, 0.0]], advance_sigma=0.1, turn_sigma=0.1, range_sigma=0.1, bearing_sigma=math.radians(2.0)
    )
    tilt = math.radians(1.0)
    for make in (ExtendedKalmanFilter, UnscentedKalmanFilter):
        robot = make(model, [0.0, 0.0, -tilt], np.diag([1e-4, 1e-4, 0.01]))
        robot.correct([5.0, math.radians(179.0)])
        assert robot.innovation is not None
        assert abs(robot.innovation.difference[1]) == pytest.approx(math.radians(2.0), abs=1e-3)
        assert 0.0 < robot.mean[2] < tilt * 1.01


@pytest.mark.parametrize("seed", range(3))
def test_the_three_filters_agree(seed: int) -> None:
    reference = run(particles(100 + seed), seed)
    sigma = np.array([0.06, 0.06, 0.03])
    for robot in (extended(), unscented()):
        assert np.all(np.abs(subtract_vectors(run(robot, seed), reference, MODEL.state_angles)) < 3.0 * sigma)


@pytest.mark.parametrize("make", [extended, unscented])
def test_errors_are_as_large_as_the_covariance_says(make: object) -> None:
    """NEES and NIS summed over 25 independent runs, at the last step, within the 99.9 % interval of chi2."""
    runs, nees, nis = 25, 0.0, 0.0
    for seed in range(runs):
        robot = make()  # type: ignore[operator]
        run(robot, seed)
        nees += robot.nees(drive(seed)[1][-1])
        nis += robot.innovation.nis
    assert chi2.ppf(0.0005, 3 * runs) < nees < chi2.ppf(0.9995, 3 * runs)
    assert chi2.ppf(0.0005, 6 * runs) < nis < chi2.ppf(0.9995, 6 * runs)


def test_the_unscented_transform_is_exact_for_quadratics() -> None:
    """Mean of x^T A x is mu^T A mu + trace(A P), which linearisation misses."""
    rng = np.random.default_rng(0)
    mean, root, A = rng.normal(size=4), rng.normal(size=(4, 4)), rng.normal(size=(4, 4))
    sigma = SigmaPoints.from_gaussian(mean, root @ root.T, UnscentedParameters(alpha=0.7, kappa=0.5))
    values = np.einsum("ni,ij,nj->n", sigma.points, A, sigma.points)
    assert sigma.mean_weights @ values == pytest.approx(mean @ A @ mean + np.trace(A @ root @ root.T))
    away = sigma.points - mean
    assert np.allclose((sigma.covariance_weights[:, None] * away).T @ away, root @ root.T)


@given(st.integers(0, 2**32 - 1))
def test_the_form_of_joseph_is_the_short_form_for_the_best_gain_and_positive_for_any(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root, H, noise = rng.normal(size=(4, 4)), rng.normal(size=(2, 4)), rng.normal(size=(2, 2))
    P, R = root @ root.T, noise @ noise.T + 0.1 * np.eye(2)
    K = compute_gain(P @ H.T, H @ P @ H.T + R)
    assert np.allclose(joseph_update(P, K, H, R), (np.eye(4) - K @ H) @ P, atol=1e-9 * np.abs(P).max())
    other = joseph_update(P, K + rng.normal(size=K.shape), H, R)
    assert np.linalg.eigvalsh(other)[0] > -1e-10 * np.abs(other).max()
    assert np.trace(other) >= np.trace(joseph_update(P, K, H, R)) - 1e-9


def test_the_form_of_joseph_survives_rounding_where_the_short_one_does_not() -> None:
    """A very sure measurement of a very unsure x + y leaves it the variance r, and (x + y) / sqrt 2 half of that."""
    c, r = np.array([1.0, 0.9, 0.3]), 1e-10
    P, H, R = 1e6 * np.outer(c, c) + 1e-2 * np.eye(3), np.array([[1.0, 1.0, 0.0]]), np.array([[r]])
    K = compute_gain(P @ H.T, H @ P @ H.T + R)
    short = (np.eye(3) - K @ H) @ P
    assert np.linalg.eigvalsh(joseph_update(P, K, H, R))[0] == pytest.approx(r / 2, rel=1e-3)
    assert np.linalg.eigvalsh(0.5 * (short + short.T))[0] < 0.1 * r


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_log_densities_are_those_of_scipy(seed: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(m, m))
    covariance = root @ root.T + 0.1 * np.eye(m)
    points = rng.normal(size=(5, m))
    expected = multivariate_normal.logpdf(points, np.zeros(m), covariance)
    assert np.allclose(log_normal(points, covariance), expected)


def test_means_of_headings_go_round_the_circle() -> None:
    vectors = np.array([[1.0, math.pi - 0.1], [3.0, -math.pi + 0.3]])
    weights, angles = np.array([0.5, 0.5]), np.array([False, True])
    mean = weighted_mean(vectors, weights, angles)
    assert mean[0] == 2.0
    assert mean[1] == pytest.approx(-math.pi + 0.1)
    assert weighted_covariance(vectors, weights, mean, angles)[1, 1] == pytest.approx(0.04)


def test_input_without_meaning_is_named() -> None:
    sigmas = {"advance_sigma": 0.1, "turn_sigma": 0.1, "range_sigma": 0.1, "bearing_sigma": 0.1}
    singular = RangeBearingModel(LANDMARKS, **sigmas)
    singular.measurement_noise = np.zeros((6, 6))
    for argument, call in (
        ("landmarks", lambda: RangeBearingModel(np.empty((0, 2)), **sigmas)),
        ("range_sigma", lambda: RangeBearingModel(LANDMARKS, **{**sigmas, "range_sigma": 0.0})),
        ("state", lambda: MODEL.observe_jacobian(np.array([*LANDMARKS[0], 0.0]))),
        ("measurement_noise", lambda: ExtendedKalmanFilter(singular, START, np.zeros((3, 3))).correct(np.ones(6))),
        ("kappa", lambda: SigmaPoints.from_gaussian(np.zeros(2), np.eye(2), UnscentedParameters(kappa=-2.0))),
        ("covariance", lambda: log_normal(np.zeros(2), np.zeros((2, 2)))),
    ):
        with pytest.raises(InvalidArgumentError) as refusal:
            call()
        assert refusal.value.argument == argument
