"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from curriculum.l20.figures._plan import draw_robot, draw_walls, module_map
from curriculum.l20.manipulations.particules import scene
from curriculum.l20.rejeux.mcl import routes
from graders.plotting import Palette


def draw(figure: Figure, palette: Palette) -> None:
    """A cloud around the robot, and a handful elsewhere."""
    axes, rng = figure.subplots(), np.random.default_rng(1)
    draw_walls(axes, palette, module_map())
    for x, y, count in ((3.5, 3.5, 100), (11.5, 8.0, 5)):
        axes.plot(*scene.around(x, y, count, rng).T, ".", ms=4, color=palette.estimate, zorder=5)
    draw_robot(axes, routes()[0][0], palette.truth, palette)


FIGURES = {
    "manipulation-particules": (
        draw,
        "Le plan du module, semé de particules à la main : un nuage de cent autour du robot, dans la pièce de gauche, "
        "et une poignée de cinq dans le couloir.",
        (5.6, 3.8),
    ),
}
