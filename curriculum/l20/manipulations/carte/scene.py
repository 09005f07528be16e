"""Dessiner une carte, y poser un robot, et voir s'il s'y retrouve."""

from __future__ import annotations

import numpy as np

from curriculum.l20.manipulations._filtre import film
from graders.scene.hands import Cells, ReplayRequest, Start, cells_text
from graders.scene.parameters import Dragged
from graders.scene.replay import Choice, Draw, Key, Replay, Values, View
from reference.localisation.mcl import uniform_poses
from reference.odometry import DifferentialDrive, integrate_poses
from reference.world.grid_map import GridMap
from reference.world.simulation import random_walk

TITLE = "Votre carte, et un robot qui s'y perd"
ALT = (
    "Un quadrillage de 12 lignes et 18 colonnes que l'on peint : chaque case est libre ou un mur. Un robot bleu se "
    "pose où l'on veut. Le filtre part ensuite de particules semées sur toute la carte, pendant que le robot s'y "
    "promène, et l'on voit si la carte dessinée permet de s'y reconnaître."
)
PLAN = """
##################
#......#.........#
#......#....##...#
#...........##...#
#................#
#......#.........#
###..###.........#
#......####..#####
#..#...#.........#
#................#
#..........#.....#
##################
"""
ROWS, COLUMNS = 12, 18
DRAWN = np.array([list(line) for line in PLAN.split()]) == "#"
PARAMETERS = {
    "particules": Choice("Particules", tuple((str(n), str(n)) for n in (100, 300, 1000)), "1000"),
    "lance": ReplayRequest(),
    "robot": Dragged("Robot", (3.5, 3.5, 0.0), (1.0, 1.0, COLUMNS - 1.0, ROWS - 1.0)),
    "cases": Cells("Votre carte", ROWS, COLUMNS, cells_text(DRAWN)),
    "tirage": Draw("Une autre promenade", default=1),
}
STEPS, STRIDE, TURN, INJECTED = 40, 0.4, 0.6, 0.05


def compute(values: Values, rng: np.random.Generator) -> Start | Replay:
    if not values.flag("lance"):
        keys = [Key("cell", "ink", "mur"), Key("robot", "truth", "départ du robot")]
        return Start(View(0, 0, COLUMNS, ROWS), {"rows": ROWS, "columns": COLUMNS}, keys)
    grid = drawn_map(PARAMETERS["cases"].cells(values.choice("cases")))
    start = np.array(values.pose("robot"))
    start[:2] = nearest_free(grid, start[:2])
    motions = random_walk(grid, start, STEPS, STRIDE, TURN, rng)
    drive = DifferentialDrive(0.5)
    path = integrate_poses(drive, [drive.wheel_paths(motion) for motion in motions], start)
    count = int(values.choice("particules"))
    begun = f"Au départ : {count} particules au hasard sur votre carte."
    return film(grid, path, uniform_poses(grid, count, rng), INJECTED, rng, begun)


def drawn_map(walls: np.ndarray) -> GridMap:
    """La carte dessinée, fermée tout autour ; une case s'y ouvre si tout est mur, pour que le robot y tienne."""
    free = ~walls
    free[[0, -1], :] = free[:, [0, -1]] = False
    if not free.any():
        free[ROWS // 2, COLUMNS // 2] = True
    return GridMap.from_free(free)


def nearest_free(grid: GridMap, place: np.ndarray) -> np.ndarray:
    """Le point lui-même s'il est libre, sinon le centre de la case libre la plus proche."""
    if grid.is_free(place[None])[0]:
        return place
    rows, columns = np.nonzero(grid.free)
    centres = np.column_stack([columns, rows]) + 0.5
    return centres[np.argmin(((centres - place) ** 2).sum(axis=1))]
