"""Figures of l20/boucles: scans in polar form, the student's signatures laid over one another, and the walk."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from graders.core.compare import words as render
from graders.plotting import EXPECTED, OBTAINED, ink_of
from reference.loop_closure import fourier_signature


def draw_rotation(figure: Figure, data: dict[str, Any]) -> None:
    """A scan and the same one shifted: their signatures should lie one on the other."""
    polar = figure.add_subplot(1, 2, 1, projection="polar")
    flat = figure.add_subplot(1, 2, 2)
    colours = (EXPECTED, OBTAINED)
    _scans(polar, data["scans"], colours)
    _signatures(flat, data["scans"], colours)
    _legend(figure, data["scans"], colours)


def draw_places(figure: Figure, data: dict[str, Any]) -> None:
    """The scan asked about, one of the same place and one of another, above the walk with what was found in it."""
    grid = figure.add_gridspec(2, 2, height_ratios=(4, 1))
    polar = figure.add_subplot(grid[0, 0], projection="polar")
    flat = figure.add_subplot(grid[0, 1])
    walk = figure.add_subplot(grid[1, :])
    colours = (ink_of(flat), EXPECTED, OBTAINED)
    _scans(polar, data["scans"], colours)
    _signatures(flat, data["scans"], colours)
    _timeline(walk, data["timeline"], data["threshold"])
    _legend(figure, data["scans"], colours)


def _scans(axes: Axes, scans: list[dict[str, Any]], colours: tuple[str, ...]) -> None:
    """Each scan as its robot sees it, beam 0 to the right."""
    for item, colour in zip(scans, colours, strict=False):
        distances = np.array(item["scan"])
        angles = 2.0 * np.pi * np.arange(len(distances)) / len(distances)
        outline = np.append(np.arange(len(distances)), 0)
        axes.plot(angles[outline], distances[outline], color=colour, lw=1.6, marker="o", ms=2.5)
    axes.set_title("Ce que voit le robot")
    axes.set_xticks(np.radians([0, 90, 180, 270]), ["devant", "gauche", "derrière", "droite"])
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.tick_params(labelsize=8)


def _signatures(axes: Axes, scans: list[dict[str, Any]], colours: tuple[str, ...]) -> None:
    """The student's signatures, or the spectrum of the course where they cannot be drawn."""
    drawable = all(item["signature"] for item in scans)
    for rank, (item, colour) in enumerate(zip(scans, colours, strict=False)):
        values = np.array(item["signature"]) if drawable else fourier_signature(item["scan"])
        wide: dict[str, Any] = {"lw": 3.2, "alpha": 0.55} if rank == 0 else {"lw": 1.4}
        if len(values) > 1:
            axes.plot(values, color=colour, marker="o", ms=3, **wide)
        else:
            axes.bar([rank], values, color=colour)
            axes.annotate(render.number(float(values[0]), 7), (rank, float(values[0])), (0, 3),
                          textcoords="offset points", ha="center", fontsize=8)  # fmt: skip
    axes.set_title("Vos signatures" if drawable else "Les signatures attendues (spectre)")
    if drawable and len(scans[0]["signature"]) == 1:
        axes.set_xticks([])
        axes.margins(y=0.15)
    else:
        axes.set_xlabel("composante")


def _timeline(axes: Axes, timeline: dict[str, Any], threshold: float) -> None:
    """The walk: rings for the scans to find, dots for those found, a square for the scan asked about."""
    ink = ink_of(axes)
    axes.plot(range(timeline["count"]), np.zeros(timeline["count"]), "|", color=ink, alpha=0.5)
    axes.plot(timeline["expected"], np.zeros(len(timeline["expected"])), "o", mfc="none", color=EXPECTED, ms=13, mew=2)
    axes.plot(timeline["found"], np.zeros(len(timeline["found"])), "o", color=OBTAINED, ms=6)
    axes.plot([timeline["query"]], [0], "s", color=ink, ms=7)
    axes.axvspan(timeline["query"] - 9.5, timeline["count"] - 0.5, color=ink, alpha=0.08, lw=0)
    axes.set_yticks([])
    axes.set_ylim(-1, 1)
    axes.set_xlim(-0.8, timeline["count"] - 0.2)
    axes.grid(visible=False)
    axes.set_xlabel("numéro du scan (en gris : trop récents)")
    axes.set_title(f"Cercles : à trouver ; points : trouvés avec le seuil {render.number(threshold, 3)}", fontsize=9.5)


def _legend(figure: Figure, scans: list[dict[str, Any]], colours: tuple[str, ...]) -> None:
    lines = [Line2D([], [], color=colour, lw=2) for _, colour in zip(scans, colours, strict=False)]
    figure.legend(lines, [item["name"] for item in scans], loc="outside lower center", ncols=3)


FIGURES = {
    "rotation": (
        draw_rotation,
        "À gauche, un scan et le même tourné, vus du robot, en bleu et en orange. À droite, la signature de chacun, "
        "composante par composante : les deux courbes devraient se superposer, puisque le lieu est le même.",
    ),
    "places": (
        draw_places,
        "En haut, des scans vus du robot et leurs signatures : le scan étudié, un scan du même lieu (bleu) et, s’il "
        "y en a un, celui d’un autre lieu trouvé à tort (orange). En bas, le trajet scan par scan : des cercles "
        "bleus autour de ceux qu’il faut trouver, des points orange sur ceux que vos signatures trouvent.",
    ),
}
