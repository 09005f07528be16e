"""Odometry: the course's exercise, finite differences, and the drift of simulated robots."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.odometry import (
    DifferentialDrive,
    LateralDrift,
    Motion,
    OdometryError,
    dead_reckoning,
    integrate_poses,
)
from reference.se2 import PoseError, wrap_angle

ROBOT = DifferentialDrive(track=0.3, sigma=0.001)
wheel = st.floats(-0.5, 0.5)
LEFT, RIGHT = 0.10, 0.13


def test_the_step_of_the_course() -> None:
    assert ROBOT.motion_from_wheels(LEFT, RIGHT).distance == pytest.approx(0.115)
    assert ROBOT.motion_from_wheels(LEFT, RIGHT).turn == pytest.approx(0.1)
    assert ROBOT.step([1.0, 2.0, 0.0], LEFT, RIGHT) == pytest.approx([1.1149, 2.0057, 0.1], abs=5e-5)


def test_the_drift_of_the_course() -> None:
    """sigma = 4.7 mrad a step, 0.15 rad after 1000; beside a line of 115 m, 17 m by the pessimist, 9.9 m for a walk."""
    drift = LateralDrift(1000, 115.0, ROBOT.turn_deviation(LEFT, RIGHT))
    assert drift.turn_deviation == pytest.approx(math.sqrt(2) * 1e-3 / 0.3)
    assert drift.heading_deviation == pytest.approx(0.149, abs=5e-4)
    assert drift.constant_error_deviation == pytest.approx(17.14, abs=0.01)
    assert drift.lateral_deviation == pytest.approx(9.90, abs=0.01)
    assert drift.lateral_deviation == pytest.approx(drift.constant_error_deviation / math.sqrt(3), rel=1e-6)


def test_robots_that_drive_straight_drift_as_predicted() -> None:
    """8,000 journeys; a deviation estimated from N samples errs by a share 1 / sqrt(2 N): six of these are allowed.

    The turns are small enough here for (5), which is of first order, to be exact to 1e-4.
    """
    rng, steps, journeys = np.random.default_rng(8), 100, 8_000
    robot = DifferentialDrive(track=0.3, sigma=1e-4)
    wheels = 0.1 + robot.sigma * rng.normal(size=(journeys, steps, 2))
    ends = integrate_poses(robot, wheels)[:, -1]
    drift = LateralDrift(steps, 0.1 * steps, robot.turn_deviation(0.1, 0.1))
    allowed = 6.0 / math.sqrt(2 * journeys)
    assert np.std(ends[:, 2]) == pytest.approx(drift.heading_deviation, rel=allowed)
    assert np.std(ends[:, 1]) == pytest.approx(drift.lateral_deviation, rel=allowed)
    beyond = np.mean(np.abs(ends[:, 1]) > drift.constant_error_deviation)
    share = math.erfc(math.sqrt(1.5))  # 2 Phi(-sqrt 3): the constant error is no bound
    assert share == pytest.approx(0.083, abs=5e-4)
    assert beyond == pytest.approx(share, abs=6.0 * math.sqrt(share / journeys))


def test_headings_off_by_no_more_than_their_deviation_keep_within_the_pessimistic_estimate() -> None:
    rng, steps = np.random.default_rng(4), 300
    drift = LateralDrift(steps, 30.0, 0.005)
    headings = rng.uniform(-1, 1, (2000, steps)) * drift.heading_deviation
    headings[0] = drift.heading_deviation
    beside = np.abs(np.sum(0.1 * np.sin(headings), axis=1))
    assert np.all(beside <= drift.constant_error_deviation)
    assert beside[0] == pytest.approx(drift.constant_error_deviation, rel=2e-3)


def test_the_linear_covariance_is_the_formula_of_the_drift() -> None:
    """Along a straight line, (3) step by step and (5) in closed form are one thing, to rounding."""
    found = dead_reckoning(ROBOT, np.full((1000, 2), 0.115))
    drift = LateralDrift(1000, 115.0, ROBOT.turn_deviation(0.115, 0.115))
    assert math.sqrt(found.covariances[-1][2, 2]) == pytest.approx(drift.heading_deviation, rel=1e-12)
    assert math.sqrt(found.covariances[-1][1, 1]) == pytest.approx(drift.lateral_deviation, rel=1e-9)
    assert math.sqrt(found.covariances[-1][0, 0]) == pytest.approx(0.001 * math.sqrt(1000 / 2), rel=1e-9)


def test_covariances_along_a_curve_are_those_of_simulated_robots() -> None:
    """The wheels of the course turn on a circle of radius 1.15 m. Six standard deviations of each estimate, and 2 %."""
    rng, steps, journeys = np.random.default_rng(21), 100, 8_000
    truth = np.tile([LEFT, RIGHT], (steps, 1))
    predicted = dead_reckoning(ROBOT, truth).covariances[-1]
    ends = integrate_poses(ROBOT, truth + ROBOT.sigma * rng.normal(size=(journeys, steps, 2)))[:, -1]
    gaps = ends - integrate_poses(ROBOT, truth)[-1]
    gaps[:, 2] = wrap_angle(gaps[:, 2])
    allowed = 6 * np.sqrt((predicted**2 + np.outer(np.diag(predicted), np.diag(predicted))) / journeys)
    assert np.all(np.abs(gaps.T @ gaps / journeys - predicted) < allowed + 0.02 * np.abs(predicted).max())


@given(st.floats(-3, 3), wheel, wheel)
def test_the_covariance_of_a_step_is_that_of_finite_differences(theta: float, left: float, right: float) -> None:
    h = 1e-6
    columns = [
        (ROBOT.pose_increment(left + a, right + b) - ROBOT.pose_increment(left - a, right - b)) / (2 * h)
        for a, b in ((h, 0.0), (0.0, h))
    ]
    G = np.column_stack(columns)
    expected = G @ ROBOT.wheel_covariance(left, right) @ G.T
    np.testing.assert_allclose(ROBOT.increment_covariance(left, right), expected, atol=1e-13)


@given(st.lists(st.tuples(wheel, wheel), min_size=1, max_size=20), st.tuples(wheel, wheel, st.floats(-3, 3)))
def test_all_steps_at_once_are_the_steps_one_by_one(wheels: Any, start: Any) -> None:
    pose = np.array(start)
    for left, right in wheels:
        pose = ROBOT.step(pose, left, right)
    for reached in (integrate_poses(ROBOT, wheels, start)[-1], dead_reckoning(ROBOT, wheels, start).poses[-1]):
        np.testing.assert_allclose(reached[:2], pose[:2], atol=1e-12)
        assert abs(math.remainder(reached[2] - pose[2], math.tau)) < 1e-12


@given(wheel, wheel)
def test_the_chord_is_the_arc_but_for_the_square_of_the_turn(left: float, right: float) -> None:
    motion = ROBOT.motion_from_wheels(left, right)
    gap = np.linalg.norm(ROBOT.step_along_arc([0, 0, 0], left, right)[:2] - ROBOT.step([0, 0, 0], left, right)[:2])
    assert gap <= abs(motion.distance) * motion.turn**2 / 24 + 1e-15
    np.testing.assert_allclose(ROBOT.wheel_paths(motion), [left, right], atol=1e-15)


def test_many_short_chords_are_the_arc() -> None:
    wheels = np.tile([0.2 / 1000, 0.5 / 1000], (1000, 1))
    np.testing.assert_allclose(integrate_poses(ROBOT, wheels)[-1], ROBOT.step_along_arc([0, 0, 0], 0.2, 0.5), atol=1e-7)


def test_slip_adds_up_with_the_distance_however_it_is_cut() -> None:
    robot = DifferentialDrive(track=0.3, sigma_per_root_metre=0.02)
    for cuts in (1, 7, 40):
        found = dead_reckoning(robot, np.full((cuts, 2), 8.0 / cuts))
        assert found.covariances[-1][0, 0] == pytest.approx(0.02**2 * 8.0 / 2, rel=1e-12)
        assert found.covariances[-1][2, 2] == pytest.approx(2 * 0.02**2 * 8.0 / 0.3**2, rel=1e-12)


def test_a_robot_that_stands_still_knows_where_it_is() -> None:
    robot = DifferentialDrive(track=0.3, sigma_per_root_metre=0.02)
    found = dead_reckoning(robot, np.zeros((5, 2)), (1.0, 2.0, 3.0))
    assert np.array_equal(found.poses, np.tile([1.0, 2.0, 3.0], (6, 1)))
    assert not found.covariances.any()
    assert dead_reckoning(robot, np.zeros((0, 2))).poses.shape == (1, 3)
    assert integrate_poses(robot, np.zeros((0, 2))).tolist() == [[0.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("track", lambda: DifferentialDrive(0.0)),
        ("sigma", lambda: DifferentialDrive(0.3, -1.0)),
        ("sigma_per_root_metre", lambda: DifferentialDrive(0.3, 0.0, math.nan)),
        ("wheels", lambda: ROBOT.motion_from_wheels(0.1, math.nan)),
        ("wheels", lambda: integrate_poses(ROBOT, [0.1, 0.2])),
        ("wheels", lambda: integrate_poses(ROBOT, [[0.1, math.inf]])),
        ("wheels", lambda: dead_reckoning(ROBOT, np.zeros((2, 2, 2)))),
        ("wheels", lambda: dead_reckoning(ROBOT, np.zeros((2, 3)))),
        ("T_a_b", lambda: dead_reckoning(ROBOT, [[0.1, 0.1]], start=(0.0, math.nan, 0.0))),
        ("cov_a_b", lambda: dead_reckoning(ROBOT, [[0.1, 0.1]], covariance=-np.eye(3))),
        ("steps", lambda: LateralDrift(0, 1.0, 0.1)),
        ("distance", lambda: LateralDrift(1, -1.0, 0.1)),
        ("turn_deviation", lambda: LateralDrift(1, 1.0, math.nan)),
    ],
)
def test_what_cannot_be_driven_is_named(argument: str, call: Any) -> None:
    with pytest.raises((OdometryError, PoseError)) as error:
        call()
    assert error.value.argument == argument


def test_a_motion_is_two_numbers() -> None:
    assert ROBOT.wheel_paths(Motion(0.115, 0.1)) == pytest.approx([LEFT, RIGHT])
