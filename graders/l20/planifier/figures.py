"""Figures of l20/planifier: where the robot's centre may be, and two paths on the cells that are permitted."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator

from graders.l20.planifier.pictures import CELLS, PATH
from graders.l20.planifier.truth import UNKNOWN, WALL
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of


def draw_cells(figure: Figure, data: dict[str, Any]) -> None:
    """The map, the robot's radius around one wall, and the cells whose answer is wrong."""
    axes = figure.add_subplot()
    grid, expected = np.asarray(data["grid"]), np.asarray(data["expected"], dtype=bool)
    ink = ink_of(axes)
    for i, j in np.ndindex(grid.shape):
        if grid[i, j] == WALL:
            _fill(axes, i, j, ink, 0.85)
        elif grid[i, j] == UNKNOWN:
            axes.text(j, i, "?", ha="center", va="center", color=ink)
        elif not expected[i, j]:
            _fill(axes, i, j, EXPECTED, 0.3)
    for i, j in np.argwhere(grid == WALL)[:60]:
        axes.add_patch(Circle((j, i), data["radius"], fill=False, ec=EXPECTED, lw=0.8, alpha=0.7))
    axes.plot([], [], "s", color=EXPECTED, alpha=0.4, ms=9, label="interdites, à moins d'un rayon d'un mur")
    if data["got"] is not None:
        wrong = np.argwhere(np.asarray(data["got"], dtype=bool) != expected)
        axes.plot(wrong[:, 1], wrong[:, 0], "x", color=OBTAINED, ms=9, mew=2.2, label="réponse fausse")
    _finish(figure, axes, grid.shape, "Où le centre du robot peut-il être ?")


def draw_path(figure: Figure, data: dict[str, Any]) -> None:
    """The permitted cells, darker where they cost more, one of the best paths and the one that came back."""
    axes = figure.add_subplot()
    permitted, costs = np.asarray(data["permitted"], dtype=bool), np.asarray(data["costs"], dtype=float)
    ink, top = ink_of(axes), max(float(np.max(costs[permitted], initial=0.0)), 1e-9)
    for i, j in np.ndindex(permitted.shape):
        if not permitted[i, j]:
            _fill(axes, i, j, ink, 0.85)
        elif costs[i, j] > 0.0:
            _fill(axes, i, j, THIRD, 0.5 * float(costs[i, j]) / top)
    both = (("expected", EXPECTED, 5.0, "un des meilleurs"), ("got", OBTAINED, 2.0, "obtenu"))
    for name, colour, width, words in both:
        path = np.asarray(data[name], dtype=float).reshape(-1, 2)
        if len(path):
            axes.plot(path[:, 1], path[:, 0], "o-", color=colour, lw=width, ms=width + 2, alpha=0.8, label=words)
    for name, words in (("start", "départ"), ("goal", "but")):
        i, j = data[name]
        axes.annotate(words, (j, i), textcoords="offset points", xytext=(6, 8), color=ink)
    _finish(figure, axes, permitted.shape, "Le chemin, case par case" + (" (vert : cher)" if np.any(costs) else ""))


def _fill(axes: Axes, i: int, j: int, colour: str, opacity: float) -> None:
    axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, color=colour, alpha=opacity, lw=0))


def _finish(figure: Figure, axes: Axes, shape: tuple[int, ...], title: str) -> None:
    """Row 0 is at the top, as it is printed."""
    height, width = shape
    axes.set(xlim=(-1.0, width), ylim=(height, -1.0), aspect="equal", xlabel="colonne", ylabel="ligne", title=title)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc="outside lower center", ncols=2)


FIGURES = {
    CELLS: (
        draw_cells,
        "Carte vue de dessus, ligne 0 en haut : les murs en cases pleines, entourés de cercles bleus d’un rayon de "
        "robot ; en bleu pâle, les cases interdites attendues. Une croix orange marque chaque case où votre réponse "
        "est fausse.",
    ),
    PATH: (
        draw_path,
        "Carte vue de dessus, ligne 0 en haut : les cases interdites pleines, les cases chères en vert, d’autant "
        "plus vif qu’elles coûtent. La ligne bleue épaisse est un des meilleurs chemins du départ au but, la ligne "
        "orange le vôtre.",
    ),
}
