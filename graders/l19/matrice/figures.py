"""Figures of l19/matrice: a belief of two numbers before and after, as ellipses, and what was seen between the two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.l19.ellipses import draw_before_and_after, draw_belief
from graders.l19.matrice.pictures import MEASURED, MOVED
from graders.plotting import THIRD


def draw_move(figure: Figure, data: dict[str, Any]) -> None:
    """The ellipse is carried along by F, and grows by Q."""
    axes = figure.add_subplot()
    draw_before_and_after(axes, data)
    _finish(figure, axes, "Prédire : F transporte l'ellipse, Q l'agrandit")


def draw_reading(figure: Figure, data: dict[str, Any]) -> None:
    """The ellipse shrinks towards what was seen: a band where one number is, an ellipse where two are."""
    axes = figure.add_subplot()
    draw_before_and_after(axes, data)
    limits = axes.get_xlim(), axes.get_ylim()
    if data["seen"] is not None:
        draw_belief(axes, data["seen"], THIRD, "la mesure", style="--")
    if data["line"] is not None:
        _draw_band(axes, data["line"])
        axes.set(xlim=limits[0], ylim=limits[1])
    _finish(figure, axes, "Corriger : l'ellipse se resserre autour de la mesure")


def _draw_band(axes: Axes, line: Sequence[float]) -> None:
    """The states of which a x + b y is within a deviation of z."""
    a, b, z, sigma = line
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    xs, ys = np.meshgrid(np.linspace(low, high, 200), np.linspace(bottom, top, 200))
    gap = a * xs + b * ys - z
    axes.contourf(xs, ys, np.abs(gap), levels=[0.0, sigma], colors=[THIRD], alpha=0.18)
    axes.contour(xs, ys, gap, levels=[0.0], colors=[THIRD], linestyles="--", linewidths=1.8)
    axes.plot([], [], "--", color=THIRD, lw=1.8, label="ce que dit la mesure")


def _finish(figure: Figure, axes: Axes, title: str) -> None:
    axes.set(xlabel="première composante", ylabel="seconde composante", title=title)
    figure.legend(loc="outside lower center", ncols=3)


FIGURES = {
    MOVED: (
        draw_move,
        "Plan des deux composantes de l’état. L’ellipse en tirets est la croyance avant la prédiction ; l’ellipse "
        "bleue, transportée par F et agrandie par Q, est celle que l’on attend ; l’ellipse orange est celle de "
        "votre programme.",
    ),
    MEASURED: (
        draw_reading,
        "Plan des deux composantes de l’état, avec la mesure en vert : une bande si elle porte sur un nombre, une "
        "ellipse sur deux. L’ellipse bleue est la croyance attendue après la correction, resserrée autour de la "
        "mesure ; l’ellipse orange est la vôtre.",
    ),
}
