"""The journey of the practical work: a simulated robot makes two loops through the module's map, at 50 cm a cell."""

from __future__ import annotations

from functools import cache

import numpy as np

from graders.core.contract.local import initial_globals
from graders.l20 import world
from reference.odometry import DifferentialDrive
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar, SimulatedRun, motions_through_waypoints, simulate

CELL = 0.5  # metres
PERIOD = 0.1  # seconds
TRACK = 0.3  # metres
BEAMS, REACH = 180, 8.0
SEED = 20
START = (12.5, 7.9)  # in cells, as the places below
ROUND = (
    (11.5, 4.0), (8.8, 3.5), (5.5, 3.5), (3.5, 4.5), (3.5, 7.9),  # up, through two rooms, and down again
    (4.5, 8.2), (4.5, 10.9), (7.5, 11.2), (7.5, 13.5), (9.5, 13.5), (12.0, 12.8), (14.5, 13.5), (17.5, 12.0),
    (17.5, 8.2), (12.5, 7.9),  # through the three rooms below, and along the corridor to the start
    (11.5, 4.0), (8.8, 3.5), (5.5, 3.5), (3.5, 4.5), (3.5, 7.9), (12.0, 7.9),  # the first loop once more
)  # fmt: skip


def place() -> GridMap:
    """The module's map, in metres."""
    return GridMap.from_free(initial_globals(world.STILL)["libres"], CELL)


@cache
def journey() -> SimulatedRun:
    """The same at each call."""
    places = CELL * np.array([START, *ROUND])
    start = np.array([*places[0], -np.pi / 2])
    drive = DifferentialDrive(track=TRACK, sigma=2e-4, sigma_per_root_metre=1.2e-2)
    lidar = SimulatedLidar.full_turn(BEAMS, REACH, sigma=0.015)
    motions = motions_through_waypoints(start, places[1:], step=0.04, turn=0.12)
    return simulate(place(), motions, start, drive, lidar, np.random.default_rng(SEED), PERIOD)
