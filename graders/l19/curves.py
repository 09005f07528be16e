"""Gaussian curves on an axis, for the figures of module L19."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

#: How many deviations a curve is drawn over, and how many times the narrowest may be narrower than the widest.
REACH, NARROW = 3.5, 40.0


def draw_beliefs(figure: Figure, data: dict[str, Any]) -> None:
    """What was given (`curves`: name, mean, variance, "belief" or "measure"), what is expected, what came back."""
    axes = figure.add_subplot()
    colours = {"belief": ink_of(axes), "measure": THIRD}
    drawn = [(name, mean, variance, colours[kind], "--") for name, mean, variance, kind in data["curves"]]
    drawn.append(("attendu", *data["expected"], EXPECTED, "-"))
    got = data["got"]
    if got is not None and got[1] > 0.0:
        drawn.append(("obtenu", *got, OBTAINED, "-"))
    widest = max(deviation(variance) for _, _, variance, _, _ in drawn)
    for name, mean, variance, colour, style in drawn:
        _draw_curve(axes, mean, max(deviation(variance), widest / NARROW), colour, style, name)
    if got is not None and got[1] <= 0.0:
        axes.axvline(got[0], color=OBTAINED, lw=2.0, label="obtenu, de variance nulle ou négative")
    axes.set(xlabel="position (m)", ylabel="densité de probabilité", title=data["title"])
    axes.set_ylim(bottom=0.0)
    figure.legend(loc="outside lower center", ncols=2 if got is not None and got[1] <= 0.0 else 4)


def deviation(variance: float) -> float:
    return float(np.sqrt(max(variance, 0.0)))


def _draw_curve(axes: Axes, mean: float, sigma: float, colour: str, style: str, name: str) -> None:
    """A curve of so many deviations about its mean, which is marked on the axis."""
    sigma = max(sigma, 1e-9)
    places = mean + sigma * np.linspace(-REACH, REACH, 161)
    heights = np.exp(-0.5 * ((places - mean) / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
    axes.plot(places, heights, style, color=colour, lw=2.2 if style == "-" else 1.8, label=name)
    axes.plot([mean, mean], [0.0, heights.max()], ":", color=colour, lw=1.0)
