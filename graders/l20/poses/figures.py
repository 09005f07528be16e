"""Figures of l20/poses: frames drawn as two arrows, the expected one and the one obtained."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.plotting import EXPECTED, OBTAINED, ink_of
from graders.robotics.frames import draw_frame


def draw_frames(figure: Figure, data: dict[str, Any]) -> None:
    """The known frames, the expected one and, when it can be drawn, the one obtained."""
    axes = figure.add_subplot()
    ink = ink_of(axes)
    drawn = [(name, pose, ink) for name, pose in data["frames"].items()]
    drawn.append(("attendu", data["expected"], EXPECTED))
    if data["got"]:
        drawn.append(("obtenu", data["got"], OBTAINED))
    reach = np.ptp(np.array([pose[:2] for _, pose, _ in drawn]), axis=0).max()
    for name, pose, colour in drawn:
        draw_frame(axes, pose, 0.16 * max(2.0, float(reach)), colour)
        _label(axes, name, pose, colour, rank=_rank(pose, name, drawn))
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.22)
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    axes.set_title(data["title"])


def _rank(pose: list[float], name: str, drawn: list[tuple[str, list[float], str]]) -> int:
    """How many frames drawn before stand at the same place: their names are written below one another."""
    names = [other for other, place, _ in drawn if np.allclose(place[:2], pose[:2])]
    return names.index(name)


def _label(axes: Axes, name: str, pose: list[float], colour: str, *, rank: int) -> None:
    offset = (8, -12 - 12 * rank)
    axes.annotate(name, (pose[0], pose[1]), textcoords="offset points", xytext=offset, color=colour)


FIGURES = {
    "frames": (
        draw_frames,
        "Plan x, y, à la même échelle : chaque pose est un repère, avec son nom. Les poses données ont la couleur "
        "du texte, le résultat attendu en bleu, celui de votre programme en orange : ces deux repères devraient se "
        "superposer.",
    ),
}
