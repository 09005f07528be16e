"""Data association: against every hypothesis written out, and where the nearest neighbour is known to be wrong."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from reference.data_association import (
    AssociationError,
    ExpectedSightings,
    joint_compatibility,
    joint_distance,
    nearest_neighbours,
)
from reference.ekf_slam import EkfSlam, SlamNoise
from reference.se2 import relative

NOISE = np.diag([0.05**2, 0.02**2])


def some_case(seed: int, landmarks: int, measurements: int) -> tuple[ExpectedSightings, np.ndarray]:
    """Landmarks that are expected with an error common to all, some measured with it, and some false measurements."""
    rng = np.random.default_rng(seed)
    means = np.column_stack([rng.uniform(1, 3, landmarks), rng.uniform(-1, 1, landmarks)])
    shared = np.tile(np.diag([0.2, 0.25]), (landmarks, 1))
    own = 0.03 * rng.normal(size=(2 * landmarks, 2))
    expected = ExpectedSightings(means, shared @ shared.T + own @ own.T, NOISE)
    seen = rng.permutation(landmarks)[:measurements]
    z = means[seen] + rng.normal(0, [0.2, 0.25]) + rng.normal(0, [0.05, 0.02], (len(seen), 2))
    false = np.column_stack([rng.uniform(1, 3, measurements - len(seen)), rng.uniform(-1, 1, measurements - len(seen))])
    return expected, np.vstack([z, false])


def every_hypothesis(expected: ExpectedSightings, z: np.ndarray, confidence: float) -> tuple[int, float]:
    """How many pairs the best hypothesis has, and its distance, all being tried."""
    best = (0, 0.0)
    for choice in product(range(-1, len(expected)), repeat=len(z)):
        chosen = [k for k in choice if k >= 0]
        if len(set(chosen)) < len(chosen):
            continue
        distance = joint_distance(expected, z, choice)
        if chosen and distance > chi2.ppf(confidence, 2 * len(chosen)):
            continue
        if all_growing(expected, z, choice, confidence) and (len(chosen), -distance) > (best[0], -best[1]):
            best = (len(chosen), distance)
    return best


def all_growing(expected: ExpectedSightings, z: np.ndarray, choice: tuple[int, ...], confidence: float) -> bool:
    """Every pair passes its own gate, and the pairs of the first measurements pass theirs together (Neira's test)."""
    alone = expected.mahalanobis_distances(z)
    if any(k >= 0 and alone[i, k] > chi2.ppf(confidence, 2) for i, k in enumerate(choice)):
        return False
    for stop in range(1, len(choice)):
        first = [*choice[:stop], *[-1] * (len(choice) - stop)]
        pairs = sum(k >= 0 for k in first)
        if pairs and joint_distance(expected, z, first) > chi2.ppf(confidence, 2 * pairs):
            return False
    return True


@given(st.integers(0, 10_000), st.integers(1, 4), st.integers(1, 3))
@settings(max_examples=40)
def test_no_hypothesis_has_more_pairs_or_is_nearer(seed: int, landmarks: int, measurements: int) -> None:
    expected, z = some_case(seed, landmarks, measurements)
    found = joint_compatibility(expected, z, 0.95)
    count, distance = every_hypothesis(expected, z, 0.95)
    assert len(found.pairs) == count
    assert found.distance == pytest.approx(distance, abs=1e-9)
    assert joint_distance(expected, z, found.landmarks) == pytest.approx(found.distance, abs=1e-9)


def a_row_of_posts(heading_error: float) -> tuple[ExpectedSightings, np.ndarray]:
    """Posts three metres ahead, 0.2 rad apart, and a heading that errs: each post appears nearer to its neighbour."""
    bearings = 0.2 * np.arange(-3, 4)
    means = np.column_stack([np.full(7, 3.0), bearings])
    common = np.tile([0.0, 1.0], 7)[:, None]
    expected = ExpectedSightings(means, 0.15**2 * common @ common.T + 1e-6 * np.eye(14), NOISE)
    return expected, means[1:5] + np.array([0.0, heading_error])


def test_joint_compatibility_sees_that_all_err_together() -> None:
    """Unequal gaps would settle it; with equal ones, the posts at both ends do: one post too few to the right."""
    expected, z = a_row_of_posts(0.12)
    z = np.vstack([z, [2.0, 0.9]])
    means = expected.means.copy()
    means[[0, 3, 6], 0] = [3.4, 2.6, 3.4]
    expected = ExpectedSightings(means, expected.covariance, expected.noise)
    z[2, 0] = 2.6
    nearest, joint = nearest_neighbours(expected, z, 0.9999), joint_compatibility(expected, z)
    assert joint.landmarks.tolist() == [1, 2, 3, 4, -1]
    assert nearest.landmarks.tolist() != joint.landmarks.tolist()
    assert joint.distance < chi2.ppf(0.99, 8)


def test_without_a_common_error_both_agree() -> None:
    rng = np.random.default_rng(0)
    means = np.column_stack([rng.uniform(1, 9, 8), np.linspace(-2, 2, 8)])
    expected = ExpectedSightings(means, 1e-6 * np.eye(16), NOISE)
    z = means[[6, 1, 4]] + rng.normal(0, [0.05, 0.02], (3, 2))
    for find in (nearest_neighbours, joint_compatibility):
        assert find(expected, z).landmarks.tolist() == [6, 1, 4]


def test_a_bearing_goes_round() -> None:
    expected = ExpectedSightings(np.array([[2.0, np.pi - 0.01], [2.0, 0.0]]), 1e-4 * np.eye(4), NOISE)
    assert nearest_neighbours(expected, [[2.0, -np.pi + 0.01]]).landmarks.tolist() == [0]


def test_the_expectations_of_a_filter_are_those_that_it_corrects_with() -> None:
    belief = EkfSlam(SlamNoise(advance=0.05, turn=0.02, range=0.05, bearing=0.02))
    for identity, z in ((7, [2.0, 0.3]), (3, [3.0, -0.5])):
        belief.observe(identity, z)
    belief.predict([0.4, 0.2])
    expected, identities = ExpectedSightings.from_slam(belief)
    assert identities == [3, 7]
    z = np.array([[2.6, -0.8], [1.7, 0.1]])
    for k, identity in enumerate(identities):
        innovation = belief.predict_sighting(belief.slots[identity], z[k]).innovation
        assert expected.mahalanobis_distances(z)[k, k] == pytest.approx(innovation.nis)
        assert joint_distance(expected, z, [k if j == k else -1 for j in range(2)]) == pytest.approx(innovation.nis)
    true = relative(belief.pose, [*belief.landmark_position(7), 0.0])
    np.testing.assert_allclose(expected.means[1], [np.hypot(*true[:2]), np.arctan2(true[1], true[0])])
    assert np.abs(expected.covariance[:2, 2:]).max() > 1e-4


def test_a_gate_loses_as_many_true_pairs_as_it_says() -> None:
    rng = np.random.default_rng(1)
    expected = ExpectedSightings(np.array([[2.0, 0.1]]), np.diag([0.01, 0.02]), NOISE)
    z = expected.means + rng.multivariate_normal([0, 0], expected.covariance + NOISE, 20_000)
    lost = np.mean(expected.mahalanobis_distances(z)[:, 0] > chi2.ppf(0.9, 2))
    assert lost == pytest.approx(0.1, abs=0.01)


def test_without_landmarks_or_measurements_nothing_is_paired() -> None:
    empty = ExpectedSightings(np.zeros((0, 2)), np.zeros((0, 0)), NOISE)
    some = ExpectedSightings(np.array([[2.0, 0.0]]), np.eye(2), NOISE)
    for find in (nearest_neighbours, joint_compatibility):
        assert find(empty, [[1.0, 0.0]]).landmarks.tolist() == [-1]
        assert find(some, np.zeros((0, 2))).landmarks.tolist() == []


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("covariance", lambda: ExpectedSightings(np.zeros((2, 2)), np.eye(3), NOISE)),
        ("noise", lambda: ExpectedSightings(np.zeros((1, 2)), np.eye(2), [[1.0, 0.5], [0.0, 1.0]])),
        ("means", lambda: ExpectedSightings(np.full((1, 2), np.nan), np.eye(2), NOISE)),
        ("measurements", lambda: nearest_neighbours(ExpectedSightings(np.zeros((1, 2)), np.eye(2), NOISE), [[1.0]])),
        (
            "confidence",
            lambda: joint_compatibility(ExpectedSightings(np.zeros((1, 2)), np.eye(2), NOISE), [[1, 0]], 1.0),
        ),
    ],
)
def test_what_cannot_be_compared_is_named(argument: str, call: Any) -> None:
    with pytest.raises(AssociationError) as caught:
        call()
    assert caught.value.argument == argument
