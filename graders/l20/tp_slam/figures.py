"""Figures of l20/tp_slam: two clouds as they were matched, graphs before and after, and the maps drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from graders.l20.slam_graphe.figures import draw_graph
from graders.l20.tp_slam.pictures import GRAPH, MAP, MATCH, SMALL_MAP
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of
from reference.se2 import transform


def draw_match(figure: Figure, data: dict[str, Any]) -> None:
    """The points of a, and those of b as they should lie on them and as they were laid."""
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    _clouds(left, data, data["wanted"], EXPECTED, "attendu")
    _clouds(right, data, data["got"], OBTAINED, "obtenu")
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _clouds(axes: Axes, data: dict[str, Any], pose: list[float], colour: str, title: str) -> None:
    a, b = np.array(data["a"]), transform(pose, np.array(data["b"]))
    axes.plot(*a.T, ".", ms=3, color=ink_of(axes), label="points_a")
    axes.plot(*b.T, ".", ms=3, color=colour, label="points_b, placés")
    axes.set_xlim(a[:, 0].min() - 2.0, a[:, 0].max() + 2.0)
    axes.set_ylim(a[:, 1].min() - 2.0, a[:, 1].max() + 2.0)
    axes.set_aspect("equal", adjustable="box")
    axes.set_title(title)


def draw_map(figure: Figure, data: dict[str, Any]) -> None:
    """The map obtained, with the path that it was drawn from."""
    axes = figure.add_subplot()
    got, (x, y), side = np.array(data["got"], dtype=float), data["corner"], data["side"]
    height, width = got.shape
    shown = axes.imshow(
        got, origin="lower", cmap="gray_r", vmin=-5, vmax=5,
        extent=(x, x + width * side, y, y + height * side), interpolation="nearest",
    )  # fmt: skip
    axes.plot(*np.array(data["poses"]).T, "-", color=OBTAINED, lw=1.5, label="trajectoire")
    axes.grid(visible=False)
    axes.legend(loc="upper right")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    figure.colorbar(shown, ax=axes, label="log-odds", shrink=0.8)


def draw_small_map(figure: Figure, data: dict[str, Any]) -> None:
    """The map as it should be and as it was drawn, with the rays; the first wrong cell is framed in both."""
    height, width = np.array(data["wanted"]).shape
    figure.set_size_inches(6.4, 1.0 + 10.0 * height / width)
    top, bottom = figure.subplots(2, 1, sharex=True, sharey=True)
    (x, y), side = data["corner"], data["side"]
    row, column = data["cell"]
    for axes, name, title, colour in ((top, "wanted", "attendu", EXPECTED), (bottom, "got", "obtenu", OBTAINED)):
        axes.imshow(
            np.array(data[name]), origin="lower", cmap="gray_r", vmin=-2, vmax=2,
            extent=(x, x + width * side, y, y + height * side), interpolation="nearest",
        )  # fmt: skip
        for start, *ends in data["rays"]:
            for end in ends:
                axes.plot(*np.array([start, end]).T, color=THIRD, lw=1.2, clip_on=True)
            axes.plot(*start, "o", color=THIRD, ms=6)
        axes.add_patch(
            Rectangle((x + column * side, y + row * side), side, side, fill=False, ec=colour, lw=2.5, zorder=6)
        )
        axes.grid(visible=False)
        axes.set_title(title)
        axes.set_ylabel("y (m)")
    bottom.set_xlabel("x (m)")
    figure.supxlabel("noir : occupée ; blanc : libre ; gris : on n'en sait rien ; vert : les rayons", fontsize=8)


FIGURES = {
    MATCH: (
        draw_match,
        "Deux dessins vus de dessus : le nuage points_a, de la couleur du texte, et points_b posé dessus, en bleu "
        "selon la pose attendue à gauche, en orange selon la vôtre à droite. Les deux nuages devraient dessiner les "
        "mêmes murs.",
    ),
    MAP: (
        draw_map,
        "Votre carte vue de dessus en mètres, de log-odds en niveaux de gris : noir où la case est occupée, blanc "
        "où elle est libre. La ligne orange est la trajectoire d’où elle est tracée ; les murs devraient être nets "
        "et fins.",
    ),
    SMALL_MAP: (
        draw_small_map,
        "Deux petites cartes vues de dessus en mètres : celle que l’on attend en haut, la vôtre en bas. Noir : "
        "occupée ; blanc : libre ; gris : on n’en sait rien ; en vert, les rayons. La première case fausse est "
        "encadrée de bleu en haut, d’orange en bas.",
    ),
    GRAPH: (
        draw_graph,
        "À gauche, le graphe de la trajectoire vu de dessus : au départ (gris), à l’optimum attendu (bleu) et selon "
        "votre programme (orange, tirets). À droite, une barre par arête : l’erreur pondérée qui reste, attendue en "
        "bleu, obtenue en orange.",
    ),
}
