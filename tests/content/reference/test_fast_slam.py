"""FastSLAM: the filter of EKF-SLAM where both are exact, its posterior where they nearly are, and a whole journey."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference.ekf_slam import EkfSlam, SlamNoise
from reference.errors import InvalidArgumentError
from reference.fast_slam import FastSlam, Version, move_poses
from reference.filters.resampling import effective_sample_size
from reference.se2 import wrap_angle

VERSIONS: tuple[Version, ...] = ("1.0", "2.0")
LANDMARKS = np.array([[2.0, 1.0], [3.0, -1.5], [-1.0, 2.5], [0.5, -2.0]])


def seen_from(pose: np.ndarray, landmark: np.ndarray) -> np.ndarray:
    away = landmark - pose[:2]
    return np.array([np.hypot(*away), wrap_angle(float(np.arctan2(away[1], away[0]) - pose[2]))])


@pytest.mark.parametrize("version", VERSIONS)
def test_where_the_robot_is_known_each_landmark_has_the_filter_of_ekf_slam(version: Version) -> None:
    noise = SlamNoise(advance=0.0, turn=0.0, range=0.1, bearing=0.05)
    rng = np.random.default_rng(0)
    fast, ekf = FastSlam(noise, 3, rng, version=version), EkfSlam(noise)
    evidence = fast_evidence = 0.0
    pose = np.zeros(3)
    for turn in (0.3, -0.2, 0.5, 0.1):
        pose = move_poses(pose[None], np.array([[0.4, turn]]))[0]
        seen = {k: seen_from(pose, mark) + rng.normal(0, [0.1, 0.05]) for k, mark in enumerate(LANDMARKS)}
        ekf.predict([0.4, turn])
        evidence += sum(ekf.observe(k, z) for k, z in seen.items())
        fast.step([0.4, turn], seen)
        fast_evidence += fast.log_evidence
    np.testing.assert_allclose(fast.poses, np.tile(pose, (3, 1)), atol=1e-12)
    for k in range(len(LANDMARKS)):
        slot = ekf.slots[k]
        np.testing.assert_allclose(fast.means[:, k], np.tile(ekf.landmark_position(k), (3, 1)), atol=1e-9)
        np.testing.assert_allclose(fast.covariances[0, k], ekf.covariance[slot : slot + 2, slot : slot + 2], atol=1e-12)
    assert fast_evidence == pytest.approx(evidence)


def after_a_step(version: Version, particles: int, sensor: float) -> tuple[FastSlam, EkfSlam]:
    """A landmark seen, a step, and two sightings; particles are not drawn anew, so that their weights are looked at."""
    noise = SlamNoise(advance=0.02, turn=0.02, range=sensor, bearing=sensor)
    fast = FastSlam(noise, particles, np.random.default_rng(1), version=version, least_share=0.0)
    ekf = EkfSlam(noise)
    for control, seen in (
        ([0.0, 0.0], {0: np.array([2.0, 0.4]), 1: np.array([3.0, -0.7])}),
        ([0.5, 0.2], {0: np.array([1.54, 0.33]), 1: np.array([2.62, -1.02])}),
    ):
        ekf.predict(control)
        for k, z in seen.items():
            ekf.observe(k, z)
        fast.step(control, seen)
    return fast, ekf


@pytest.mark.parametrize("version", VERSIONS)
def test_many_particles_have_the_posterior_of_the_filter(version: Version) -> None:
    """In a step so small that the filter's linear model is right to a few per cent of a standard deviation."""
    fast, ekf = after_a_step(version, 40_000, 0.02)
    spread = np.sqrt(np.diag(ekf.covariance)[:3])
    np.testing.assert_allclose((fast.pose - ekf.pose) / spread, 0.0, atol=0.06)
    away = fast.poses - fast.pose
    found = np.einsum("n,ni,nj->ij", fast.weights, away, away)
    np.testing.assert_allclose(
        found / np.outer(spread, spread), ekf.covariance[:3, :3] / np.outer(spread, spread), atol=0.06
    )
    for k in (0, 1):
        np.testing.assert_allclose(fast.landmark_position(k), ekf.landmark_position(k), atol=2e-3)


def test_what_is_seen_moves_the_particles_where_the_sensor_is_the_better_one() -> None:
    shares = []
    for version in VERSIONS:
        fast, _ = after_a_step(version, 2_000, 0.002)
        shares.append(effective_sample_size(fast.weights) / 2_000)
    assert shares[0] < 0.1
    assert shares[1] > 0.5


@pytest.mark.parametrize("version", VERSIONS)
def test_a_loop_is_mapped_better_than_by_odometry(version: Version) -> None:
    rng = np.random.default_rng(4)
    noise = SlamNoise(advance=0.03, turn=0.04, range=0.05, bearing=0.03)
    marks = 3.0 * np.column_stack([np.cos(np.arange(8) * np.pi / 4), np.sin(np.arange(8) * np.pi / 4)]) + [0.0, 2.0]
    fast = FastSlam(noise, 60, rng, version=version)
    truth, believed = np.zeros(3), np.zeros(3)
    for _ in range(80):
        control = np.array([0.16, 0.08])
        truth = move_poses(truth[None], (control + rng.normal(0, [0.03, 0.04]))[None])[0]
        believed = move_poses(believed[None], control[None])[0]
        seen = {k: seen_from(truth, mark) for k, mark in enumerate(marks) if np.hypot(*(mark - truth[:2])) < 2.5}
        fast.step(control, {k: z + rng.normal(0, [0.05, 0.03]) for k, z in seen.items()})
    assert np.hypot(*(fast.pose - truth)[:2]) < 0.25 < np.hypot(*(believed - truth)[:2])
    assert len(fast.ranks) == 8
    errors = [np.hypot(*(fast.landmark_position(k) - mark)) for k, mark in enumerate(marks)]
    assert np.mean(errors) < 0.35


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("version", lambda slam: FastSlam(slam.noise, 3, np.random.default_rng(0), version="3.0")),
        ("particles", lambda slam: FastSlam(slam.noise, 0, np.random.default_rng(0))),
        ("pose", lambda slam: FastSlam(slam.noise, 3, np.random.default_rng(0), pose=[0.0, np.nan, 0.0])),
        ("least_share", lambda slam: FastSlam(slam.noise, 3, np.random.default_rng(0), least_share=1.5)),
        ("control", lambda slam: slam.step([0.1], {})),
        ("sightings", lambda slam: slam.step([0.1, 0.0], {0: [0.0, 0.1]})),
        ("sightings", lambda slam: slam.step([0.1, 0.0], {0: [1.0, np.inf]})),
        ("identity", lambda slam: slam.landmark_position(5)),
    ],
)
def test_what_cannot_be_taken_in_is_named(argument: str, call: Any) -> None:
    slam = FastSlam(SlamNoise(advance=0.1, turn=0.1, range=0.1, bearing=0.1), 3, np.random.default_rng(0))
    with pytest.raises(InvalidArgumentError) as caught:
        call(slam)
    assert caught.value.argument == argument


def test_a_step_that_sees_nothing_moves_and_weighs_nothing() -> None:
    slam = FastSlam(SlamNoise(advance=0.1, turn=0.1, range=0.1, bearing=0.1), 500, np.random.default_rng(0))
    slam.step([1.0, 0.5], {})
    assert slam.weights == pytest.approx(np.full(500, 1 / 500))
    assert slam.log_evidence == pytest.approx(0.0)
    np.testing.assert_allclose(slam.poses.std(axis=0)[2], 0.1, rtol=0.15)
