"""Figures of l20/lidar: the map, the ray to the wall that stops it, and where the answer puts that wall."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from graders.core.contract.values import Floats
from graders.plotting import EXPECTED, OBTAINED, ink_of

#: How much of the outside, which is wall, is shown; an answer that leads further is drawn so far.
MARGIN = 1.0


def draw_ray(figure: Figure, data: dict[str, Any]) -> None:
    """Row 0 at the top, as in the printed array: a positive angle turns clockwise."""
    free = np.array(data["free"], dtype=bool)
    axes = figure.add_subplot()
    _map(axes, free)
    start, heading = np.array(data["start"]), np.array([math.cos(data["angle"]), math.sin(data["angle"])])
    got = data["got"]
    if got is not None:
        _segment(axes, start, heading, _drawn(free, start, heading, got), OBTAINED, "obtenu", style="--", width=3.2)
    _segment(axes, start, heading, data["expected"], EXPECTED, "attendu", style="-", width=1.8)
    axes.plot(*start, "o", color=ink_of(axes), ms=6, zorder=6, label="départ")
    axes.set_title("Le rayon sur la carte")
    figure.legend(loc="outside lower center", ncols=3)


def _drawn(free: np.ndarray[Any, Any], start: Floats, heading: Floats, length: float) -> float:
    """As much of a length, which may be negative, as stays in the picture."""
    height, width = free.shape
    size = np.array([width, height])
    sense = math.copysign(1.0, length) * heading
    room = np.where(sense > 0, size + MARGIN - start, start + MARGIN)
    limits = [float(r / abs(s)) for r, s in zip(room, sense, strict=True) if abs(s) > 1e-9]
    return math.copysign(min(abs(length), *limits), length)


def _map(axes: Axes, free: np.ndarray[Any, Any]) -> None:
    height, width = free.shape
    framed = np.pad(free, 1, constant_values=False)
    walls = np.ma.masked_where(framed, np.ones(framed.shape))
    extent = (-1.0, width + 1.0, height + 1.0, -1.0)
    ink = ink_of(axes)
    axes.imshow(walls, cmap=ListedColormap([ink]), alpha=0.3, interpolation="nearest", extent=extent, zorder=1)
    axes.plot([0, width, width, 0, 0], [0, 0, height, height, 0], "-", color=ink, lw=1.0, zorder=2)
    axes.hlines(range(1, height), 0, width, color=ink, lw=0.4, alpha=0.35, zorder=2)
    axes.vlines(range(1, width), 0, height, color=ink, lw=0.4, alpha=0.35, zorder=2)
    axes.grid(False)
    axes.set_xticks(range(width + 1))
    axes.set_yticks(range(height + 1))
    axes.tick_params(length=2, labelsize=8)
    axes.set_xlim(-MARGIN, width + MARGIN)
    axes.set_ylim(height + MARGIN, -MARGIN)
    axes.set_aspect("equal")
    axes.set_xlabel("x (colonnes)")
    axes.set_ylabel("y (lignes)")


def _segment(
    axes: Axes, start: Floats, heading: Floats, length: float, colour: str, name: str, *, style: str, width: float
) -> None:
    end = start + length * heading
    axes.plot([start[0], end[0]], [start[1], end[1]], style, color=colour, lw=width, zorder=4)
    axes.plot(*end, "X", color=colour, mec=ink_of(axes), mew=0.8, ms=10 if style == "-" else 13,
              zorder=5, label=name)  # fmt: skip


FIGURES = {
    "ray": (
        draw_ray,
        "Carte vue de dessus, en cases, ligne 0 en haut et murs en gris : un rayon part du rond. Le trait bleu "
        "plein s’arrête où on l’attend, le trait orange en tirets où l’arrête votre programme ; une croix marque "
        "chaque bout.",
    ),
}
