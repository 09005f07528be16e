"""What the texts measure of particle filters on the module's map: séance 1 and the défi of the kidnapped robot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from curriculum.l20.figures._kidnapped import STEPS, recovery
from curriculum.l20.figures._plan import module_map
from reference.filters.resampling import Scheme, multinomial_resampling, systematic_resampling
from reference.localisation.mcl import InjectionRule, MonteCarloLocalization, uniform_poses
from reference.localisation.odometry_motion import OdometryNoise
from reference.odometry import DifferentialDrive
from reference.se2 import relative, wrap_angle
from reference.sensors.beam import BeamModel, BeamSensor
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar, SimulatedRun, SimulationError, random_walk, simulate
from tests.content.curriculum.measured.tables import Cell

Floats = NDArray[np.float64]

SOUGHT = (100, 300, 500, 1000, 3000)
JOURNEYS, LENGTH, BEAMS, LAST = 40, 60, 12, 5
NOISE = OdometryNoise(0.2, 0.1, 0.15, 0.05)
SEEDS = 30
INJECTED = {
    "none": None,
    "even": InjectionRule(0.0, 0.0, 0.05, 1),
    "augmented": InjectionRule(0.05, 0.5, 0.0, 1),
    "chosen": InjectionRule(0.0, 0.0, 0.05, 40),
}


def journey(grid_map: GridMap, steps: int, beams: int, rng: np.random.Generator) -> SimulatedRun:
    """A walk of half a cell a step, from anywhere: the wheels slip a little, the lidar errs by 0.1 cell."""
    drive, lidar = DifferentialDrive(0.6, 0.0, 0.03), SimulatedLidar.full_turn(beams, 12.0, 0.1)
    while True:
        start = uniform_poses(grid_map, 1, rng)[0]
        try:
            return simulate(grid_map, random_walk(grid_map, start, steps, 0.5, 0.5, rng), start, drive, lidar, rng)
        except SimulationError:  # it led off the free cells: another start
            continue


def beam_sensor(grid_map: GridMap, power: float = 0.3) -> BeamSensor:
    return BeamSensor(grid_map, BeamModel(12.0, sigma=0.5), power)


def localised(count: int, injection: InjectionRule | None, seed: int) -> bool:
    """From nothing, does the heaviest cloud keep within a cell of the robot for the last five steps?"""
    rng, grid_map = np.random.default_rng(seed), module_map()
    run = journey(grid_map, LENGTH, BEAMS, rng)
    start = uniform_poses(grid_map, count, rng)
    robot = MonteCarloLocalization(grid_map, beam_sensor(grid_map), start, rng, motion=NOISE, injection=injection)
    for k in range(len(run)):
        if k:
            robot.predict(relative(run.odometry[k - 1], run.odometry[k]))
        robot.correct(run.scan(k))
        if k >= len(run) - LAST and np.hypot(*(robot.clusters()[0].mean - run.truth[k])[:2]) > 1.0:
            return False
    return True


def successes(count: int, injection: InjectionRule | None) -> int:
    return sum(localised(count, injection, seed) for seed in range(JOURNEYS))


def how_many() -> Iterator[list[Cell]]:
    for count in SOUGHT:
        yield [float(successes(count, None)), float(successes(count, INJECTED["even"]))]


def guided() -> float:
    """Out of 40, with 500 particles of which 5 % are drawn anew at each step, each the pick of twenty."""
    return float(successes(500, InjectionRule(0.0, 0.0, 0.05, 20)))


def kidnapped() -> Iterator[list[Cell]]:
    for injection in INJECTED.values():
        steps = [recovery(injection, seed) for seed in range(SEEDS)]
        found = sorted(step for step in steps if step is not None)
        times = sorted(step if step is not None else STEPS + 1 for step in steps)
        middle = (times[SEEDS // 2 - 1] + times[SEEDS // 2]) / 2.0
        yield [len(found) / SEEDS, middle if found else None]


def tracked(threshold: float, seed: int) -> tuple[int, float, bool]:
    """A hundred particles that start about the truth: draws, error after ten steps (rms), lost in the end?"""
    rng, grid_map = np.random.default_rng(seed), module_map()
    run = journey(grid_map, LENGTH, 36, rng)
    cloud = run.truth[0] + rng.normal(0, [0.3, 0.3, 0.1], (100, 3))
    robot = MonteCarloLocalization(grid_map, beam_sensor(grid_map), cloud, rng, motion=NOISE, threshold=threshold)
    draws, away = 0, []
    for k in range(len(run)):
        if k:
            robot.predict(relative(run.odometry[k - 1], run.odometry[k]))
        robot.weigh(run.scan(k))
        if threshold == 1.0 or robot.is_degenerate:
            robot.resample()
            draws += 1
        away.append(float(np.hypot(*(robot.mean - run.truth[k])[:2])))
    return draws, float(np.sqrt(np.mean(np.square(away[10:])))), away[-1] > 1.0


def when_to_draw() -> Iterator[list[Cell]]:
    for threshold in (0.0, 0.25, 0.5, 1.0):
        found = [tracked(threshold, seed) for seed in range(SEEDS)]
        draws, errors, lost = zip(*found, strict=True)
        yield [float(np.median(draws)), float(np.median(errors)), float(np.sum(lost))]


HALL = GridMap.from_free(np.pad(np.ones((30, 80), dtype=bool), 1), 0.1)
CENTRE = np.array([4.1, 1.6])
RUNS, PACES, HALF = 20, 200, 50


def mirrored(poses: Floats) -> Floats:
    """The same poses after half a turn of the hall."""
    return np.column_stack([2 * CENTRE - poses[:, :2], wrap_angle(poses[:, 2] + np.pi)])


def ambiguous(scheme: Scheme, threshold: float, seed: int) -> tuple[int | None, bool]:
    """When one of the two clouds died out, None if both live; and whether it was the true one."""
    rng = np.random.default_rng(seed)
    drive, lidar = DifferentialDrive(0.6, 0.0, 0.03), SimulatedLidar.full_turn(36, 12.0, 0.1)
    start = np.array([1.5, 1.6, 0.0])
    motions = random_walk(HALL, start, PACES, 0.25, 0.5, rng)
    run = simulate(HALL, motions, start, drive, lidar, rng)
    near = start + rng.normal(0, [0.1, 0.1, 0.05], (HALF, 3))
    robot = MonteCarloLocalization(
        HALL, beam_sensor(HALL, 0.1), np.vstack([near, mirrored(near)]), rng, motion=NOISE, threshold=threshold
    )
    robot.scheme = scheme
    for k in range(1, len(run)):
        robot.predict(relative(run.odometry[k - 1], run.odometry[k]))
        robot.weigh(run.scan(k))
        if threshold == 1.0 or robot.is_degenerate:
            robot.resample()
        turned = np.cos(robot.states[:, 2] - run.truth[k, 2]) < 0.0
        if turned.all() or not turned.any():
            return k, bool(turned.all())
    return None, False


def two_clouds() -> Iterator[list[Cell]]:
    for scheme, threshold in (
        (multinomial_resampling, 1.0),
        (multinomial_resampling, 0.5),
        (systematic_resampling, 1.0),
    ):
        ends = [ambiguous(scheme, threshold, seed)[0] for seed in range(RUNS)]
        died = [end for end in ends if end is not None]
        yield [len(died) / RUNS, float(np.median([PACES if end is None else end for end in ends]))]


def truth_lost() -> int:
    """How often it is the true cloud that died, of twenty, with independent draws at each step."""
    return sum(ambiguous(multinomial_resampling, 1.0, seed)[1] for seed in range(RUNS))
