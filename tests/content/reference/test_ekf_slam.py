"""EKF-SLAM: the rank-two correction against the textbook, finite differences, angles, consistency."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from reference.ekf_slam import (
    EkfSlam,
    SlamNoise,
    Update,
    full_jacobian,
    update_covariance_in_place,
    updated_covariance_joseph,
    updated_covariance_textbook,
)
from reference.errors import InvalidArgumentError
from reference.se2 import wrap_angle

NOISE = SlamNoise(advance=0.02, turn=0.01, range=0.05, bearing=0.02)
LANDMARKS = np.array([[2.0, 2.0], [-3.0, 1.0], [0.0, 6.0], [4.0, 4.0], [-2.0, 5.0], [3.0, -1.0]])


def see(pose: np.ndarray, landmark: np.ndarray) -> np.ndarray:
    away = landmark - pose[:2]
    return np.array([np.hypot(*away), wrap_angle(float(np.arctan2(away[1], away[0]) - pose[2]))])


def drive(robot: EkfSlam, seed: int, steps: int = 40, noise: SlamNoise = NOISE) -> np.ndarray:
    """Round a circle of 2 m, across the cut of the headings; all landmarks seen at each step. The true pose (3,)."""
    rng, truth = np.random.default_rng(seed), np.zeros(3)
    for _ in range(steps):
        advance, turn = np.array([0.3, 0.15]) + rng.normal(0.0, [noise.advance, noise.turn])
        middle = truth[2] + 0.5 * turn
        truth += [advance * math.cos(middle), advance * math.sin(middle), turn]
        truth[2] = wrap_angle(float(truth[2]))
        robot.predict([0.3, 0.15])
        for identity, landmark in enumerate(LANDMARKS):
            robot.observe(identity, see(truth, landmark) + rng.normal(0.0, [noise.range, noise.bearing]))
    return truth


@pytest.mark.parametrize("other", [updated_covariance_textbook, updated_covariance_joseph])
def test_the_rank_two_update_is_the_textbook_one(other: Update) -> None:
    ours, theirs = EkfSlam(NOISE), EkfSlam(NOISE, update=other)
    drive(ours, 1)
    drive(theirs, 1)
    assert np.max(np.abs(ours.covariance - theirs.covariance)) < 1e-10
    assert np.max(np.abs(ours.mean - theirs.mean)) < 1e-10


@pytest.mark.parametrize("landmarks", [1, 40])
def test_one_update_of_any_covariance_is_the_textbook_one_and_in_place(landmarks: int) -> None:
    rng, size = np.random.default_rng(2), 3 + 2 * landmarks
    robot = EkfSlam(NOISE)
    root = rng.normal(size=(size, size)) / math.sqrt(size)
    robot.covariance, robot.mean = np.asfortranarray(root @ root.T), rng.normal(size=size)
    sighting = robot.predict_sighting(3 + 2 * (landmarks - 1), np.array([2.0, 0.3]))
    expected = updated_covariance_textbook(robot.covariance.copy(order="F"), sighting, NOISE.sighting_covariance)
    updated = update_covariance_in_place(robot.covariance, sighting, NOISE.sighting_covariance)
    assert updated is robot.covariance or np.shares_memory(updated, robot.covariance)
    assert np.max(np.abs(updated - expected)) < 1e-10
    assert np.array_equal(updated, updated.T)
    # The trace falls: a sighting never makes anything less certain.
    assert np.trace(updated) < np.trace(root @ root.T)


def test_jacobians_are_finite_differences() -> None:
    rng, robot = np.random.default_rng(3), EkfSlam(NOISE)
    drive(robot, 3, steps=5)
    robot.mean += rng.normal(0.0, 0.1, robot.mean.size)
    slot, z = robot.slots[2], np.array([5.0, 0.4])
    H = full_jacobian(robot.predict_sighting(slot, z), robot.mean.size)
    before, step = robot.mean.copy(), 1e-6
    for column in range(before.size):
        ends = []
        for sign in (1.0, -1.0):
            robot.mean = before + sign * step * np.eye(before.size)[column]
            ends.append(-robot.predict_sighting(slot, z).innovation.difference)
        assert np.allclose((ends[0] - ends[1]) / (2 * step), H[:, column], atol=1e-7)


def test_motion_and_first_sighting_carry_covariance_by_their_jacobians() -> None:
    """Against the covariance of 60,000 robots drawn from the same laws, within 4 %."""
    rng, n = np.random.default_rng(4), 60_000
    robot = EkfSlam(NOISE, [1.0, -1.0, 0.6])
    for _ in range(3):
        robot.predict([0.5, 0.3])
    robot.observe(7, [3.0, -0.4])
    states = np.tile([1.0, -1.0, 0.6], (n, 1))
    for _ in range(3):
        moves = np.array([0.5, 0.3]) + rng.normal(size=(n, 2)) * [NOISE.advance, NOISE.turn]
        middle = states[:, 2] + 0.5 * moves[:, 1]
        states += np.column_stack([moves[:, 0] * np.cos(middle), moves[:, 0] * np.sin(middle), moves[:, 1]])
    r, b = (np.array([3.0, -0.4]) + rng.normal(size=(n, 2)) * [NOISE.range, NOISE.bearing]).T
    places = states[:, :2] + r[:, None] * np.column_stack([np.cos(states[:, 2] + b), np.sin(states[:, 2] + b)])
    found = np.cov(np.hstack([states, places]).T)
    scale = np.sqrt(np.outer(np.diag(found), np.diag(found)))
    assert np.all(np.abs(robot.covariance - found) < 0.04 * scale)
    assert np.allclose(robot.landmark_position(7), places.mean(axis=0), atol=0.01)


def test_errors_are_as_large_as_the_covariance_says() -> None:
    """NEES of the pose over 30 runs, within the 99.9 % interval of chi2: consistent while headings stay certain."""
    noise, runs, total = SlamNoise(0.01, 0.004, 0.03, 0.008), 30, 0.0
    for seed in range(runs):
        robot = EkfSlam(noise)
        error = drive(robot, seed, 15, noise) - robot.pose
        error[2] = wrap_angle(float(error[2]))
        total += error @ np.linalg.solve(robot.covariance[:3, :3], error)
    assert chi2.ppf(0.0005, 3 * runs) < total < chi2.ppf(0.9995, 3 * runs)


def test_the_map_is_found_and_relations_grow_certain_while_places_keep_the_doubt_of_the_start() -> None:
    """Landmarks end up near the truth; their distances are known much better than their absolute places."""
    robot = EkfSlam(NOISE)
    robot.covariance[:] = np.diag([0.5, 0.5, 0.0]) ** 2
    drive(robot, 6, steps=60)
    found = np.array([robot.landmark_position(identity) for identity in range(len(LANDMARKS))])
    assert np.max(np.hypot(*((found - found.mean(axis=0)) - (LANDMARKS - LANDMARKS.mean(axis=0))).T)) < 0.25
    difference = np.zeros((2, robot.mean.size))
    difference[:, robot.slots[0] : robot.slots[0] + 2] = np.eye(2)
    difference[:, robot.slots[1] : robot.slots[1] + 2] = -np.eye(2)
    assert np.sqrt(np.trace(difference @ robot.covariance @ difference.T)) < 0.2
    assert np.sqrt(robot.covariance[3, 3]) > 0.49
    assert np.linalg.eigvalsh(robot.covariance)[0] > -1e-12


def test_a_bearing_across_the_cut_is_a_small_surprise() -> None:
    robot = EkfSlam(NOISE, [0.0, 0.0, -0.01])
    robot.observe(0, [5.0, math.pi])
    robot.predict([0.0, 0.0])
    robot.observe(0, [5.0, -math.pi + 0.02])
    assert robot.innovation is not None
    assert robot.innovation.difference[1] == pytest.approx(0.02, abs=1e-9)


def test_input_without_meaning_is_named() -> None:
    robot = EkfSlam(NOISE)
    robot.observe(1, [2.0, 0.0])
    for argument, call in (
        ("pose", lambda: EkfSlam(NOISE, [0.0, math.nan, 0.0])),
        ("control", lambda: robot.predict([1.0])),
        ("measurement", lambda: robot.observe(0, [math.nan, 0.0])),
        ("measurement", lambda: robot.observe(0, [0.0, 0.0])),
        ("identity", lambda: robot.landmark_position(9)),
        ("range", lambda: SlamNoise(0.1, 0.1, 0.0, 0.1)),
        ("advance", lambda: SlamNoise(-0.1, 0.1, 0.1, 0.1)),
    ):
        with pytest.raises(InvalidArgumentError) as refusal:
            call()
        assert refusal.value.argument == argument
    robot.mean[3:5] = robot.mean[:2]
    with pytest.raises(InvalidArgumentError):
        robot.observe(1, [2.0, 0.0])
