"""Figures of l20/jacobienne_arete: an edge and its residual, and how j moves before the eyes of i."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.l20.jacobienne_arete.pictures import COLUMNS, EDGE
from graders.l20.slam_graphe.figures import draw_edge
from graders.plotting import EXPECTED, OBTAINED, ink_of

TITLES = ("quand i bouge : A", "quand j bouge : B")
LABELS = (("xᵢ", "yᵢ", "θᵢ"), ("xⱼ", "yⱼ", "θⱼ"))
#: Two names nearer than this, in metres, are written one above the other.
CROWDED = 0.4


def draw_columns(figure: Figure, data: dict[str, Any]) -> None:
    """Left: the three columns of A as arrows from where i sees j. Right: those of B."""
    panels = figure.subplots(1, 2)
    expected = np.array(data["expected"])
    got = None if data["got"] is None else np.array(data["got"])
    limit = 3.0 * (1.0 + float(np.abs(expected).max()))
    for k, axes in enumerate(panels):
        _draw_robot(axes, np.array(data["seen"]))
        _draw_arrows(axes, data["seen"], expected[:, 3 * k : 3 * k + 3], EXPECTED, 4.0, LABELS[k])
        if got is not None:
            _draw_arrows(axes, data["seen"], np.clip(got[:, 3 * k : 3 * k + 3], -limit, limit), OBTAINED, 1.8, None)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.2)
        axes.set(xlabel="devant i", ylabel="à gauche de i" if k == 0 else "", title=TITLES[k])
    panels[0].plot([], [], color=EXPECTED, lw=4.0, label="dérivées attendues")
    panels[0].plot([], [], color=OBTAINED, lw=1.8, label="obtenues")
    figure.suptitle("Où va la pose j, vue de i", fontsize=11)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _draw_robot(axes: Axes, seen: Any) -> None:
    ink = ink_of(axes)
    axes.plot([0.0, seen[0]], [0.0, seen[1]], color=ink, lw=0.9, ls=":")
    axes.plot(0.0, 0.0, ">", color=ink, ms=11, label="robot i")
    axes.plot(*seen, "o", color=ink, ms=6, label="pose j, vue de i")


def _draw_arrows(axes: Axes, start: Any, columns: Any, colour: str, width: float, labels: Any) -> None:
    tips: list[Any] = []
    for column, name in zip(columns.T, labels or ("", "", ""), strict=True):
        tip = np.asarray(start) + column
        if float(np.hypot(*column)) > 1e-9:
            style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", xy=tip, xytext=start, arrowprops=style)
        axes.plot(*tip, alpha=0)
        if name and float(np.hypot(*column)) > 1e-9:
            up = 6 + 13 * sum(float(np.hypot(*(tip - other))) < CROWDED for other in tips)
            axes.annotate(name, tip, textcoords="offset points", xytext=(5, up), color=colour)
            tips.append(tip)


FIGURES = {
    EDGE: (
        draw_edge,
        "À gauche, les repères des poses i et j, et en vert j selon la mesure ; une flèche bleue en tirets va de "
        "l’une à l’autre. À droite, des barres comparent l’erreur attendue (bleu) à la vôtre (orange), selon x, y "
        "et θ.",
    ),
    COLUMNS: (
        draw_columns,
        "La pose j vue de i, en deux dessins : quand i bouge, les colonnes de A ; quand j bouge, celles de B. De j "
        "partent en bleu les dérivées attendues selon x, y et θ, et en orange celles de votre programme, qui "
        "devraient s’y superposer.",
    ),
}
