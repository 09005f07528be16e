"""Calibration: constants that made a journey are found again, SciPy agrees, and UMBmark's squares do to first order."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from reference.calibration import (
    CalibrationError,
    calibrate_steps,
    calibrate_wheels,
    umbmark,
)
from reference.odometry import DifferentialDrive, integrate_poses
from reference.se2 import relative, wrap_angle


def journey(scales: tuple[float, float], track: float, seed: int, n: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Counts (n, 2) of the wheels, and the motions (n, 3) that they make."""
    counts = np.random.default_rng(seed).uniform(-0.2, 0.5, (n, 2))
    poses = integrate_poses(DifferentialDrive(track), counts * scales)
    return counts, relative(poses[:-1], poses[1:])


@given(st.floats(0.2, 3.0), st.floats(0.2, 3.0), st.floats(0.3, 2.0), st.integers(0, 50))
def test_the_constants_that_made_a_journey_are_found_again(left: float, right: float, track: float, seed: int) -> None:
    counts, motions = journey((left, right), max(track, 0.6 * (left + right)), seed)
    found = calibrate_wheels(counts, motions)
    assert (found.left_scale, found.right_scale) == pytest.approx((left, right), rel=1e-9)
    assert found.heading_residual < 1e-12
    again = integrate_poses(found.to_drive, found.wheel_paths(counts))
    np.testing.assert_allclose(relative(again[:-1], again[1:]), motions, atol=1e-9)


def test_with_noise_no_other_constants_leave_less_of_the_turns() -> None:
    rng = np.random.default_rng(3)
    counts, motions = journey((1.02, 0.97), 0.4, 1, 300)
    noisy = motions + rng.normal(0.0, [0.01, 0.01, 0.02], motions.shape)
    found = calibrate_wheels(counts, noisy)
    peer = least_squares(lambda c: wrap_angle(counts @ c - noisy[:, 2]), [-2.0, 2.0], xtol=1e-14, ftol=1e-14)
    np.testing.assert_allclose(np.array([-found.left_scale, found.right_scale]) / found.track, peer.x, atol=1e-6)
    assert (found.left_scale, found.right_scale, found.track) == pytest.approx((1.02, 0.97, 0.4), abs=0.01)
    assert found.heading_residual == pytest.approx(0.02, rel=0.15)


@given(st.floats(0.8, 1.2), st.floats(0.8, 1.2), st.floats(-0.1, 0.1), st.integers(0, 50))
def test_odometry_that_comes_as_poses_is_corrected(stretch: float, turn: float, pull: float, seed: int) -> None:
    """The robot's own constants differ from the nominal ones by a stretch, a turn and a pull: exact for any of them."""
    rng = np.random.default_rng(seed)
    ways, turns = rng.uniform(-0.3, 0.7, 30), rng.uniform(-0.6, 0.6, 30)
    believed = np.column_stack([ways * np.cos(turns / 2), ways * np.sin(turns / 2), turns])
    real_turns = turn * turns + pull * ways
    middle = real_turns / 2
    real = np.column_stack([stretch * ways * np.cos(middle), stretch * ways * np.sin(middle), real_turns])
    found = calibrate_steps(believed, real)
    assert (found.stretch, found.turn, found.pull) == pytest.approx((stretch, turn, pull), abs=1e-9)
    np.testing.assert_allclose(found.correct(believed), real, atol=1e-9)


def test_wrong_matches_are_left_out() -> None:
    rng = np.random.default_rng(5)
    believed = rng.uniform([0.1, -0.05, -0.5], [0.7, 0.05, 0.5], (100, 3))
    real = calibrate_steps(believed, believed).correct(believed)
    real[:, 2] = wrap_angle(real[:, 2] + 0.05 * np.hypot(believed[:, 0], believed[:, 1]))
    real[[4, 40, 77], 2] += 2.0
    assert abs(calibrate_steps(believed, real).pull - 0.05) > 0.02
    assert calibrate_steps(believed, real, worst_share=0.05).pull == pytest.approx(0.05, abs=0.003)


