"""Frames as pictures draw them: never imported on the path of a verdict, like all that loads matplotlib."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes


def draw_frame(axes: Axes, pose: Sequence[float], size: float, colour: str) -> None:
    """Two arrows from a point, x longer and thicker than y; their tips count when the axes fit what they show."""
    x, y, theta = pose
    for angle, length, width in ((theta, size, 2.2), (theta + np.pi / 2, 0.6 * size, 1.2)):
        tip = (x + length * np.cos(angle), y + length * np.sin(angle))
        style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=tip, xytext=(x, y), arrowprops=style)
        axes.plot(*tip, alpha=0)
    axes.plot(x, y, "o", color=colour, ms=5)
