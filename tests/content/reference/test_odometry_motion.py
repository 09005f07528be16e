"""Motion sampling: composition without noise, its linearisation with little, and no half-turn to move backward."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.errors import InvalidArgumentError
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry, turn_advance_turn
from reference.se2 import compose, wrap_angle

NONE = OdometryNoise(0.0, 0.0, 0.0, 0.0)
components = st.floats(-3.0, 3.0)
moves = st.tuples(components, components, components)


@given(moves, moves)
def test_without_noise_it_is_composition(pose: tuple[float, ...], move: tuple[float, ...]) -> None:
    found = sample_odometry(np.array([pose]), move, NONE, np.random.default_rng(0))[0]
    expected = compose(pose, move)
    assert np.allclose(found[:2], expected[:2], atol=1e-8)
    assert wrap_angle(found[2] - expected[2]) == pytest.approx(0.0, abs=1e-12)


def test_the_spread_is_that_of_the_noise_to_first_order() -> None:
    noise, move = OdometryNoise(0.02, 0.01, 0.03, 0.01), np.array([0.8, 0.3, 0.5])
    first, advance, second = turn_advance_turn(move)
    n = 40_000
    poses = sample_odometry(np.tile([1.0, 2.0, 0.7], (n, 1)), move, noise, np.random.default_rng(1))
    heading = 0.7 + first
    slope = np.array(
        [
            [-advance * math.sin(heading), math.cos(heading), 0.0],
            [advance * math.cos(heading), math.sin(heading), 0.0],
            [1.0, 0.0, 1.0],
        ]
    )
    expected = slope @ np.diag(noise.sigmas(first, advance, second) ** 2) @ slope.T
    found = np.cov(poses.T)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.all(np.abs(found - expected) < 0.03 * scale)
    assert np.allclose(poses.mean(axis=0), compose([1.0, 2.0, 0.7], move), atol=2e-3)


def test_a_move_backward_is_as_sure_as_a_move_forward() -> None:
    noise = OdometryNoise()
    forward = noise.sigmas(*turn_advance_turn([0.5, 0.0, 0.0]))
    backward = noise.sigmas(*turn_advance_turn([-0.5, 0.0, 0.0]))
    assert np.allclose(forward, backward)


def test_a_robot_that_stands_still_stays() -> None:
    poses = np.random.default_rng(2).normal(size=(10, 3))
    moved = sample_odometry(poses, [0.0, 0.0, 0.0], OdometryNoise(), np.random.default_rng(3))
    assert np.allclose(moved, poses)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("T_before_after", lambda rng: sample_odometry(np.zeros((2, 3)), [0.0, math.nan, 0.0], NONE, rng)),
        ("T_before_after", lambda rng: sample_odometry(np.zeros((2, 3)), [0.0, 1.0], NONE, rng)),
        ("poses", lambda rng: sample_odometry(np.zeros(3), [0.0, 1.0, 0.0], NONE, rng)),
        ("turn_by_turn", lambda rng: OdometryNoise(turn_by_turn=-1.0)),
    ],
)
def test_input_without_meaning_is_named(argument: str, call: object) -> None:
    with pytest.raises(InvalidArgumentError) as refusal:
        call(np.random.default_rng(0))  # type: ignore[operator]
    assert refusal.value.argument == argument
