"""Figures of l20/occupation: a scan over the grid, what each cell must become, and what became of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from graders.core.contract.values import Floats
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

#: Grids of more rows or columns have one tick in four.
READABLE = 12


def draw_scan(figure: Figure, data: dict[str, Any]) -> None:
    """Two panels: expected and obtained. Blue where log-odds fall, orange where they rise; hatched: not judged."""
    before, wish = np.array(data["before"], dtype=float), np.array(data["wish"], dtype=int)
    judged = np.array(data["judged"], dtype=bool)
    height, width = before.shape
    figure.set_size_inches(6.4, 1.0 + 3.0 * height / width)
    panels = figure.subplots(1, 2)
    exact = data["after"] is not None
    wanted = np.array(data["after"], dtype=float) if exact else before + wish
    for axes, grid, title in ((panels[0], wanted, "Attendu"), (panels[1], data["got"], "Obtenu")):
        if grid is None:
            _cells(axes, np.zeros_like(before), before.shape)
            axes.set_title(f"{title} : rien à dessiner", fontsize=10)
            continue
        values = np.array(grid, dtype=float)
        _cells(axes, values - before, before.shape)
        _hatch(axes, ~judged)
        if exact:
            _numbers(axes, values)
        _rays(axes, data)
        _robot(axes, data["pose"])
        if data["cell"]:
            y, x = data["cell"]
            axes.add_patch(Rectangle((x, y), 1, 1, fill=False, ec=ink_of(axes), lw=2.2, zorder=6))
        axes.set_title(title, fontsize=10)
    note = "bleu : la case baisse ; orange : elle monte ; hachures : libre, non jugé ; vert : les rayons"
    figure.supxlabel(note, fontsize=8)


def _cells(axes: Axes, change: Floats, shape: tuple[int, ...]) -> None:
    ramp = LinearSegmentedColormap.from_list("change", [EXPECTED, axes.get_facecolor(), OBTAINED])
    shade = np.clip(change, -1.0, 1.0) * 0.75
    height, width = shape
    axes.imshow(shade, cmap=ramp, vmin=-1, vmax=1, extent=(0, width, height, 0), interpolation="nearest", zorder=1)
    axes.set_xticks(range(0, width + 1, 4 if width > READABLE else 1))
    axes.set_yticks(range(0, height + 1, 4 if height > READABLE else 1))
    axes.tick_params(length=2, labelsize=7)
    axes.grid(True, lw=0.4)
    axes.set_axisbelow(False)
    axes.set(xlim=(0, width), ylim=(height, 0), xlabel="", ylabel="y")


def _hatch(axes: Axes, free: Floats) -> None:
    for y, x in np.argwhere(free):
        axes.add_patch(Rectangle((x, y), 1, 1, fill=False, ec=ink_of(axes), lw=0, hatch="////", alpha=0.25, zorder=2))


def _numbers(axes: Axes, values: Floats) -> None:
    for (y, x), value in np.ndenumerate(values):
        if value:
            text = f"{value:.2f}".replace(".", ",").replace("-", "\N{MINUS SIGN}")
            axes.text(x + 0.5, y + 0.86, text, ha="center", va="center", fontsize=6, zorder=7)


def _rays(axes: Axes, data: dict[str, Any]) -> None:
    """Each ray to where it stops; a dot where it touched something."""
    x, y, theta = data["pose"]
    scan = np.array(data["scan"], dtype=float)
    for k, z in enumerate(scan):
        angle = theta + 2.0 * np.pi * k / len(scan)
        end = x + z * np.cos(angle), y + z * np.sin(angle)
        axes.plot([x, end[0]], [y, end[1]], color=THIRD, lw=1.4 if len(scan) < 8 else 0.7, zorder=4)
        if z < data["portee_max"]:
            axes.plot(*end, "o", color=THIRD, ms=4 if len(scan) < 8 else 2, zorder=5, clip_on=False)


def _robot(axes: Axes, pose: list[float]) -> None:
    x, y, theta = pose
    axes.plot(x, y, "o", color=ink_of(axes), ms=6, zorder=6)
    tip = (x + 0.55 * np.cos(theta), y + 0.55 * np.sin(theta))
    axes.annotate(
        "", xy=tip, xytext=(x, y), arrowprops={"arrowstyle": "-|>", "color": ink_of(axes), "lw": 1.6}, zorder=7
    )


FIGURES = {
    "scan": (
        draw_scan,
        "Deux grilles vues de dessus, ligne 0 en haut : ce qui est attendu à gauche, la vôtre à droite. Une case "
        "bleue baisse, une case orange monte, une case hachurée n’est pas jugée ; en vert, les rayons du robot ; un "
        "cadre entoure la première case fausse.",
    ),
}
