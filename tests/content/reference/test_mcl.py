"""Monte Carlo localisation in simulation: lost robots are found, kidnapped ones again, ambiguity stays visible."""

import math
from collections.abc import Callable
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.errors import InvalidArgumentError
from reference.filters.bayes import BayesFilter, ImpossibleMeasurementError
from reference.formats.map_server import read_map
from reference.localisation.kld_sampling import KldSampling
from reference.localisation.mcl import (
    InjectionRule,
    LikelihoodAverages,
    MonteCarloLocalization,
    likely_poses,
    uniform_poses,
)
from reference.localisation.odometry_motion import OdometryNoise
from reference.localisation.pose_clusters import find_clusters
from reference.odometry import DifferentialDrive
from reference.se2 import relative, wrap_angle
from reference.sensors.beam import BeamModel, BeamSensor
from reference.sensors.likelihood_field import LikelihoodField
from reference.world.grid_map import GridMap
from reference.world.scan import Scan, full_turn_angles
from reference.world.scenes import random_building
from reference.world.simulation import SimulatedLidar, SimulatedRun, SimulationError, random_walk, simulate

DRIVE = DifferentialDrive(0.3, 0.002, 0.02)
LIDAR = SimulatedLidar(SimulatedLidar.full_turn(30, 8.0).angles, 8.0, sigma=0.05, short=0.03, miss=0.03, stray=0.03)
MOTION = OdometryNoise(0.2, 0.1, 0.15, 0.05)
RECOVERY = InjectionRule(slow=0.05, fast=0.5, tries=40)


def place(seed: int) -> tuple[GridMap, np.random.Generator]:
    """A building of six rooms, 8 m by 12 m."""
    rng = np.random.default_rng(seed)
    return random_building(rng, (2, 3), resolution=0.2), rng


def journey(grid_map: GridMap, rng: np.random.Generator, steps: int) -> SimulatedRun:
    """A robot that wanders from anywhere, three beams in thirty of its lidar being wrong."""
    while True:
        start = uniform_poses(grid_map, 1, rng)[0]
        try:
            return simulate(grid_map, random_walk(grid_map, start, steps, 0.3, 0.5, rng), start, DRIVE, LIDAR, rng)
        except SimulationError:
            continue


def lost(
    grid_map: GridMap,
    rng: np.random.Generator,
    scan: Scan,
    injection: InjectionRule | None,
    kld: KldSampling | None = None,
) -> MonteCarloLocalization:
    """500 particles that know nothing but a first scan."""
    field = LikelihoodField(grid_map, sigma=0.2, max_range=8.0, power=0.3)
    start = likely_poses(grid_map, field, scan, 500, rng)
    return MonteCarloLocalization(grid_map, field, start, rng, motion=MOTION, injection=injection, kld=kld)


def found(robot: MonteCarloLocalization, run: SimulatedRun) -> bool:
    """Follow the run; after each of its last three scans, is the heaviest cloud near the truth?"""
    near = []
    for i in range(len(run)):
        if i > 0:
            robot.predict(relative(run.odometry[i - 1], run.odometry[i]))
        robot.correct(run.scan(i))
        if i >= len(run) - 3:
            away = robot.clusters()[0].mean - run.truth[i]
            near.append(math.hypot(*away[:2]) < 0.4 and abs(wrap_angle(float(away[2]))) < 0.3)
    return all(near)


def test_500_particles_find_a_lost_robot() -> None:
    """On 8 seeded buildings, from nothing, in 20 steps; one failure is allowed for."""
    successes = 0
    for seed in range(8):
        grid_map, rng = place(seed)
        run = journey(grid_map, rng, 20)
        robot = lost(grid_map, rng, run.scan(0), InjectionRule(slow=0.05, fast=0.5, always=0.05, tries=40))
        successes += found(robot, run)
        assert len(robot.states) == 500
    assert successes >= 7


def test_a_kidnapped_robot_is_found_again_only_when_poses_are_drawn_anew() -> None:
    """The robot is carried elsewhere without a word of its odometry. Six seeds."""
    recovered = {True: 0, False: 0}
    for seed in range(6):
        for augmented in recovered:
            grid_map, rng = place(seed)
            before, after = journey(grid_map, rng, 12), journey(grid_map, rng, 20)
            robot = lost(grid_map, rng, before.scan(0), RECOVERY if augmented else None)
            found(robot, before)
            recovered[augmented] += found(robot, after)
    assert recovered[True] >= 5
    assert recovered[False] <= 2


