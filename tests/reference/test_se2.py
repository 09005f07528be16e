"""SE(2): against homogeneous matrices as an independent oracle, and the group's laws."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.se2 import compose, inverse, relative, rotation, wrap_angle

coordinates = st.floats(-1e3, 1e3)
angles = st.floats(-math.pi, math.pi)
poses = st.tuples(coordinates, coordinates, angles).map(np.array)


def matrix(pose: np.ndarray) -> np.ndarray:
    result = np.eye(3)
    result[:2, :2] = rotation(pose[2])
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
