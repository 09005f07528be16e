"""Simulated places and journeys: connected, repeatable, free of collisions, with the errors that were asked for."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label

from reference.odometry import DifferentialDrive, Motion
from reference.world.grid_map import GridMap
from reference.world.raycast import cast_scans
from reference.world.scan import full_turn_angles
from reference.world.scenes import SceneError, random_building, random_clutter, random_ring
from reference.world.simulation import SimulatedLidar, SimulationError, motions_through_waypoints, random_walk, simulate

PERFECT = DifferentialDrive(0.3)
ROBOT = DifferentialDrive(0.3, sigma=0.002)
PLACES: dict[str, Any] = {
    "building": lambda rng: random_building(rng, (2, 3)),
    "clutter": lambda rng: random_clutter(rng, (40, 60), 30),
    "ring": lambda rng: random_ring(rng, (70, 90)),
}
ROOM = GridMap.from_free(np.pad(np.ones((38, 58), dtype=bool), 1), 0.1, (-1.0, 2.0, 0.3))


@pytest.mark.parametrize("name", PLACES)
@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_places_are_framed_connected_and_drawn_from_their_seed(name: str, seed: int) -> None:
    place = PLACES[name](np.random.default_rng(seed))
    free = place.free
    assert not free[[0, -1]].any()
    assert not free[:, [0, -1]].any()
    assert label(free)[1] == 1
    assert free.mean() > 0.2
    assert np.array_equal(free, PLACES[name](np.random.default_rng(seed)).free)
    assert not np.array_equal(free, PLACES[name](np.random.default_rng(seed + 1)).free)


def test_one_can_walk_all_around_a_ring_and_through_every_room() -> None:
    place = random_ring(np.random.default_rng(1), (70, 90), corridor=12)
    height, width = place.shape
    path = [(13, 13), (width - 14, 13), (width - 14, height - 14), (13, height - 14), (13, 13)]
    metres = place.to_world(path)
    motions = motions_through_waypoints([*metres[0], 0.0], metres[1:], 0.1, 0.2)
    run = simulate(
        place, motions, [*metres[0], 0.0], PERFECT, SimulatedLidar.full_turn(8, 5.0), np.random.default_rng(0)
    )
    np.testing.assert_allclose(run.truth[-1, :2], metres[0], atol=1e-9)
    rooms = random_building(np.random.default_rng(2), (2, 3), room=20)
    assert rooms.shape == (43, 64)
    assert all(rooms.free[y : y + 15, x : x + 15].any() for y in (3, 24) for x in (3, 24, 45))


def test_a_perfect_robot_reads_what_is_there() -> None:
    rng = np.random.default_rng(6)
    start = ROOM.poses_to_world([20.0, 10.0, 0.4])
    lidar = SimulatedLidar.full_turn(24, 2.5)
    run = simulate(ROOM, random_walk(ROOM, start, 200, 0.1, 0.3, rng), start, PERFECT, lidar, rng, period=0.2)
    np.testing.assert_allclose(run.odometry, run.truth, atol=1e-12)
    np.testing.assert_allclose(run.times, 0.2 * np.arange(201))
    cells = ROOM.poses_to_cells(run.truth)
    np.testing.assert_allclose(run.ranges, 0.1 * cast_scans(ROOM.free, cells, 24, 25.0), atol=1e-9)
    scan = run.scan(7)
    assert np.array_equal(scan.ranges, run.ranges[7])
    assert len(run) == 201
    walls = ROOM.to_cells(scan.points() @ rotation(run.truth[7, 2]).T + run.truth[7, :2])
    assert np.all(np.abs(walls - np.rint(walls)).min(axis=1) < 1e-9)


def rotation(theta: float) -> np.ndarray:
    return np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", PLACES)
def test_a_wanderer_hits_nothing_and_gets_somewhere(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = PLACES[name](rng)
    y, x = np.argwhere(place.distances_to_wall > 4 * place.resolution)[0]
    start = place.poses_to_world([x + 0.5, y + 0.5, 1.0])
    motions = random_walk(place, start, 300, 0.05, 0.4, rng)
    run = simulate(place, motions, start, ROBOT, SimulatedLidar.full_turn(4, 5.0), rng)
    assert len(motions) == 300
    assert np.all(place.is_free(run.truth[:, :2]))
    assert np.ptp(run.truth[:, :2], axis=0).max() > 0.5


def test_encoders_err_as_they_were_asked_to() -> None:
    rng = np.random.default_rng(3)
    motions = [Motion(0.02, 0.0)] * 80 + [Motion(0.0, 0.1)] * 40
    start = ROOM.to_world([20.0, 20.0])
    runs = [simulate(ROOM, motions, [*start, 0.0], ROBOT, SimulatedLidar.full_turn(1, 1.0), rng) for _ in range(60)]
    errors = np.array([run.wheels - [ROBOT.wheel_paths(motion) for motion in motions] for run in runs])
    assert np.std(errors) == pytest.approx(0.002, rel=6 / math.sqrt(2 * errors.size))
    assert np.abs(errors.mean()) < 6 * 0.002 / math.sqrt(errors.size)
    assert np.linalg.norm(runs[0].odometry[-1] - runs[0].truth[-1]) > 0.0


def test_each_kind_of_error_of_a_lidar_has_its_share() -> None:
    rng, n = np.random.default_rng(5), 100_000
    lidar = SimulatedLidar(full_turn_angles(1), 10.0, sigma=0.1, short=0.2, miss=0.1, stray=0.05)
    read = lidar.add_noise(np.full(n, 6.0), rng)
    tolerance = 6 * math.sqrt(0.25 / n)
    assert np.mean(read == 10.0) == pytest.approx(0.1, abs=tolerance)
    assert np.mean(read < 5.0) == pytest.approx(0.2 * 5 / 6 + 0.05 * 0.5, abs=tolerance)
    near = read[np.abs(read - 6.0) < 0.5]
    assert len(near) / n == pytest.approx(0.65 + 0.2 * 0.5 / 6 + 0.05 * 0.1, abs=tolerance)
    assert np.all((read >= 0.0) & (read <= 10.0))
    assert np.all(SimulatedLidar.full_turn(1, 10.0, 0.5).add_noise(np.full(100, 10.0), rng) == 10.0)


def test_waypoints_are_reached_by_small_steps() -> None:
    motions = motions_through_waypoints([0.0, 0.0, 3.0], [[1.0, 0.0], [1.0, 0.0], [1.0, -0.25]], 0.1, 0.5)
    assert max(abs(motion.distance) for motion in motions) <= 0.1 + 1e-12
    assert max(abs(motion.turn) for motion in motions) <= 0.5 + 1e-12
    pose = np.array([0.0, 0.0, 3.0])
    for motion in motions:
        pose = PERFECT.step(pose, *PERFECT.wheel_paths(motion))
    np.testing.assert_allclose(pose, [1.0, -0.25, -math.pi / 2], atol=1e-12)


RNG = np.random.default_rng(0)
INSIDE = ROOM.poses_to_world([20.0, 20.0, 0.0])


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("angles", lambda: SimulatedLidar(np.array([math.nan]), 1.0)),
        ("max_range", lambda: SimulatedLidar(np.zeros(1), 0.0)),
        ("sigma", lambda: SimulatedLidar(np.zeros(1), 1.0, -1.0)),
        ("miss", lambda: SimulatedLidar(np.zeros(1), 1.0, miss=1.5)),
        ("stray", lambda: SimulatedLidar(np.zeros(1), 1.0, short=0.5, miss=0.4, stray=0.3)),
        ("motions", lambda: simulate(ROOM, [Motion(9.0, 0.0)], INSIDE, ROBOT, SimulatedLidar.full_turn(1, 1.0), RNG)),
        ("period", lambda: simulate(ROOM, [], INSIDE, ROBOT, SimulatedLidar.full_turn(1, 1.0), RNG, period=0.0)),
        ("start", lambda: motions_through_waypoints([0.0, 0.0], [[1.0, 1.0]], 0.1, 0.1)),
        ("waypoints", lambda: motions_through_waypoints(INSIDE, [1.0, 1.0], 0.1, 0.1)),
        ("step", lambda: motions_through_waypoints(INSIDE, [[1.0, 1.0]], 0.0, 0.1)),
        ("turn", lambda: motions_through_waypoints(INSIDE, [[1.0, 1.0]], 0.1, math.nan)),
        ("start", lambda: random_walk(ROOM, [50.0, 50.0, 0.0], 5, 0.1, 0.1, RNG)),
        ("rooms", lambda: random_building(RNG, (0, 2))),
        ("room", lambda: random_building(RNG, (2, 2), room=6)),
        ("door", lambda: random_building(RNG, (2, 2), door=0)),
        ("shape", lambda: random_clutter(RNG, (2, 9), 3)),
        ("obstacles", lambda: random_clutter(RNG, (9, 9), -1)),
        ("obstacles", lambda: random_clutter(RNG, (4, 4), 900, 3)),
        ("shape", lambda: random_ring(RNG, (20, 20))),
        ("niches", lambda: random_ring(RNG, (70, 70), niches=-1)),
    ],
)
def test_what_cannot_be_simulated_is_named(argument: str, call: Any) -> None:
    with pytest.raises((SimulationError, SceneError)) as error:
        call()
    assert error.value.argument == argument
