"""Numbers that the texts measure outside tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt, distance_transform_edt

from curriculum.l20.figures import slam
from curriculum.l20.figures._plan import module_map
from reference.localisation.mcl import InjectionRule, MonteCarloLocalization, uniform_poses
from reference.registration import icp
from reference.registration.icp import PairingRule
from reference.se2 import relative
from reference.sensors.beam import BeamModel, BeamSensor
from reference.sensors.likelihood_field import LikelihoodField
from reference.world.grid_map import GridMap
from reference.world.scan import Scan
from reference.world.simulation import SimulatedLidar
from tests.content.curriculum.measured.graphs import best, repeated
from tests.content.curriculum.measured.particles import BEAMS, LENGTH, NOISE, journey

Floats = NDArray[np.float64]

RANGE = 12.0


def astray_in_a_circle(runs: int = 4000) -> float:
    """A thousand steps of 11.5 cm that each turn by 0.1 rad: the root mean square of how far the end is, in metres."""
    rng = np.random.default_rng(0)
    errors = rng.normal(0.0, np.sqrt(2.0) * 1e-3 / 0.3, (runs, 1000))
    planned = 0.1 * (np.arange(1000) + 0.5)
    heading = planned + np.cumsum(errors, axis=1) - errors / 2.0
    ends = 0.115 * np.exp(1j * heading).sum(axis=1)
    return float(np.sqrt(np.mean(np.abs(ends - 0.115 * np.exp(1j * planned).sum()) ** 2)))


def quarter_circle(*, middle: bool) -> float:
    """Ten steps along a quarter of a circle of one metre: how far odometry ends from it, in metres."""
    turn = np.pi / 20.0
    headings = turn * (np.arange(10) + (0.5 if middle else 0.0))
    return float(abs(turn * np.exp(1j * headings).sum() - (1.0 + 1.0j)))


def ray_in_the_map(count: int = 20_000) -> tuple[float, float]:
    """From a random place of the module's map: how far a ray goes, and how many cells it visits, its own included."""
    rng = np.random.default_rng(0)
    poses = uniform_poses(module_map(), count, rng)
    lengths = module_map().cast_scans(poses, np.zeros(1), RANGE)[:, 0]
    x, y, theta = poses.T
    ends = np.column_stack([x + lengths * np.cos(theta), y + lengths * np.sin(theta)])
    crossed = np.abs(np.floor(ends - 1e-9 * np.sign(ends - poses[:, :2])) - np.floor(poses[:, :2])).sum(axis=1)
    return float(lengths.mean()), float(crossed.mean() + 1.0)


def farther_by_steps() -> float:
    """The share of the free cells that a search in breadth finds farther from a wall than they are, in per cent."""
    free = np.pad(module_map().free, 1)
    by_steps, straight = distance_transform_cdt(free, "taxicab"), distance_transform_edt(free)
    return float(100.0 * np.mean((by_steps > straight + 1e-9)[free]))


def intruders() -> tuple[float, float, float]:
    """How far ICP ends from the truth on the scans of the séance: as they are, with 25 points of a passer-by at the end
    of the second, and with the same when only the best 80 % of the pairs are kept."""
    Q, P = slam.clouds()
    rng = np.random.default_rng(0)
    angle = rng.uniform(0.0, 2.0 * np.pi, 25)
    person = np.array([1.5, 1.0]) + 0.3 * np.column_stack([np.cos(angle), np.sin(angle)])
    crowd = np.vstack([P, person])
    ends = [
        icp(cloud, Q, max_iterations=120, pairing=PairingRule(keep=keep)).T_q_p
        for cloud, keep in ((P, 1.0), (crowd, 1.0), (crowd, 0.8))
    ]
    plain, disturbed, trimmed = (float(np.hypot(*(end - slam.MOVE)[:2])) for end in ends)
    return plain, disturbed, trimmed


def faster_by_field() -> float:
    """How many times faster 500 particles are weighed by 30 rays in a map of 240 by 160 cells, than by casting them."""
    fine = GridMap.from_free(np.kron(module_map().free, np.ones((10, 10), dtype=bool)), 0.1)
    rng, lidar = np.random.default_rng(0), SimulatedLidar.full_turn(30, RANGE, 0.1)
    cloud, robot = uniform_poses(fine, 500, rng), uniform_poses(fine, 1, rng)
    scan = Scan(lidar.measure_ranges(fine, robot, rng)[0], lidar.angles, RANGE)
    field, beams = LikelihoodField(fine, max_range=RANGE), BeamSensor(fine, BeamModel(RANGE))
    slow, quick = (best(repeated(lambda one=one: one.log_likelihood(cloud, scan), 20), 5) for one in (beams, field))
    return slow / quick


def by_field(fineness: int, seeds: int = 20) -> tuple[int, float]:
    """Global localisations by a likelihood field of so many cells a cell: successes, median error at the end."""
    grid_map, errors = module_map(), []
    fine = GridMap.from_free(np.kron(grid_map.free, np.ones((fineness, fineness), dtype=bool)), 1.0 / fineness)
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        run = journey(grid_map, LENGTH, BEAMS, rng)
        sensor = LikelihoodField(fine, sigma=0.5, max_range=RANGE, power=0.3)
        start = uniform_poses(grid_map, 500, rng)
        robot = MonteCarloLocalization(
            grid_map, sensor, start, rng, motion=NOISE, injection=InjectionRule(0.0, 0.0, 0.05, 20)
        )
        for k in range(len(run)):
            if k:
                robot.predict(relative(run.odometry[k - 1], run.odometry[k]))
            robot.correct(run.scan(k))
        errors.append(float(np.hypot(*(robot.clusters()[0].mean - run.truth[-1])[:2])))
    return sum(error < 1.0 for error in errors), float(np.median(errors))
