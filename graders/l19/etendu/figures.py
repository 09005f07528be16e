"""Figures of l19/etendu: a robot and a beacon seen from above, what a distance says, where it leads the belief."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.l19.ellipses import TURN, draw_before_and_after
from graders.l19.etendu.pictures import CORRECTED, MEASURED
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of


def draw_range(figure: Figure, data: dict[str, Any]) -> None:
    """The derivative is an arrow at the robot: where to go for the distance to grow fastest."""
    axes = figure.add_subplot()
    x, beacon = np.asarray(data["x"], dtype=float), np.asarray(data["beacon"], dtype=float)
    axes.plot(*np.array([x, beacon]).T, ":", color=ink_of(axes), lw=1.5)
    axes.plot(*x, "o", color=ink_of(axes), ms=8, label="robot")
    axes.plot(*beacon, "s", color=THIRD, ms=9, label="balise")
    axes.annotate(
        f"d = {data['expected'][0]:.4g}".replace(".", ","), (x + beacon) / 2, textcoords="offset points", xytext=(8, 8)
    )
    _draw_arrow(axes, x, data["expected"][1], EXPECTED, "jacobienne attendue", 5.0)
    if data["got"] is not None:
        _draw_arrow(axes, x, data["got"][1], OBTAINED, "jacobienne obtenue", 2.2)
    _finish(figure, axes, "La distance croît le plus vite en s'éloignant de la balise")


def draw_correction(figure: Figure, data: dict[str, Any]) -> None:
    """The circle of the places at the distance that was read, and the belief before and after."""
    axes = figure.add_subplot()
    beacon = np.asarray(data["beacon"], dtype=float)
    draw_before_and_after(axes, data)
    axes.plot(*beacon, "s", color=THIRD, ms=9, label="balise")
    circle = beacon + data["z"] * np.column_stack([np.cos(TURN), np.sin(TURN)])
    axes.plot(*circle.T, "--", color=THIRD, lw=1.8, label="à la distance z")
    _finish(figure, axes, "Corriger : vers le cercle, et plus étroit dans sa direction")


def _draw_arrow(axes: Axes, start: Any, arrow: Sequence[float], colour: str, name: str, width: float) -> None:
    tip = start + np.asarray(arrow, dtype=float)
    style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=tuple(tip), xytext=tuple(start), arrowprops=style)
    axes.plot(*tip, alpha=0)
    axes.plot([], [], color=colour, lw=width, label=name)


def _finish(figure: Figure, axes: Axes, title: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title)
    figure.legend(loc="outside lower center", ncols=3)


FIGURES = {
    MEASURED: (
        draw_range,
        "Vue de dessus en mètres : le robot (rond), la balise (carré vert) et, en pointillés, la distance qui les "
        "sépare. Du robot part la jacobienne attendue, flèche bleue épaisse qui s’éloigne de la balise ; la flèche "
        "orange est la vôtre.",
    ),
    CORRECTED: (
        draw_correction,
        "Vue de dessus en mètres : la balise (carré vert), le cercle vert des places à la distance mesurée, et "
        "l’ellipse de la croyance avant la correction, en tirets. L’ellipse bleue est la croyance attendue après la "
        "correction, l’ellipse orange la vôtre.",
    ),
}
