"""Figures of l20/odometrie: a robot on two wheels before and after one step, and the journey that a step ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.plotting import EXPECTED, OBTAINED, ink_of
from graders.robotics.frames import draw_frame

Pose = Sequence[float]


def draw_step(figure: Figure, data: dict[str, Any]) -> None:
    """The axle at the start, where the step leads and, when it can be drawn, where the student's function puts it."""
    axes = figure.add_subplot()
    drawn = [("départ", data["start"], ink_of(axes), 1.0), ("attendu", data["expected"], EXPECTED, 1.8)]
    if data["got"]:
        drawn.append(("obtenu", data["got"], OBTAINED, 1.0))
    size = _size([pose for _, pose, *_ in drawn], data["track"])
    for name, pose, colour, thick in drawn:
        _draw_robot(axes, pose, data["track"], size, colour, thick)
        axes.plot([], [], color=colour, lw=3.0, label=name)
    for _, pose, colour, thick in drawn[1:]:
        axes.plot(*np.array([data["start"][:2], pose[:2]]).T, color=colour, lw=1.5 * thick, ls=":")
    figure.legend(loc="outside lower center", ncols=len(drawn))
    _finish(axes, "Un pas : le milieu de l'essieu suit les pointillés")


def draw_journey(figure: Figure, data: dict[str, Any]) -> None:
    """The way so far, dot by dot, and both ends of the last step."""
    axes = figure.add_subplot()
    way = np.array(data["expected"])
    axes.plot(way[:, 0], way[:, 1], "o-", color=EXPECTED, ms=4, lw=1.2, label="attendu")
    size = 0.1 * max(0.5, float(np.ptp(way[:, :2], axis=0).max()))
    draw_frame(axes, data["expected"][0], size, ink_of(axes))
    draw_frame(axes, data["expected"][-1], size, EXPECTED)
    axes.plot([], [], color=ink_of(axes), lw=3.0, label="départ")
    if data["got"]:
        axes.plot(*np.array([way[-2, :2], data["got"][:2]]).T, color=OBTAINED, lw=2.0, ls=":", label="obtenu")
        draw_frame(axes, data["got"], size, OBTAINED)
    figure.legend(loc="outside lower center", ncols=3)
    _finish(axes, f"Le trajet, jusqu'au pas {len(way) - 1}")


def _size(poses: Sequence[Pose], track: float) -> float:
    """How long an arrow is: a share of what is shown."""
    reach = float(np.ptp(np.array([pose[:2] for pose in poses]), axis=0).max())
    return 0.25 * max(reach, track)


def _draw_robot(axes: Axes, pose: Pose, track: float, size: float, colour: str, thick: float) -> None:
    """Its heading, its axle and its two wheels."""
    x, y, theta = pose
    ahead = np.array([np.cos(theta), np.sin(theta)])
    left = np.array([-ahead[1], ahead[0]]) * track / 2.0
    middle = np.array([x, y])
    axes.plot(*np.array([middle - left, middle + left]).T, color=colour, lw=1.5 * thick)
    for wheel in (middle - left, middle + left):
        ends = np.array([wheel - 0.25 * size * ahead, wheel + 0.25 * size * ahead])
        axes.plot(*ends.T, color=colour, lw=4.0 * thick, solid_capstyle="round")
    tip = middle + size * ahead
    style = {"arrowstyle": "-|>", "color": colour, "lw": 2.0 * thick, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=tuple(tip), xytext=(x, y), arrowprops=style)
    axes.plot(*tip, alpha=0)


def _finish(axes: Axes, title: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.2)
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title)


FIGURES = {
    "step": (
        draw_step,
        "Vue de dessus en mètres : l’essieu du robot, ses deux roues et la flèche de son cap. Au départ, il a la "
        "couleur du texte ; après le pas, il est en bleu là où on l’attend, en orange là où votre programme le "
        "place.",
    ),
    "journey": (
        draw_journey,
        "Vue de dessus en mètres : le trajet attendu en bleu, un point par pas, avec le repère du départ et celui "
        "d’arrivée. Le repère orange est la pose que donne votre programme au dernier pas : il devrait couvrir le "
        "bleu.",
    ),
}
