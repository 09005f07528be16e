"""Scan matching: the window searched as exhaustively as by brute force, motions as they were, doubt where there is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.registration import (
    LineCloud,
    MatchingSettings,
    SearchWindow,
    match_by_correlation,
    match_clouds,
    match_scans,
)
from reference.registration.correlation import build_lattice
from reference.se2 import relative, wrap_angle
from reference.world.grid_map import GridMap
from reference.world.scan import Scan, full_turn_angles
from reference.world.scenes import random_building

Floats = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
WORLD = random_building(np.random.default_rng(3), (2, 2), room=50)
ANGLES = full_turn_angles(180)


def look(world: GridMap, pose: Any, rng: np.random.Generator, reach: float = 8.0) -> Scan:
    ranges = world.cast_scans([pose], ANGLES, reach)[0]
    noisy = np.clip(ranges + np.where(ranges < reach, rng.normal(0, 0.01, len(ranges)), 0.0), 0, reach)
    return Scan(noisy, ANGLES, reach)


def open_poses(world: GridMap, rng: np.random.Generator, apart: float) -> tuple[Floats, Floats]:
    """Two poses in one room, the second `apart` metres away at most, any heading."""
    clear = np.argwhere(world.distances_to_wall > 0.5)
    while True:
        y, x = clear[rng.integers(len(clear))]
        first = np.append(world.to_world([x + 0.5, y + 0.5]), rng.uniform(-3, 3))
        second = np.append(first[:2] + rng.uniform(-apart, apart, 2) / np.sqrt(2), rng.uniform(-3, 3))
        across = first[:2] + np.linspace(0, 1, 20)[:, None] * (second - first)[:2]
        if world.is_free(across).all() and world.is_free(second[:2]):
            return first, second


@settings(deadline=None, max_examples=25)
@given(seed=seeds, sigma=st.sampled_from([np.inf, 0.5, 0.05]))
def test_the_best_pose_of_the_lattice_is_that_of_brute_force(seed: int, sigma: float) -> None:
    rng = np.random.default_rng(seed)
    P, Q = rng.uniform(-1, 1, (9, 2)), rng.uniform(-1, 1, (12, 2))
    guess, window = rng.uniform(-0.3, 0.3, 3), SearchWindow(rng.uniform(0.1, 0.7), 0.4, 0.1, sigma, 2 * sigma)
    found = match_by_correlation(P, Q, guess, window)
    shift = int(np.ceil(window.reach / 0.1))
    count = int(np.ceil(0.4 * np.linalg.norm(P, axis=1).max() / 0.1))
    turns = 0.4 * np.arange(-count, count + 1) / count
    lattice = build_lattice(P, Q, guess, turns, window, int(np.floor(np.log2(2 * shift + 1))))
    shifts = np.arange(-shift, shift + 1)
    every = np.stack(np.meshgrid(np.arange(len(turns)), shifts, shifts, indexing="ij"), axis=-1).reshape(-1, 3)
    scores = lattice.scores(0, every)
    assert found.score == pytest.approx(scores.max(), abs=1e-12)
    offset = found.T_q_p - guess
    best = every[np.isclose(scores, scores.max(), atol=1e-12)]
    wanted = np.column_stack([best[:, 2] * 0.1, best[:, 1] * 0.1, turns[best[:, 0]]])
    assert np.abs(wanted - offset).max(axis=1).min() < 1e-9


def test_bounds_bound() -> None:
    rng = np.random.default_rng(2)
    clouds, window = rng.uniform(-2, 2, (2, 7, 2)), SearchWindow(sigma=0.3)
    lattice = build_lattice(*clouds, np.zeros(3), np.zeros(1), window, 3)
    for h in (1, 2, 3):
        for dy, dx in rng.integers(-30, 30, (20, 2)):
            inside = [(0, dy + v, dx + u) for v in range(2**h) for u in range(2**h)]
            assert lattice.scores(h, np.array([(0, dy, dx)]))[0] >= lattice.scores(0, np.array(inside)).max() - 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_the_motion_between_two_scans_is_found_from_a_guess(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = open_poses(WORLD, rng, 0.5)
    truth = relative(first, second)
    guess = truth + rng.uniform(-1, 1, 3) * [0.15, 0.15, 0.1]
    found = match_scans(look(WORLD, first, rng), look(WORLD, second, rng), guess)
    error = found.T_a_b - truth
    assert np.abs(error[:2]).max() < 0.03
    assert abs(wrap_angle(float(error[2]))) < 0.015
    assert found.overlap > 0.6
    assert not found.is_degenerate
    assert np.linalg.eigvalsh(found.information)[0] > 0


@pytest.mark.parametrize("seed", range(6))
def test_and_with_no_guess_of_the_heading(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = open_poses(WORLD, rng, 0.6)
    truth = relative(first, second)
    found = match_scans(look(WORLD, first, rng), look(WORLD, second, rng), np.zeros(3), window=SearchWindow(0.8))
    error = found.T_a_b - truth
    assert np.abs(error[:2]).max() < 0.04
    assert abs(wrap_angle(float(error[2]))) < 0.02


def test_a_corridor_is_reported() -> None:
    free = np.zeros((30, 600), bool)
    free[5:25] = True
    corridor = GridMap.from_free(free, 0.1)
    rng = np.random.default_rng(1)
    scans = [look(corridor, [x, 1.5, 0.0], rng, 5.0) for x in (30.0, 30.3)]
    assert match_scans(*scans, [0.0, 0.0, 0.0]).is_degenerate


def test_a_corridor_informs_of_the_other_directions_only() -> None:
    """Across and in heading the match is sure; along it, where it lands means nothing, and its information says so."""
    free = np.zeros((30, 600), bool)
    free[5:25] = True
    corridor = GridMap.from_free(free, 0.1)
    rng = np.random.default_rng(1)
    a, b = (LineCloud.from_scan(look(corridor, [x, 1.5, 0.3], rng, 5.0)) for x in (30.0, 30.3))
    found = match_clouds(a, b, [0.2, 0.0, 0.0])
    values, vectors = np.linalg.eigh(found.information)
    assert abs(values[0]) < 1e-9 * values[2]
    assert values[1] > 1.0 / 0.03**2
    along = np.array([np.cos(0.3), -np.sin(0.3)])
    assert abs(vectors[:2, 0] @ along) > 0.99


def test_a_few_strange_points_do_not_slide_a_corridor() -> None:
    """A post of three points, near another one: what is hardly seen stays as it was guessed."""
    along, across = np.linspace(0.0, 10.0, 201), np.linspace(0.0, 0.1, 3)
    sides = [np.column_stack([along, np.full(201, y)]) for y in (-1.0, 1.0)]

    def cloud(door: float) -> LineCloud:
        frame = np.column_stack([np.full(3, door), across])
        normals = [np.tile([0.0, 1.0], (402, 1)), np.tile([1.0, 0.0], (3, 1))]
        return LineCloud(np.concatenate([*sides, frame]), np.concatenate(normals))

    match = match_clouds(cloud(5.0), cloud(5.3), (0.0, 0.05, 0.0))
    np.testing.assert_allclose(match.T_a_b, np.zeros(3), atol=1e-3)
    assert match.is_degenerate
    assert match.overlap > 0.99


def test_a_match_is_no_surer_than_it_errs() -> None:
    """Over many pairs the squared errors, by what the matches claim, are those of three degrees of freedom or less."""
    squares = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        first, second = open_poses(WORLD, rng, 0.5)
        clouds = [LineCloud.from_scan(look(WORLD, pose, rng)) for pose in (first, second)]
        truth = relative(first, second)
        found = match_clouds(*clouds, truth + rng.uniform(-1, 1, 3) * [0.1, 0.1, 0.05])
        gap = found.T_a_b - truth
        gap[2] = wrap_angle(float(gap[2]))
        squares.append(float(gap @ found.information @ gap))
    assert 0.05 < np.mean(squares) < 3.0
    assert np.max(squares) < 16.3  # the quantile 0.999


def test_more_beams_on_the_same_walls_make_no_surer_match() -> None:
    """Walls count, not beams: four times as many beams do not even double the information, whatever the place."""
    rng = np.random.default_rng(5)
    for _ in range(5):
        pose, _ = open_poses(WORLD, rng, 0.1)
        traces = []
        for beams in (360, 1440):
            ranges = WORLD.cast_scans([pose], full_turn_angles(beams), 8.0)[0]
            cloud = LineCloud.from_scan(Scan.full_turn(ranges, 8.0))
            traces.append(np.trace(match_clouds(cloud, cloud, np.zeros(3)).information))
        assert 0.7 < traces[1] / traces[0] < 2.0


@settings(deadline=None, max_examples=25)
@given(seed=seeds, n=st.integers(10, 30), m=st.integers(10, 30))
def test_unrelated_clouds_match_with_semidefinite_information_or_are_refused(seed: int, n: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    scans = [Scan(rng.uniform(0.1, 7.9, k), rng.uniform(-3, 3, k), 8.0) for k in (n, m)]
    refusal = None
    try:
        found = match_scans(*scans, rng.normal(size=3), window=SearchWindow(0.5, 0.3) if seed % 2 else None)
    except InvalidArgumentError as error:
        refusal = error
    if refusal is None:
        values = np.linalg.eigvalsh(found.information)
        assert values[0] >= -1e-9 * max(values[2], 1.0)
        assert 0.0 <= found.overlap <= 1.0


def test_two_places_that_differ_do_not_overlap() -> None:
    rng = np.random.default_rng(7)
    scans = []
    for seed in (11, 12):
        world = random_building(np.random.default_rng(seed), (2, 2), room=50)
        scans.append(look(world, open_poses(world, np.random.default_rng(seed), 0.1)[0], rng))
    assert match_scans(*scans, np.zeros(3), window=SearchWindow(1.0)).overlap < 0.6


SCAN = Scan(np.ones(60), full_turn_angles(60), 5.0)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("a", lambda: match_scans(Scan([], [], 5.0), SCAN, np.zeros(3))),
        ("b", lambda: match_scans(SCAN, Scan([1.0] * 9, range(9), 5.0), np.zeros(3))),
        ("pairing", lambda: match_scans(SCAN, SCAN, [50.0, 0, 0])),
        ("T_q_p", lambda: match_by_correlation([(0, 0)], [(0, 0)], [0, 0], SearchWindow())),
        ("P", lambda: match_by_correlation([], [(0, 0)], [0, 0, 0], SearchWindow())),
        ("reach", lambda: SearchWindow(0.0)),
        ("sigma", lambda: SearchWindow(sigma=0.0)),
        ("patch", lambda: MatchingSettings(patch=-1.0)),
        ("sigma", lambda: MatchingSettings(sigma=0.0)),
    ],
)
def test_what_cannot_be_matched_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(InvalidArgumentError) as caught:
        call()
    assert caught.value.argument == argument
