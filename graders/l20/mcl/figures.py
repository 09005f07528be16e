"""Figures of l20/mcl and l20/defi_kidnappe: clouds on the map, before and after; the way of a run and its end."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from graders.core.contract.values import Floats
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

ARROW = 0.55
SMALL_PART = 4.0


def draw_cloud(figure: Figure, data: dict[str, Any]) -> None:
    """The cloud that was given, the one that came back, and where the robot is."""
    axes = _plan(figure, data)
    if data.get("before") is not None:
        _particles(axes, np.array(data["before"], dtype=float), THIRD, "particules données")
    _particles(
        axes,
        np.array(data["after"], dtype=float),
        OBTAINED,
        "particules obtenues" if data.get("before") else "particules",
    )
    _end(figure, axes, data)
    _closer(axes, data)


def draw_run(figure: Figure, data: dict[str, Any]) -> None:
    """The way of the robot, that of the estimates, and the cloud at the end."""
    axes = _plan(figure, data)
    path, told = (np.array(data[key], dtype=float) for key in ("path", "estimates"))
    axes.plot(path[:, 0], path[:, 1], color=EXPECTED, lw=1.6, label="trajet du robot", zorder=3)
    axes.plot(told[:, 0], told[:, 1], color=OBTAINED, lw=1.2, ls=(0, (3, 2)), label="vos estimations", zorder=4)
    _particles(axes, np.array(data["after"], dtype=float), OBTAINED, "vos particules à la fin")
    _end(figure, axes, data)


def _plan(figure: Figure, data: dict[str, Any]) -> Axes:
    """The walls, row 0 at the top."""
    free = np.array(data["free"], dtype=float)
    height, width = free.shape
    figure.set_size_inches(6.4, min(5.2, 1.1 + 6.0 * height / width))
    axes = figure.subplots()
    walls = np.ma.masked_where(free > 0.5, np.ones_like(free))
    shade = LinearSegmentedColormap.from_list("walls", [ink_of(axes), ink_of(axes)])
    axes.imshow(walls, cmap=shade, alpha=0.35, extent=(0, width, height, 0), interpolation="nearest", zorder=1)
    axes.set_xlim(-0.2, width + 0.2)
    axes.set_ylim(height + 0.2, -0.2)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.tick_params(length=2, labelsize=7.5)
    axes.set_title(data["title"], fontsize=10)
    return axes


def _particles(axes: Axes, cloud: Floats, colour: str, label: str) -> None:
    """Dots with a stroke for the heading; what is off the drawing is left out."""
    x, y, heading = np.clip(cloud, -1e3, 1e3).T
    axes.plot(x, y, "o", color=colour, ms=2.2, alpha=0.7, label=label, zorder=5, clip_on=True)
    axes.quiver(
        x, y, ARROW * np.cos(heading), ARROW * np.sin(heading), color=colour, alpha=0.5, angles="xy",
        scale_units="xy", scale=1.0, width=0.0022, headwidth=0.0, headlength=0.0, headaxislength=0.0, zorder=4,
    )  # fmt: skip


def _end(figure: Figure, axes: Axes, data: dict[str, Any]) -> None:
    """Where the robot is, what else is told, and the legend."""
    if data.get("other") is not None:
        _pose(axes, np.array(data["other"], dtype=float), ink_of(axes), "là où le robot n'est pas")
    if data.get("estimate") is not None:
        _pose(axes, np.array(data["estimate"], dtype=float), OBTAINED, "votre estimation")
    if data.get("truth") is not None:
        _pose(axes, np.array(data["truth"], dtype=float), EXPECTED, "robot")
    figure.legend(handles=axes.get_legend_handles_labels()[0], loc="outside lower center", ncols=3)


def _closer(axes: Axes, data: dict[str, Any]) -> None:
    """The part of the plan where everything is, when it is a small one."""
    shown = [np.reshape(np.array(data[key], dtype=float), (-1, 3))[:, :2]
             for key in ("before", "after", "truth", "other", "estimate") if data.get(key) is not None]  # fmt: skip
    low, high = np.concatenate(shown).min(axis=0), np.concatenate(shown).max(axis=0)
    half = np.maximum((high - low).max() / 2.0 + 0.7, 2.0)
    if half < SMALL_PART:
        (x, y), wide = (low + high) / 2.0, 1.6 * half
        axes.set_xlim(x - wide, x + wide)
        axes.set_ylim(y + half, y - half)


def _pose(axes: Axes, pose: Floats, colour: str, label: str) -> None:
    x, y, heading = np.clip(pose, -1e3, 1e3)
    axes.plot([x], [y], "o", color=colour, ms=9, mfc="none", mew=1.8, label=label, zorder=7)
    axes.plot([x, x + np.cos(heading)], [y, y + np.sin(heading)], color=colour, lw=1.8, zorder=7)


FIGURES = {
    "cloud": (
        draw_cloud,
        "Carte vue de dessus, ligne 0 en haut et murs en gris ; un trait donne le cap de chaque particule. Les "
        "points orange sont le nuage jugé, les points verts celui d’avant, s’il y en a un ; un cercle bleu est le "
        "robot, un cercle orange votre estimation.",
    ),
    "run": (
        draw_run,
        "Carte vue de dessus, ligne 0 en haut et murs en gris : en bleu, le trajet du robot ; en tirets orange, vos "
        "estimations, qui devraient le suivre ; en points orange, vos particules à la fin.",
    ),
}
