"""The journey of the practical work: a simulated robot makes two loops through the module's map, at 50 cm a cell.

`files()` gives what is downloaded, by name: a rosbag2, the map, and the same in plain text for who has no ROS.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from curriculum.l20.kit import l20 as kit
from reference.formats.map_server import OccupancyGrid, write_map
from reference.formats.rosbag import export_rosbag
from reference.formats.trajectory_files import Trajectory, write_tum
from reference.odometry import DifferentialDrive
from reference.world.grid_map import GridMap
from reference.world.simulation import Lidar, Run, motions_through, simulate

CELL = 0.5  # metres
PERIOD = 0.1  # seconds
SEED = 20
START = (12.5, 7.9)  # in cells, as the places below
ROUND = (
    (11.5, 4.0), (8.8, 3.5), (5.5, 3.5), (3.5, 4.5), (3.5, 7.9),  # up, through two rooms, and down again
    (4.5, 8.2), (4.5, 10.9), (7.5, 11.2), (7.5, 13.5), (9.5, 13.5), (12.0, 12.8), (14.5, 13.5), (17.5, 12.0),
    (17.5, 8.2), (12.5, 7.9),  # through the three rooms below, and along the corridor to the start
    (11.5, 4.0), (8.8, 3.5), (5.5, 3.5), (3.5, 4.5), (3.5, 7.9), (12.0, 7.9),  # the first loop once more
)  # fmt: skip

READ_ME = """Parcours simulé du TP « SLAM et navigation »

Un robot à deux roues (entraxe 0,30 m) parcourt deux boucles dans la carte du module, à 0,50 m par case.
Il mesure dix fois par seconde. Unités : mètres, radians, secondes.

bag/             le parcours au format rosbag2 (MCAP) : ros2 bag play bag --clock
                 /scan, /odom, /ground_truth, /tf (odom -> base_link -> laser ; map -> odom est à vous)
slam.yaml        des réglages de slam_toolbox pour ce robot
carte.yaml, .pgm la carte, pour map_server
roues.csv        t, ds_gauche, ds_droite : ce que comptent les encodeurs entre deux scans
scans.csv        t, puis 180 distances ; le rayon k vise l'angle 2*pi*k/180 depuis le cap ; 8 veut dire « rien »
verite.tum       t x y z qx qy qz qw : la vraie pose, pour mesurer vos erreurs à la fin seulement
"""

SLAM = """slam_toolbox:
  ros__parameters:
    use_sim_time: true
    mode: mapping
    solver_plugin: solver_plugins::CeresSolver
    map_frame: map
    odom_frame: odom
    base_frame: base_link
    scan_topic: /scan
    resolution: 0.05
    max_laser_range: 8.0
    minimum_travel_distance: 0.3
    minimum_travel_heading: 0.4
    do_loop_closing: true
"""


def journey() -> Run:
    """The same at each call."""
    places = CELL * np.array([START, *ROUND])
    world = GridMap.from_free(kit.lire_plan(kit.PLAN), CELL)
    start = np.array([*places[0], -np.pi / 2])
    drive = DifferentialDrive(track=0.3, sigma=2e-4, sigma_per_root_metre=1.2e-2)
    lidar = Lidar.full_turn(180, 8.0, sigma=0.015)
    motions = motions_through(start, places[1:], step=0.04, turn=0.12)
    return simulate(world, motions, start, drive, lidar, np.random.default_rng(SEED), PERIOD)


def files() -> dict[str, bytes]:
    """Name to content; the names give folders."""
    run = journey()
    bag = export_rosbag(run, localised=False)
    world = GridMap.from_free(kit.lire_plan(kit.PLAN), CELL)
    drawn = write_map(OccupancyGrid.of(world), "carte.pgm")
    texts = {
        "LISEZ-MOI.txt": READ_ME,
        "bag/metadata.yaml": bag.metadata,
        "carte.yaml": drawn.yaml,
        "slam.yaml": SLAM,
        "roues.csv": _table("t,ds_gauche,ds_droite", run.times[1:], run.wheels, 6),
        "scans.csv": _table("t," + ",".join(f"d{k}" for k in range(180)), run.times, run.ranges, 3),
        "verite.tum": write_tum(Trajectory.from_planar(run.times, run.truth)),
    }
    return {name: text.encode() for name, text in texts.items()} | {"bag/run.mcap": bag.mcap, "carte.pgm": drawn.pgm}


def _table(header: str, times: Iterable[float], rows: Iterable[Iterable[float]], digits: int) -> str:
    lines = (
        f"{time:.1f}," + ",".join(f"{value:.{digits}f}" for value in row) for time, row in zip(times, rows, strict=True)
    )
    return header + "\n" + "\n".join(lines) + "\n"