def test_500_particles_find_a_robot_on_the_map_of_the_turtlebot(dataset: Callable[[str], bytes]) -> None:
    """Nine equal pillars in a hexagon, 20 square metres at 5 cm a cell, a lidar of 3.5 m: six seeds, 40 steps."""
    grid_map = read_map(dataset("mcl/turtlebot3_map.yaml").decode(), dataset("mcl/turtlebot3_map.pgm")).to_grid_map()
    drive, lidar = (
        DifferentialDrive(0.16, 0.002, 0.02),
        SimulatedLidar(full_turn_angles(36), 3.5, 0.02, 0.02, 0.02, 0.02),
    )
    field = LikelihoodField(grid_map, sigma=0.1, max_range=3.5, power=0.3)
    errors = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        run = None
        while run is None:
            start = uniform_poses(grid_map, 1, rng)[0]
            with suppress(SimulationError):
                run = simulate(grid_map, random_walk(grid_map, start, 40, 0.15, 0.5, rng), start, drive, lidar, rng)
        start = likely_poses(grid_map, field, run.scan(0), 500, rng)
        robot = MonteCarloLocalization(
            grid_map, field, start, rng, motion=MOTION, injection=InjectionRule(0.05, 0.5, 0.05, tries=40)
        )
        found(robot, run)
        errors.append(math.hypot(*(robot.clusters()[0].mean - run.truth[-1])[:2]))
    assert np.count_nonzero(np.array(errors) < 0.15) >= 5


def hall() -> GridMap:
    """An empty hall of 8 m by 3 m: seen from one end just as from the other."""
    free = np.zeros((34, 84), dtype=bool)
    free[2:-2, 2:-2] = True
    return GridMap.from_free(free, 0.1)


def test_a_symmetrical_hall_leaves_two_clouds() -> None:
    grid_map, rng = hall(), np.random.default_rng(1)
    truth = np.array([2.2, 1.2, 0.3])
    lidar = SimulatedLidar.full_turn(36, 12.0)
    scan = Scan(lidar.measure_ranges(grid_map, truth[None, :], rng)[0], lidar.angles, 12.0)
    field = LikelihoodField(grid_map, sigma=0.15, max_range=12.0, power=0.5)
    robot = MonteCarloLocalization(grid_map, field, likely_poses(grid_map, field, scan, 1000, rng), rng)
    for _ in range(2):
        robot.correct(scan)
    two = robot.clusters()[:2]
    assert min(cloud.weight for cloud in two) > 0.25
    assert sum(cloud.weight for cloud in two) > 0.9
    mirror = np.array([8.4 - truth[0], 3.4 - truth[1], truth[2] - math.pi])
    for pose in (truth, mirror):
        assert min(np.hypot(*(cloud.mean - pose)[:2]) for cloud in two) < 0.25
    # The mean of all particles is a place where the robot is not.
    assert np.hypot(*(robot.mean - truth)[:2]) > 0.7


def test_kld_sampling_spends_particles_where_the_belief_is_wide() -> None:
    grid_map, rng = place(1)
    run = journey(grid_map, rng, 12)
    robot = lost(grid_map, rng, run.scan(0), None, KldSampling(epsilon=0.05, least=50, most=2000))
    robot.states = uniform_poses(grid_map, 2000, rng)
    robot.weights = np.full(2000, 1 / 2000)
    robot.resample()
    wide = len(robot.states)
    found(robot, run)
    assert wide > 1500
    assert 50 <= len(robot.states) < 500


def test_a_tracked_robot_stays_tracked_with_the_beam_model() -> None:
    grid_map, rng = place(2)
    run = journey(grid_map, rng, 8)
    sensor = BeamSensor(grid_map, BeamModel(8.0, 0.85, 0.05, 0.05, 0.05, sigma=0.2), power=0.3)
    start = run.truth[0] + rng.normal(0.0, [0.2, 0.2, 0.1], (200, 3))
    robot: BayesFilter[np.ndarray, Scan] = MonteCarloLocalization(grid_map, sensor, start, rng, motion=MOTION)
    for i in range(1, len(run)):
        robot.predict(relative(run.odometry[i - 1], run.odometry[i]))
        robot.correct(run.scan(i))
    assert np.hypot(*(robot.mean - run.truth[-1])[:2]) < 0.25
    assert abs(wrap_angle(robot.mean[2] - run.truth[-1, 2])) < 0.2
    assert np.sqrt(robot.covariance[0, 0]) < 0.3


