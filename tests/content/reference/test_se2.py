"""SE(2): against homogeneous matrices as an independent oracle, and the group's laws."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, logm

from reference.se2 import (
    PoseError,
    adjoint,
    compose,
    compose_covariance,
    compose_jacobians,
    exp,
    from_matrix,
    inverse,
    inverse_covariance,
    inverse_jacobian,
    log,
    relative,
    relative_covariance,
    relative_jacobians,
    rotation_matrix,
    to_matrix,
    transform,
    wrap_angle,
)

coordinates = st.floats(-1e3, 1e3)
angles = st.floats(-math.pi, math.pi)
poses = st.tuples(coordinates, coordinates, angles).map(np.array)
near = st.tuples(st.floats(-5, 5), st.floats(-5, 5), angles).map(np.array)
twists = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1)).map(np.array)


def matrix(pose: np.ndarray) -> np.ndarray:
    result = np.eye(3)
    result[:2, :2] = rotation_matrix(pose[2])
    result[:2, 2] = pose[:2]
    return result


def assert_same_pose(left: np.ndarray, right: np.ndarray) -> None:
    assert np.allclose(left[:2], right[:2], atol=1e-9)
    assert abs(math.remainder(left[2] - right[2], math.tau)) < 1e-9


@given(poses, poses)
def test_composition_is_the_product_of_matrices(a: np.ndarray, b: np.ndarray) -> None:
    assert np.allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-9)


@given(poses)
def test_inverse_is_the_inverse_matrix(a: np.ndarray) -> None:
    assert np.allclose(matrix(inverse(a)), np.linalg.inv(matrix(a)), atol=1e-8)


@given(poses, poses)
def test_relative_undoes_composition(a: np.ndarray, b: np.ndarray) -> None:
    assert_same_pose(compose(a, relative(a, b)), b)
    assert_same_pose(relative(a, compose(a, b)), b)


@given(poses, poses, poses)
def test_composition_is_associative(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    assert_same_pose(compose(compose(a, b), c), compose(a, compose(b, c)))


@given(st.floats(-50, 50))
def test_wrapped_angle_is_the_same_direction_in_the_half_open_interval(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-12)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-12)


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(math.pi, math.pi), (-math.pi, math.pi), (3 * math.pi, math.pi), (0, 0)]
)
def test_half_turn_is_written_pi(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-15)


def test_wrapping_works_on_arrays() -> None:
    assert np.allclose(wrap_angle(np.array([0.0, 4.0, -4.0])), [0.0, 4.0 - math.tau, math.tau - 4.0])


def test_example_of_the_course() -> None:
    assert np.allclose(compose([1, 2, math.pi / 2], [1, 0, 0]), [1, 3, math.pi / 2])


def generator(twist: np.ndarray) -> np.ndarray:
    vx, vy, w = twist
    return np.array([[0.0, -w, vx], [w, 0.0, vy], [0.0, 0.0, 0.0]])


def numeric_jacobian(function: Any, at: np.ndarray) -> np.ndarray:
    """Central differences, angles compared around the circle."""
    h, columns = 1e-6, []
    for k in range(len(at)):
        step = h * np.eye(len(at))[k]
        gap = function(at + step) - function(at - step)
        gap[2] = math.remainder(gap[2], math.tau)
        columns.append(gap / (2 * h))
    return np.column_stack(columns)


def random_covariance(rng: np.random.Generator, size: int = 3, scale: float = 1.0) -> np.ndarray:
    root = scale * rng.normal(size=(size, size))
    return np.asarray(root @ root.T)


@given(st.floats(-3.1415, math.pi))
def test_an_angle_in_its_place_keeps_every_digit(angle: float) -> None:
    assert wrap_angle(angle) == angle
    assert wrap_angle(np.array([angle, 7.0]))[0] == angle


@given(st.floats(-1e9, 1e9))
def test_no_rounding_leads_out_of_the_interval(angle: float) -> None:
    for near_a_turn in (angle, math.pi * round(angle), math.nextafter(math.pi * round(angle), 0)):
        wrapped = wrap_angle(np.array([near_a_turn]))
        assert -math.pi < wrapped[0] <= math.pi
        assert wrap_angle(wrapped)[0] == wrapped[0]


@given(st.lists(poses, min_size=1, max_size=4), poses)
def test_many_poses_are_composed_as_one_is(many: list[np.ndarray], one: np.ndarray) -> None:
    rows = np.array(many)
    for function in (compose, relative):
        assert np.array_equal(function(one, rows), [function(one, row) for row in rows])
        assert np.array_equal(function(rows, one), [function(row, one) for row in rows])
    for alone in (inverse, log, exp, to_matrix, adjoint, inverse_jacobian):
        np.testing.assert_allclose(alone(rows), [alone(row) for row in rows], rtol=1e-13)
    stacked = compose_jacobians(rows, one)
    np.testing.assert_allclose(stacked[0], [compose_jacobians(row, one)[0] for row in rows], rtol=1e-13)
    np.testing.assert_allclose(np.broadcast_to(stacked[1], (len(rows), 3, 3))[-1], compose_jacobians(many[-1], one)[1])


@given(poses)
def test_matrices_there_and_back(a: np.ndarray) -> None:
    np.testing.assert_allclose(to_matrix(a), matrix(a), atol=1e-15)
    assert_same_pose(from_matrix(to_matrix(a)), a)


@given(poses, st.tuples(coordinates, coordinates))
def test_points_follow_their_frame(a: np.ndarray, point: tuple[float, float]) -> None:
    np.testing.assert_allclose(transform(a, [point])[0], (matrix(a) @ [*point, 1.0])[:2], atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(twists)
def test_the_exponential_is_that_of_matrices(twist: np.ndarray) -> None:
    np.testing.assert_allclose(to_matrix(exp(twist)), expm(generator(twist)), atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(twists.filter(lambda twist: abs(twist[2]) < 3.0))
def test_the_logarithm_is_that_of_matrices(twist: np.ndarray) -> None:
    np.testing.assert_allclose(generator(log(exp(twist))), np.real(logm(expm(generator(twist)))), atol=1e-7)


@given(near)
def test_exponential_and_logarithm_undo_each_other(a: np.ndarray) -> None:
    assert_same_pose(exp(log(a)), a)


@pytest.mark.parametrize("w", [0.0, 1e-300, 1e-12, 1e-8, 1e-4, -1e-6])
def test_the_exponential_loses_nothing_near_a_straight_line(w: float) -> None:
    """By its series: x = v (1 - w^2/6), y = v (w/2 - w^3/24), all that is left being below 1e-16."""
    reached = exp([2.0, 0.0, w])
    np.testing.assert_allclose(reached, [2 * (1 - w * w / 6), 2 * (w / 2 - w**3 / 24), w], rtol=1e-15)
    np.testing.assert_allclose(log(reached), [2.0, 0.0, w], rtol=1e-15, atol=1e-16)


def test_half_a_turn_along_a_circle_of_radius_one() -> None:
    assert_same_pose(exp([math.pi, 0.0, math.pi]), np.array([0.0, 2.0, math.pi]))
    np.testing.assert_allclose(log([0.0, 2.0, math.pi]), [math.pi, 0.0, math.pi], atol=1e-12)


@given(near, twists)
def test_the_adjoint_carries_twists_from_frame_to_frame(a: np.ndarray, twist: np.ndarray) -> None:
    assert_same_pose(compose(compose(a, exp(twist)), inverse(a)), exp(adjoint(a) @ twist))


@given(near, near)
def test_jacobians_are_those_of_finite_differences(a: np.ndarray, b: np.ndarray) -> None:
    for function, analytic in ((compose, compose_jacobians(a, b)), (relative, relative_jacobians(a, b))):
        np.testing.assert_allclose(analytic[0], numeric_jacobian(lambda p, f=function: f(p, b), a), atol=1e-7)
        np.testing.assert_allclose(analytic[1], numeric_jacobian(lambda p, f=function: f(a, p), b), atol=1e-7)
    np.testing.assert_allclose(inverse_jacobian(a), numeric_jacobian(inverse, a), atol=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_covariances_are_those_of_samples(seed: int) -> None:
    """200,000 small errors: each entry within 6 standard deviations of its estimate."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-3, 3, 3), rng.uniform(-3, 3, 3)
    joint = random_covariance(rng, 6, 1e-4)
    S_a, S_b, n = joint[:3, :3], joint[3:, 3:], 200_000
    errors_a, errors_b = rng.multivariate_normal(np.zeros(3), S_a, n), rng.multivariate_normal(np.zeros(3), S_b, n)
    both = rng.multivariate_normal(np.zeros(6), joint, n)
    cases = [
        (compose(a + errors_a, b + errors_b), compose(a, b), compose_covariance(a, S_a, b, S_b)),
        (inverse(a + errors_a), inverse(a), inverse_covariance(a, S_a)),
        (relative(a + both[:, :3], b + both[:, 3:]), relative(a, b), relative_covariance(a, b, joint)),
    ]
    for samples, centre, predicted in cases:
        gaps = samples - centre
        gaps[:, 2] = wrap_angle(gaps[:, 2])
        spread = np.sqrt((predicted**2 + np.outer(np.diag(predicted), np.diag(predicted))) / n)
        assert np.all(np.abs(gaps.T @ gaps / n - predicted) < 6 * spread)


