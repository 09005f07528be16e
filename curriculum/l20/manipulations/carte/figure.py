"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

from matplotlib.figure import Figure

from curriculum.l20.figures._plan import draw_robot, draw_walls
from curriculum.l20.manipulations.carte import scene
from graders.plotting import Palette
from reference.world.grid_map import GridMap


def draw(figure: Figure, palette: Palette) -> None:
    """The map that one starts from."""
    axes = figure.subplots()
    draw_walls(axes, palette, GridMap.from_free(~scene.DRAWN))
    draw_robot(axes, (3.5, 3.5, 0.0), palette.truth, palette)


FIGURES = {
    "manipulation-carte": (
        draw,
        "Une petite carte de douze lignes et dix-huit colonnes : quatre pièces inégales et quelques piliers. Un robot "
        "attend dans celle d’en haut à gauche.",
        (5.6, 3.8),
    ),
}
