"""The module's map on paper: walls, robots and rays, row 0 at the top as in the printed array."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Circle
from numpy.typing import ArrayLike, NDArray

from curriculum.l20.kit import l20 as kit
from graders.plotting import Palette
from reference.world.grid_map import GridMap

Floats = NDArray[np.float64]

RANGE = 12.0


@cache
def module_map() -> GridMap:
    """The map of the kit, one metre a cell, so that lengths in cells are lengths of the world."""
    return GridMap.from_free(kit.lire_plan(kit.PLAN))


def french(value: float, digits: int = 1) -> str:
    """A number with a decimal comma and a true minus sign."""
    return f"{value:.{digits}f}".replace(".", ",").replace("-", "\N{MINUS SIGN}")


def draw_walls(axes: Axes, palette: Palette, grid_map: GridMap, alpha: float = 0.8) -> None:
    """The walls (and nothing else), without ticks."""
    height, width = grid_map.shape
    walls = np.ma.masked_where(~grid_map.occupied, np.ones(grid_map.shape))
    axes.imshow(
        walls,
        cmap=ListedColormap([palette.ink]),
        alpha=alpha,
        extent=(0, width, height, 0),
        interpolation="nearest",
        zorder=2,
    )
    axes.set(xlim=(0, width), ylim=(height, 0), xticks=[], yticks=[], aspect="equal")
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def mark_axes(axes: Axes, palette: Palette) -> None:
    """Where x and y grow, beside the top left corner of a printed map: y goes down, unlike on a blackboard."""
    for name, end in (("x", (1.9, -0.55)), ("y", (-0.55, 1.9))):
        arrow = {"arrowstyle": "-|>", "color": palette.ink, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=end, xytext=(-0.55, -0.55), arrowprops=arrow, annotation_clip=False)
        label = np.add(end, (0.45, 0.0) if name == "x" else (0.0, 0.6))
        axes.text(*label, f"${name}$", color=palette.ink, ha="center", va="center", fontsize=10, clip_on=False)


def draw_robot(axes: Axes, pose: ArrayLike, colour: str, palette: Palette, size: float = 0.42) -> None:
    """A disc, and a line for its heading."""
    x, y, theta = np.asarray(pose, dtype=np.float64)
    axes.add_patch(Circle((x, y), size, facecolor=colour, edgecolor=palette.paper, linewidth=1.2, zorder=8))
    nose = 1.9 * size
    axes.plot(
        [x, x + nose * np.cos(theta)],
        [y, y + nose * np.sin(theta)],
        color=colour,
        lw=2.6,
        solid_capstyle="round",
        zorder=7,
    )


def ray_ends(pose: ArrayLike, ranges: Floats) -> Floats:
    """Where the rays (n,) of a whole turn end, (n, 2)."""
    x, y, theta = np.asarray(pose, dtype=np.float64)
    angles = theta + 2.0 * np.pi * np.arange(len(ranges)) / len(ranges)
    return np.column_stack([x + ranges * np.cos(angles), y + ranges * np.sin(angles)])


def draw_rays(
    axes: Axes, pose: ArrayLike, ranges: Floats, colour: str, alpha: float = 0.55, width: float = 0.9
) -> None:
    """Rays from the pose to where they end."""
    x, y = np.asarray(pose, dtype=np.float64)[:2]
    for end in ray_ends(pose, ranges):
        axes.plot([x, end[0]], [y, end[1]], color=colour, lw=width, alpha=alpha, zorder=4)


def draw_impacts(axes: Axes, points: Floats, colour: str, size: float = 14.0) -> None:
    """Where rays hit."""
    axes.scatter(points[:, 0], points[:, 1], s=size, color=colour, linewidths=0, zorder=6)
