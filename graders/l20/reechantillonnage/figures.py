"""Figures of l20/reechantillonnage: the comb laid over the weights, and the copies allowed and obtained."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from graders.plotting import EXPECTED, OBTAINED, ink_of

OFFSET = 0.5
MANY = 12


def draw_comb(figure: Figure, data: dict[str, Any]) -> None:
    """Above, [0, 1] cut by the weights under one of the possible combs; below, copies against floor and ceil of N w."""
    top, bottom = figure.subplots(2, 1, height_ratios=(1.0, 2.2))
    _segments(top, data)
    _copies(bottom, data)
    figure.legend(loc="outside lower center", ncols=3)


def _segments(axes: Axes, data: dict[str, Any]) -> None:
    ends, first, total = np.array(data["ends"]), data["first"], data["total"]
    ink = ink_of(axes)
    for k, (start, end) in enumerate(pairwise(ends)):
        axes.barh(0, end - start, left=start, height=1.0, color=ink, alpha=0.10 + 0.14 * (k % 2), lw=0)
        if end - start > 0.02 * (ends[-1] - ends[0]):
            axes.text((start + end) / 2, 0, str(first + k), ha="center", va="center", color=ink)
    teeth = (np.arange(total) + OFFSET) / total
    teeth = teeth[(teeth >= ends[0]) & (teeth <= ends[-1])]
    axes.vlines(teeth, -0.7, 0.95, color=EXPECTED, lw=1.6)
    if len(teeth):
        axes.hlines(0.95, teeth[0], teeth[-1], color=EXPECTED, lw=3)
    axes.set(xlim=(ends[0], ends[-1]), ylim=(-0.8, 1.1), yticks=[], xlabel="poids cumulés")
    axes.grid(visible=False)
    axes.spines["left"].set_visible(False)
    axes.set_title("Le segment découpé par les poids, et un des peignes possibles")


def _copies(axes: Axes, data: dict[str, Any]) -> None:
    shares, got = np.array(data["shares"]), np.array(data["got"])
    low, high = np.array(data["low"]), np.array(data["high"])
    where = data["first"] + np.arange(len(shares))
    style: dict[str, Any] = {"width": 0.62, "color": EXPECTED, "alpha": 0.30}
    axes.bar(where, high - low + 0.16, bottom=low - 0.08, label="de ⌊N·w⌋ à ⌈N·w⌉", **style)
    axes.hlines(shares, where - 0.31, where + 0.31, color=EXPECTED, lw=2.4, label="N·w")
    axes.plot(where, got, "o", color=OBTAINED, ms=7, label=data["legend"])
    axes.set(xlabel="particule", ylabel="copies", ylim=(-0.3, max(float(high.max()), float(got.max())) * 1.05 + 0.4))
    axes.set_xticks(where if len(where) <= MANY else where[::2])
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


FIGURES = {
    "comb": (
        draw_comb,
        "En haut, le segment des poids cumulés, découpé par particule, sous les dents bleues d’un peigne régulier. "
        "En bas, par particule, le nombre de copies : la bande bleue est ce qui est permis autour de N·w, le rond "
        "orange ce que donne votre programme.",
    ),
}
