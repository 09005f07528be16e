"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from curriculum.l20.figures._plan import draw_robot, draw_walls, module_map
from curriculum.l20.manipulations.passant import scene
from graders.plotting import Palette
from reference.world.simulation import SimulatedLidar


def draw(figure: Figure, palette: Palette) -> None:
    """The robot, its beams, and somebody who stops some of them."""
    axes = figure.subplots()
    draw_walls(axes, palette, module_map())
    axes.add_patch(Circle(scene.WALKER, scene.RADIUS, color=palette.alert, alpha=0.8, zorder=6))
    angles = SimulatedLidar.full_turn(scene.BEAMS, scene.REACH).angles
    x, y, theta = scene.TRUE
    for angle, far in zip(angles, module_map().cast_scans([scene.TRUE], angles, scene.REACH)[0], strict=True):
        way = np.array([np.cos(theta + angle), np.sin(theta + angle)])
        away = np.array(scene.WALKER) - [x, y]
        along, across = float(away @ way), float(abs(away[1] * way[0] - away[0] * way[1]))
        met = along - np.sqrt(scene.RADIUS**2 - across**2) if along > 0.0 and across < scene.RADIUS else np.inf
        end = np.array([x, y]) + min(far, met) * way
        axes.plot([x, end[0]], [y, end[1]], color=palette.alert if met < far else palette.measure, lw=1.0, zorder=4)
    draw_robot(axes, scene.TRUE, palette.truth, palette)
    draw_robot(axes, scene.FALSE, palette.estimate, palette)


FIGURES = {
    "manipulation-passant": (
        draw,
        "Le plan du module. Le lidar d’un robot, dans le couloir, a 36 rayons ; ceux qu’arrête un passant, devant lui, "
        "sont rouges. Un second robot, dans une autre pièce, est la fausse pose que l’on compare à la vraie.",
        (5.6, 3.8),
    ),
}