def square(scales: tuple[float, float], track: float, believed: float, side: float, way: int) -> np.ndarray:
    """Where a robot is at the end of a square that its odometry believes to close, (2,), in the frame of the start."""
    ahead, turn = [[side / 40] * 2] * 40, np.pi / 2 / 20 * believed / 2 * way
    counts = np.array((ahead + [[-turn, turn]] * 20) * 4)
    return integrate_poses(DifferentialDrive(track), counts * scales)[-1, :2]


@pytest.mark.parametrize("faults", [(0.004, 0.0), (0.0, 0.02), (-0.003, 0.015), (0.002, -0.01)])
def test_the_squares_tell_unequal_wheels_from_a_wrong_track(faults: tuple[float, float]) -> None:
    """What is missed is of second order: a tenth of the faults leaves less than a fiftieth of it."""
    missed = []
    for size in (1.0, 0.1):
        unequal, wide = size * faults[0], size * faults[1]
        ends = [square((1 - unequal, 1 + unequal), 0.3 * (1 + wide), 0.3, 4.0, way) for way in (-1, 1)]
        found = umbmark(ends[:1], ends[1:], 4.0, 0.3)
        assert found.worst == pytest.approx(max(np.hypot(*end) for end in ends))
        assert (found.left_factor + found.right_factor) / 2 == pytest.approx(1.0, abs=1e-5)
        missed.append(np.hypot(found.wheel_ratio - (1 + unequal) / (1 - unequal), found.track_ratio - (1 + wide)))
    assert missed[1] < missed[0] / 50


def test_a_corrected_robot_closes_its_squares() -> None:
    scales, track = (0.999, 1.001), 0.303
    ends = [square(scales, track, 0.3, 4.0, way) for way in (-1, 1)]
    found = umbmark(ends[:1], ends[1:], 4.0, 0.3)
    # The robot now commands its wheels by its corrected constants: each is asked for less where it gives more.
    mended = (scales[0] / found.left_factor, scales[1] / found.right_factor)
    again = [square(mended, track, 0.3 * found.track_ratio, 4.0, way) for way in (-1, 1)]
    assert max(np.hypot(*end) for end in again) < found.worst / 10


STRAIGHT = np.column_stack([np.linspace(0.1, 0.5, 6), np.zeros(6), np.zeros(6)])


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("wheels", lambda: calibrate_wheels([[0.1, 0.1]] * 6, STRAIGHT)),
        ("wheels", lambda: calibrate_wheels([[0.0, 0.1]] * 6, STRAIGHT)),
        ("wheels", lambda: calibrate_wheels(journey((1, 1), 0.3, 0)[0][:, ::-1], journey((1, 1), 0.3, 0)[1])),
        ("wheels", lambda: calibrate_wheels([[0.1, 0.2]] * 2, STRAIGHT[:2])),
        ("steps", lambda: calibrate_wheels([[0.1, 0.2]] * 5, STRAIGHT)),
        ("steps", lambda: calibrate_wheels([[0.1, 0.2]] * 6, STRAIGHT * np.nan)),
        ("odometry_steps", lambda: calibrate_steps(STRAIGHT, STRAIGHT)),
        ("odometry_steps", lambda: calibrate_steps(np.zeros((0, 3)), np.zeros((0, 3)))),
        ("worst_share", lambda: calibrate_steps(STRAIGHT, STRAIGHT, worst_share=1.0)),
        ("clockwise", lambda: umbmark(np.zeros((0, 2)), [[0, 0]], 4.0, 0.3)),
        ("clockwise", lambda: umbmark([[20, 0]], [[0, 0]], 4.0, 0.3)),
        ("side", lambda: umbmark([[0, 0]], [[0, 0]], 0.0, 0.3)),
        ("track", lambda: umbmark([[0, 0]], [[0, 0]], 4.0, -0.3)),
    ],
)
def test_what_determines_nothing_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(CalibrationError) as caught:
        call()
    assert caught.value.argument == argument
