"""The journey of the practical work, as it is downloaded.

`files()` gives what is downloaded, by name: a rosbag2, the map, and the same in plain text for who has no ROS.
"""

from __future__ import annotations

from collections.abc import Iterable

from graders.l20.parcours import journey, place
from reference.formats.map_server import OccupancyGrid, write_map
from reference.formats.rosbag import export_rosbag
from reference.formats.trajectory_files import Trajectory, write_tum

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


def files() -> dict[str, bytes]:
    """Name to content; the names give folders."""
    run = journey()
    bag = export_rosbag(run, localised=False)
    world = place()
    drawn = write_map(OccupancyGrid.from_grid_map(world), "carte.pgm")
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
