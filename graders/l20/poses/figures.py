"""Figures of l20/poses: frames drawn as two arrows, the expected one and the one obtained."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.core.plotting import EXPECTED, OBTAINED, ink_of


def draw_frames(figure: Figure, data: dict[str, Any]) -> None:
    """The world, the given poses, the expected pose and, when it can be drawn, the one obtained."""
    axes = figure.add_subplot()
    ink = ink_of(axes)
    poses = [*data["given"].values(), data["expected"], *([data["got"]] if data["got"] else []), [0.0, 0.0, 0.0]]
    size = 0.16 * max(2.0, float(np.ptp(np.array(poses)[:, :2], axis=0).max()))
    _frame(axes, [0.0, 0.0, 0.0], size, ink, "monde", 0.45)
    for name, pose in data["given"].items():
        _frame(axes, pose, size, ink, name, 0.9)
    _frame(axes, data["expected"], size, EXPECTED, "attendu", 1.0)
    if data["got"]:
        _frame(axes, data["got"], size, OBTAINED, "obtenu", 1.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    axes.set_title("Le repère attendu et le vôtre")


def _frame(axes: Axes, pose: list[float], size: float, colour: str, name: str, alpha: float) -> None:
    x, y, theta = pose
    for angle, length, width in ((theta, size, 2.2), (theta + np.pi / 2, 0.6 * size, 1.2)):
        tip = (x + length * np.cos(angle), y + length * np.sin(angle))
        style = {"arrowstyle": "-|>", "color": colour, "lw": width, "alpha": alpha, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=tip, xytext=(x, y), arrowprops=style)
        axes.plot(*tip, alpha=0)
    axes.plot(x, y, "o", color=colour, ms=5, alpha=alpha)
    axes.annotate(name, (x, y), textcoords="offset points", xytext=(6, -12), color=colour)


FIGURES = {"frames": draw_frames}