def test_a_pose_is_sure_of_itself() -> None:
    """Fully correlated with itself, a pose has no uncertainty with respect to itself."""
    S = random_covariance(np.random.default_rng(5))
    a = np.array([1.0, -2.0, 0.7])
    np.testing.assert_allclose(relative_covariance(a, a, np.block([[S, S], [S, S]])), 0, atol=1e-12)


EYE, ZERO = np.eye(3), np.zeros(3)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("T_a_b", lambda: compose([1.0, 2.0], ZERO)),
        ("T_b_c", lambda: compose(ZERO, [1.0, 2.0, math.nan])),
        ("T_a_b", lambda: inverse(1.0)),
        ("T_a_c", lambda: relative(ZERO, [[0.0, math.inf, 0.0]])),
        ("points_b", lambda: transform(ZERO, [1.0, 2.0])),
        ("T_a_b", lambda: transform(np.zeros((2, 3)), [[1.0, 2.0]])),
        ("twist", lambda: exp(np.zeros((3, 2)))),
        ("matrices", lambda: from_matrix(2 * EYE)),
        ("matrices", lambda: from_matrix(np.diag([1.0, -1.0, 1.0]))),
        ("matrices", lambda: from_matrix(EYE[:2])),
        ("matrices", lambda: from_matrix(EYE + 0.1 * np.eye(3, k=-2))),
        ("cov_a_b", lambda: compose_covariance(ZERO, -EYE, ZERO, EYE)),
        ("cov_b_c", lambda: compose_covariance(ZERO, EYE, ZERO, EYE[:2])),
        ("cov_a_b", lambda: inverse_covariance(ZERO, EYE * math.nan)),
        ("cov_a_b", lambda: inverse_covariance(ZERO, np.triu(np.ones((3, 3))))),
        ("joint_covariance", lambda: relative_covariance(ZERO, ZERO, EYE)),
    ],
)
def test_what_is_no_pose_is_named(argument: str, call: Any) -> None:
    with pytest.raises(PoseError) as error:
        call()
    assert error.value.argument == argument
