"""Kidnapped robots: how long a filter that is sure of the wrong place takes to find its robot again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from curriculum.l20.figures._plan import module_map
from reference.localisation.mcl import InjectionRule, MonteCarloLocalization, uniform_poses
from reference.localisation.odometry_motion import OdometryNoise
from reference.odometry import DifferentialDrive
from reference.se2 import relative, wrap_angle
from reference.sensors.beam import BeamModel, BeamSensor
from reference.world.simulation import SimulatedLidar, SimulatedRun, SimulationError, random_walk, simulate

Floats = NDArray[np.float64]

STEPS = 100
PARTICLES = 500
LASTING = 3  # steps in a row near the truth
INJECTIONS = {
    "sans injection": None,
    "5 % au hasard": InjectionRule(0, 0, 0.05, 1),
    "5 % bien choisis": InjectionRule(0, 0, 0.05, 40),
}


def recovery(injection: InjectionRule | None, seed: int) -> int | None:
    """The first of three steps in a row that the filter spends near its robot, from 1; None if there are none."""
    rng = np.random.default_rng(seed)
    run = _journey(rng)
    believed = uniform_poses(module_map(), 1, rng)[0]
    while np.hypot(*(believed - run.truth[0])[:2]) < 5.0:
        believed = uniform_poses(module_map(), 1, rng)[0]
    cloud = believed + rng.normal(0, [0.3, 0.3, 0.1], (PARTICLES, 3))
    sensor = BeamSensor(module_map(), BeamModel(12.0, sigma=0.5), 0.3)
    motion = OdometryNoise(0.2, 0.1, 0.15, 0.05)
    robot = MonteCarloLocalization(module_map(), sensor, cloud, rng, motion=motion, injection=injection)
    near = 0
    for k in range(len(run)):
        if k:
            robot.predict(relative(run.odometry[k - 1], run.odometry[k]))
        robot.correct(run.scan(k))
        near = near + 1 if _is_near(robot.clusters()[0].mean, run.truth[k]) else 0
        if near == LASTING:
            return k - LASTING + 2
    return None


def _is_near(pose: Floats, truth: Floats) -> bool:
    away = pose - truth
    return bool(np.hypot(*away[:2]) < 0.8 and abs(wrap_angle(float(away[2]))) < 0.3)


def _journey(rng: np.random.Generator) -> SimulatedRun:
    """A walk of a robot through the module's map, from anywhere."""
    drive, lidar = DifferentialDrive(0.6, 0.0, 0.03), SimulatedLidar.full_turn(36, 12.0, 0.1)
    while True:
        start = uniform_poses(module_map(), 1, rng)[0]
        try:
            motions = random_walk(module_map(), start, STEPS, 0.5, 0.5, rng)
            return simulate(module_map(), motions, start, drive, lidar, rng)
        except SimulationError:  # it led off the free cells: another start
            continue
