"""Figures of l20/slam_graphe: a graph before and after with what remains of each edge's error, and one edge's error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of
from graders.robotics.frames import draw_frame

BAR = 0.38
MAX_TICKS = 12


def draw_graph(figure: Figure, data: dict[str, Any]) -> None:
    """Left: the poses given, the optimum and those obtained. Right: the weighted error of each edge, in both."""
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    _draw_poses(left, data)
    _draw_errors(right, data)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _draw_poses(axes: Axes, data: dict[str, Any]) -> None:
    ends, ink = data["ends"], ink_of(axes)
    start, expected = np.array(data["start"]), np.array(data["expected"])
    size = 0.07 * max(1.0, float(np.ptp(np.vstack([start, expected])[:, :2], axis=0).max()))
    _trajectory(axes, start, ends, ink, "départ", size, alpha=0.45)
    _trajectory(axes, expected, ends, EXPECTED, "attendu", size)
    obtained = near(data["got"], start, expected)
    if obtained is not None:
        _trajectory(axes, obtained, ends, OBTAINED, "obtenu", size, dashed=True)
    axes.plot(*expected[0, :2], "s", color=THIRD, ms=8, label="pose fixée", zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    if data["got"] and obtained is None:
        axes.text(0.5, 0.02, "vos poses sont hors du cadre", color=OBTAINED, ha="center", transform=axes.transAxes)
    axes.set_title("Le graphe avant et après", fontsize=10)


def near(got: Sequence[Sequence[float]] | None, *others: np.ndarray[Any, np.dtype[np.float64]]) -> Any:
    """The poses obtained when they can be drawn beside the others, else None: a divergence would flatten these."""
    if got is None:
        return None
    reach = 6.0 * (1.0 + max(float(np.abs(poses[:, :2] - poses[0, :2]).max()) for poses in others))
    obtained = np.array(got)
    return obtained if np.abs(obtained[:, :2] - others[0][0, :2]).max() <= reach else None


def _trajectory(
    axes: Axes, poses: Any, ends: Sequence[Sequence[int]], colour: str, name: str, size: float, *,
    alpha: float = 0.95, dashed: bool = False,
) -> None:  # fmt: skip
    for i, j in ends:
        style = (0, (4, 2)) if dashed else "-"
        axes.plot(poses[[i, j], 0], poses[[i, j], 1], color=colour, lw=1.2, ls=style, alpha=0.7 * alpha)
    tips = poses[:, :2] + size * np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    for (x, y), tip in zip(poses[:, :2], tips, strict=True):
        axes.plot([x, tip[0]], [y, tip[1]], color=colour, lw=2.2, alpha=alpha, solid_capstyle="round")
    axes.plot(poses[:, 0], poses[:, 1], "o", color=colour, ms=4.5, alpha=alpha, label=name)


def _draw_errors(axes: Axes, data: dict[str, Any]) -> None:
    where = np.arange(len(data["ends"]))
    axes.barh(where - BAR / 2, data["errors_expected"], BAR, color=EXPECTED)
    if data["errors_got"]:
        axes.barh(where + BAR / 2, data["errors_got"], BAR, color=OBTAINED)
        if max(data["errors_got"]) > 50.0 * (1.0 + max(data["errors_expected"])):
            axes.set_xscale("symlog")
    ticks = where[:: 1 + len(where) // (MAX_TICKS + 1)]
    axes.set_yticks(ticks, [f"{i} → {j}" for i, j in (data["ends"][k] for k in ticks)])
    axes.set_ylim(max(len(where), 3) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("√(eᵀΩe)")
    axes.set_title("L'erreur qui reste par arête", fontsize=10)


def draw_edge(figure: Figure, data: dict[str, Any]) -> None:
    """Left: the poses i and j, and where the measurement puts j. Right: the components of the error."""
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    ink = ink_of(left)
    frames = {"i": (data["xi"], ink), "j": (data["xj"], ink), "j selon z": (data["measured"], THIRD)}
    points = np.array([pose for pose, _ in frames.values()])
    size = 0.2 * max(1.5, float(np.ptp(points[:, :2], axis=0).max()))
    for name, (pose, colour) in frames.items():
        _named_frame(left, pose, size, colour, name)
    gap = {"arrowstyle": "->", "color": EXPECTED, "lw": 1.6, "ls": (0, (3, 2))}
    left.annotate("", xy=data["xj"][:2], xytext=data["measured"][:2], arrowprops=gap)
    left.set_aspect("equal", adjustable="datalim")
    left.margins(0.25)
    left.set_title("La mesure et les deux poses", fontsize=10)
    _draw_components(right, data)


def _named_frame(axes: Axes, pose: Sequence[float], size: float, colour: str, name: str) -> None:
    draw_frame(axes, pose, size, colour)
    below = 12 if name == "j selon z" else -14
    axes.annotate(name, (pose[0], pose[1]), textcoords="offset points", xytext=(6, below), color=colour)


def _draw_components(axes: Axes, data: dict[str, Any]) -> None:
    where = np.arange(3)
    axes.bar(where - BAR / 2, data["expected"], BAR, color=EXPECTED, label="attendue")
    if data["got"]:
        axes.bar(where + BAR / 2, data["got"], BAR, color=OBTAINED, label="obtenue")
    axes.axhline(0.0, color=ink_of(axes), lw=0.8)
    axes.set_xticks(where, ["x", "y", "θ"])
    axes.grid(axis="x", visible=False)
    axes.set_title("Les composantes de l'erreur", fontsize=10)
    axes.margins(y=0.15)
    axes.legend(loc="best")


FIGURES = {
    "graph": (
        draw_graph,
        "À gauche, le graphe vu de dessus : les poses au départ (gris), à l’optimum attendu (bleu) et selon votre "
        "programme (orange, tirets). À droite, une barre par arête : l’erreur pondérée qui reste, attendue en bleu, "
        "obtenue en orange.",
    ),
    "edge": (
        draw_edge,
        "À gauche, les repères des poses i et j, et en vert j selon la mesure ; une flèche bleue en tirets va de j "
        "selon la mesure à j. À droite, des barres comparent l’erreur attendue (bleu) à la vôtre (orange), selon x, "
        "y et θ.",
    ),
}
