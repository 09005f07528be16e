"""The grid filter: against a naive sum over cells, simulated robots, SciPy's densities, and the laws of probability."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from reference.localisation.grid_filter import (
    COMMANDS,
    EmptyBeliefError,
    GridFilterError,
    GridWorld,
    correct,
    most_likely_cell,
    possible_landings,
    predict,
    sample_move,
)

seeds = st.integers(0, 2**32 - 1)
RANGE = 12.0


def world_of(seed: int, shape: tuple[int, int] = (5, 6)) -> tuple[GridWorld, np.random.Generator]:
    rng = np.random.default_rng(seed)
    free = rng.random(shape) > 0.3
    free[rng.integers(shape[0]), rng.integers(shape[1])] = True
    return GridWorld.from_free_cells(free, RANGE), rng


def belief_on(world: GridWorld, rng: np.random.Generator) -> np.ndarray:
    weights = world.free * rng.uniform(0.01, 1.0, world.free.shape)
    return np.asarray(weights / weights.sum())


def naive(world: GridWorld, belief: np.ndarray, du: int, dv: int) -> np.ndarray:
    """Straight from the words of the exercise, one cell at a time."""
    result = np.zeros_like(belief)
    for (y, x), mass in np.ndenumerate(belief):
        for probability, side in ((0.8, 0), (0.1, 1), (0.1, -1)):
            there = (y + dv + side * du, x + du + side * dv)
            result[there if world.is_free(there) else (y, x)] += probability * mass
    return result


@given(seeds, st.sampled_from(COMMANDS))
def test_prediction_is_the_naive_sum(seed: int, command: tuple[int, int]) -> None:
    world, rng = world_of(seed)
    belief = belief_on(world, rng)
    assert np.allclose(predict(world, belief, *command), naive(world, belief, *command), atol=1e-15)


@given(seeds, st.sampled_from(COMMANDS))
def test_prediction_is_a_belief_and_linear(seed: int, command: tuple[int, int]) -> None:
    world, rng = world_of(seed)
    one, other = belief_on(world, rng), belief_on(world, rng)
    before = one.copy()
    moved = predict(world, one, *command)
    assert math.isclose(moved.sum(), 1.0)
    assert moved.min() >= 0.0
    assert not moved[~world.free].any()
    assert np.array_equal(one, before)
    blend = predict(world, 0.3 * one + 0.7 * other, *command)
    assert np.allclose(blend, 0.3 * moved + 0.7 * predict(world, other, *command))


def test_in_the_open_the_robot_lands_on_three_cells() -> None:
    world = GridWorld.from_free_cells(np.ones((5, 5)), RANGE)
    belief = np.zeros((5, 5))
    belief[2, 2] = 1.0
    moved = predict(world, belief, 1, 0)
    assert {(int(y), int(x)): round(float(moved[y, x]), 12) for y, x in np.argwhere(moved)} == {
        (2, 3): 0.8,
        (1, 3): 0.1,
        (3, 3): 0.1,
    }


def test_no_command_moves_nothing() -> None:
    world, rng = world_of(4)
    belief = belief_on(world, rng)
    assert np.array_equal(predict(world, belief, 0, 0), belief)


@pytest.mark.parametrize("command", COMMANDS)
def test_probabilities_of_landing_sum_to_one(command: tuple[int, int]) -> None:
    outcomes = possible_landings(*command)
    assert math.isclose(sum(outcome.probability for outcome in outcomes), 1.0)
    assert max(abs(outcome.dx - command[0]) for outcome in outcomes) == abs(command[1])


def test_simulated_robots_spread_as_predicted() -> None:
    """Each frequency over 20,000 robots stays within 6 standard deviations (false alarm < 1e-7 for 30 cells)."""
    world, rng = world_of(11)
    start = most_likely_cell(belief_on(world, rng))
    belief = np.zeros(world.free.shape)
    belief[start] = 1.0
    count = 20_000
    landed = np.zeros_like(belief)
    for _ in range(count):
        landed[sample_move(world, start, 0, 1, rng)] += 1 / count
    expected = predict(world, belief, 0, 1)
    assert np.all(np.abs(landed - expected) <= 6.0 * np.sqrt(expected * (1 - expected) / count) + 1e-12)


@settings(deadline=None)
@given(seeds, st.floats(0.2, 3.0))
def test_correction_is_bayes_rule_with_gaussian_densities(seed: int, sigma: float) -> None:
    world, rng = world_of(seed, (3, 4))
    belief = belief_on(world, rng)
    scan = world.scans[most_likely_cell(belief)] + rng.normal(0.0, 0.1, 4)
    densities = np.array(
        [multivariate_normal.pdf(scan, mean, sigma**2 * np.eye(4)) for mean in world.scans.reshape(-1, 4)]
    )
    products = belief * densities.reshape(belief.shape)
    assert np.allclose(correct(world, belief, scan, sigma), products / products.sum(), atol=1e-12)


def test_a_scan_unlike_any_other_still_tells_cells_apart() -> None:
    world = GridWorld.from_free_cells(np.ones((1, 3)), RANGE)
    corrected = correct(world, world.uniform_belief(), [500.0, 0.5, 0.0, 0.5], 0.01)
    assert np.array_equal(corrected, [[1.0, 0.0, 0.0]])


def test_an_impossible_cell_stays_impossible_however_like_the_scan() -> None:
    world = GridWorld.from_free_cells(np.ones((1, 4)), RANGE)
    corrected = correct(world, [[0.0, 0.5, 0.5, 0.0]], world.scans[0, 0], 0.01)
    assert corrected[0, 0] == 0.0
    assert corrected[0, 1] == pytest.approx(1.0)


def test_a_lost_robot_is_found() -> None:
    free = np.ones((6, 9), dtype=bool)
    free[2, 3:7], free[4, 1], free[0, 5] = False, False, False
    world, rng = GridWorld.from_free_cells(free, RANGE), np.random.default_rng(3)
    cell, belief = (3, 4), world.uniform_belief()
    for du, dv in [(1, 0), (1, 0), (0, 1), (1, 0), (0, -1), (-1, 0), (0, -1), (0, -1)]:
        cell = sample_move(world, cell, du, dv, rng)
        belief = correct(world, predict(world, belief, du, dv), world.scans[cell], 0.5)
    assert most_likely_cell(belief) == cell


def test_degenerate_input_is_named() -> None:
    world = GridWorld.from_free_cells(np.ones((2, 3)), RANGE)
    uniform, scan = world.uniform_belief(), world.scans[0, 0]
    for argument, call in (
        ("free", lambda: GridWorld.from_free_cells(np.zeros((2, 2)), RANGE)),
        ("du, dv", lambda: predict(world, uniform, 1, 1)),
        ("belief", lambda: predict(world, uniform.T, 1, 0)),
        ("belief", lambda: predict(world, -uniform, 1, 0)),
        ("belief", lambda: predict(world, uniform * math.nan, 1, 0)),
        ("scan", lambda: correct(world, uniform, scan[:3], 0.5)),
        ("scan", lambda: correct(world, uniform, scan * math.nan, 0.5)),
        ("sigma", lambda: correct(world, uniform, scan, 0.0)),
    ):
        with pytest.raises(GridFilterError) as error:
            call()
        assert error.value.argument == argument
    with pytest.raises(EmptyBeliefError):
        correct(world, np.zeros((2, 3)), scan, 0.5)