def test_the_share_to_inject_follows_the_two_averages() -> None:
    """Equation (1) by hand: slow 0.1, fast 0.5, likelihoods 1, 1, then 0.2."""
    averages, rule = LikelihoodAverages(), InjectionRule(slow=0.1, fast=0.5, always=0.02)
    assert averages.update_and_share(1.0, rule) == averages.update_and_share(1.0, rule) == 0.02
    assert averages.update_and_share(0.2, rule) == pytest.approx(1.0 - 0.6 / 0.92)
    assert averages.update_and_share(0.2, InjectionRule(0.0, 0.0, 0.02)) == pytest.approx(1.0 - 0.6 / 0.92)
    assert LikelihoodAverages(0.0, 0.0).update_and_share(0.0, rule) == 0.02


def test_poses_are_drawn_evenly_on_the_free_cells() -> None:
    rng = np.random.default_rng(3)
    free = np.array([[1, 0, 1], [1, 1, 0]], dtype=bool)
    grid_map = GridMap.from_free(free, 0.5, (3.0, -1.0, 0.7))
    poses = uniform_poses(grid_map, 20_000, rng)
    assert grid_map.is_free(poses[:, :2]).mean() > 0.9999
    cells = np.floor(grid_map.to_cells(poses[:, :2])).astype(int)
    counts = np.bincount(cells[:, 1] * 3 + cells[:, 0], minlength=6)[free.ravel()]
    assert np.all(np.abs(counts - 5000) < 5.0 * math.sqrt(20_000 * 0.25 * 0.75))
    quadrants = np.bincount(np.floor((poses[:, 2] + np.pi) / (np.pi / 2)).astype(int) % 4)
    assert np.all(np.abs(quadrants - 5000) < 5.0 * math.sqrt(20_000 * 0.25 * 0.75))


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_clouds_share_the_particles_by_brute_force(seed: int, n: int) -> None:
    """Two particles are in one cloud if and only if a chain of touching bins leads from one to the other."""
    rng = np.random.default_rng(seed)
    poses = np.column_stack([rng.uniform(0.0, 5.0, (n, 2)), rng.uniform(-4.0, 4.0, n)])
    weights = rng.random(n) + 0.01
    bins = np.column_stack([np.floor(poses[:, :2] / 0.5), np.floor((poses[:, 2] % (2 * np.pi)) * 12 / (2 * np.pi))])
    apart = np.abs(bins[:, None, :] - bins[None, :, :])
    apart[..., 2] = np.minimum(apart[..., 2], 12 - apart[..., 2])
    linked = np.all(apart <= 1, axis=2)
    for _ in range(n):
        linked = linked @ linked
    found = find_clusters(poses, weights)
    assert sorted(np.concatenate([cloud.members for cloud in found]).tolist()) == list(range(n))
    assert sum(cloud.weight for cloud in found) == pytest.approx(1.0)
    for cloud in found:
        assert np.array_equal(np.flatnonzero(linked[cloud.members[0]]), cloud.members)


def test_a_scan_that_no_particle_can_have_seen_is_refused_and_nothing_changes() -> None:
    grid_map, rng = place(0)
    sensor = BeamSensor(grid_map, BeamModel(8.0, 0.0, 1.0, 0.0, 0.0))
    robot = MonteCarloLocalization(grid_map, sensor, uniform_poses(grid_map, 20, rng), rng)
    before = robot.states.copy()
    with pytest.raises(ImpossibleMeasurementError):
        robot.correct(Scan.full_turn([8.0] * 4, 8.0))
    assert np.array_equal(robot.states, before)


def test_input_without_meaning_is_named() -> None:
    grid_map, rng = place(0)
    field = LikelihoodField(grid_map)
    robot = MonteCarloLocalization(grid_map, field, uniform_poses(grid_map, 9, rng), rng)
    walls = GridMap.from_free(np.zeros((2, 2)))
    for argument, call in (
        ("states", lambda: MonteCarloLocalization(grid_map, field, np.empty((0, 3)), rng)),
        ("control", lambda: robot.predict(np.array([0.0, math.nan, 0.0]))),
        ("scan", lambda: robot.correct(Scan.full_turn([], 8.0))),
        ("grid_map", lambda: uniform_poses(walls, 3, rng)),
        ("slow", lambda: InjectionRule(slow=0.6, fast=0.5)),
        ("always", lambda: InjectionRule(always=1.0)),
        ("tries", lambda: InjectionRule(tries=0)),
        ("poses", lambda: find_clusters(np.empty((0, 3)), [])),
        ("weights", lambda: find_clusters(np.zeros((2, 3)), [0.0, 0.0])),
        ("cell", lambda: find_clusters(np.zeros((2, 3)), [0.5, 0.5], cell=0.0)),
        ("sectors", lambda: find_clusters(np.zeros((2, 3)), [0.5, 0.5], sectors=0)),
    ):
        with pytest.raises(InvalidArgumentError) as refusal:
            call()
        assert refusal.value.argument == argument
