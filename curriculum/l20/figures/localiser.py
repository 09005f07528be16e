"""Drawings of the first séance: a world, what a lidar sees of it, what wheels forget, and where the robot may be."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from curriculum.l20.figures._plan import (
    RANGE,
    draw_impacts,
    draw_rays,
    draw_robot,
    draw_walls,
    french,
    mark_axes,
    module_map,
    ray_ends,
)
from graders.plotting import Palette
from reference.odometry import LateralDrift
from reference.world.scan import full_turn_angles

Floats = NDArray[np.float64]

ROBOT = (8.6, 7.4, 0.35)


def draw_world(figure: Figure, palette: Palette) -> None:
    """The map, the robot and its 36 rays; under it, the scan: a distance for each direction."""
    figure.set_size_inches(5.8, 6.6)
    above, below = figure.subplots(2, 1, height_ratios=[2.1, 1.0])
    ranges = module_map().cast_scans([ROBOT], full_turn_angles(36), RANGE)[0]
    draw_walls(above, palette, module_map())
    mark_axes(above, palette)
    draw_rays(above, ROBOT, ranges, palette.measure)
    draw_impacts(above, ray_ends(ROBOT, ranges)[ranges < RANGE], palette.measure, 18)
    draw_robot(above, ROBOT, palette.truth, palette)
    above.set_title("Le robot et ses 36 rayons, sur la carte")
    below.vlines(range(36), 0, ranges, color=palette.measure, lw=2.0)
    below.plot(range(36), ranges, "o", color=palette.measure, ms=4.5)
    below.set(xlim=(-1, 36), ylim=(0, 13), xticks=[0, 9, 18, 27, 35], yticks=[0, 4, 8, 12])
    below.set_xlabel("numéro du rayon")
    below.set_ylabel("distance (cases)")
    below.set_title("Le scan : tout ce que le robot reçoit")
    below.grid(axis="x", visible=False)


def draw_ray_casting(figure: Figure, palette: Palette) -> None:
    """One ray, the lines of the grid that it crosses, and the cells that it visits."""
    figure.set_size_inches(5.8, 3.9)
    axes = figure.subplots()
    start, angle = np.array([0.45, 0.3]), 0.5
    direction = np.array([np.cos(angle), np.sin(angle)])
    at_columns = [((k - start[0]) / direction[0], "x") for k in range(1, 7)]
    at_rows = [((k - start[1]) / direction[1], "y") for k in range(1, 4)]
    crossings = sorted(at_columns + at_rows)[:8]
    end = start + crossings[-1][0] * direction
    for number, (length, _) in enumerate([(0.0, ""), *crossings[:-1]]):
        column, row = np.floor(start + (length + 1e-6) * direction)
        axes.add_patch(Rectangle((column, row), 1, 1, color=palette.measure, alpha=0.14, lw=0, zorder=1))
        axes.text(column + 0.09, row + 0.24, str(number), fontsize=10, color=palette.ink, alpha=0.75)
    column, row = np.floor(start + (crossings[-1][0] + 1e-6) * direction)
    axes.add_patch(Rectangle((column, row), 1, 1, color=palette.ink, alpha=0.8, lw=0, zorder=2))
    axes.plot(*np.column_stack([start, end]), color=palette.measure, lw=2.2, zorder=3)
    for length, kind in crossings:
        x, y = start + length * direction
        colour = palette.truth if kind == "x" else palette.estimate
        axes.plot([x], [y], "o", color=colour, ms=8, mec=palette.paper, mew=1.2, zorder=5)
    axes.plot(*start, "o", color=palette.ink, ms=9, zorder=5)
    axes.set_xticks(range(9), minor=False)
    axes.set_yticks(range(5))
    axes.set(xlim=(0, 7), ylim=(4, 0), aspect="equal")
    axes.tick_params(length=0, labelsize=9.5)
    handles = [
        Line2D([], [], marker="o", ls="", color=palette.truth, ms=8, label="ligne verticale franchie"),
        Line2D([], [], marker="o", ls="", color=palette.estimate, ms=8, label="ligne horizontale franchie"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=10)


HYPOTHESES = (("Au bon endroit", (8.6, 7.4, 0.35)), ("Deux cases plus à droite, trop tourné", (10.6, 7.8, 0.6)))


def draw_hypotheses(figure: Figure, palette: Palette) -> None:
    """The same scan, laid on the map from two poses: on the walls, or beside them."""
    figure.set_size_inches(5.8, 7.4)
    ranges = module_map().cast_scans([ROBOT], full_turn_angles(72), RANGE)[0]
    for axes, (title, pose) in zip(figure.subplots(2, 1), HYPOTHESES, strict=True):
        expected = module_map().cast_scans([pose], full_turn_angles(72), RANGE)[0]
        gap = float(np.abs(expected - ranges).mean())
        draw_walls(axes, palette, module_map(), 0.55)
        draw_impacts(axes, ray_ends(pose, ranges)[ranges < RANGE], palette.measure, 26)
        draw_robot(axes, pose, palette.estimate, palette)
        axes.set_title(f"{title} : écart moyen {french(gap)}")


@cache
def dead_reckoning_paths() -> Floats:
    """Where 400 robots that hold a straight line, 1000 steps of 0.115 m, are after every 40th step, (400, 26, 2)."""
    rng = np.random.default_rng(20)
    turns = rng.normal(0.0, np.sqrt(2.0) * 1e-3 / 0.3, (400, 1000))
    headings = np.cumsum(turns, axis=1) - turns / 2.0
    steps = 0.115 * np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    return np.cumulative_sum(steps, axis=1, include_initial=True)[:, ::40]


def draw_drift(figure: Figure, palette: Palette) -> None:
    """Journeys by odometry alone, one standard deviation of them, and the pessimistic estimate of the exercise."""
    figure.set_size_inches(5.8, 5.0)
    axes = figure.subplots()
    paths = dead_reckoning_paths()
    for path in paths[:80]:
        axes.plot(*path.T, color=palette.estimate, lw=0.6, alpha=0.32)
    axes.scatter(*paths[:, -1].T, s=7, color=palette.estimate, linewidths=0, zorder=3, label="arrivées (400 essais)")
    axes.plot([0, 115], [0, 0], color=palette.truth, lw=2.4, zorder=4, label="ce que le robot croit faire")
    lengths = np.linspace(1, 1000, 100)
    drifts = [LateralDrift(int(n), 0.115 * int(n), np.sqrt(2.0) * 1e-3 / 0.3) for n in lengths]
    band = np.array([drift.lateral_deviation for drift in drifts])
    for sign in (1, -1):
        axes.plot(
            0.115 * lengths,
            sign * band,
            color=palette.ink,
            lw=1.8,
            zorder=5,
            label="± 1 écart-type" if sign > 0 else None,
        )
    end = LateralDrift(1000, 115.0, np.sqrt(2.0) * 1e-3 / 0.3)
    axes.plot(
        [0, 115],
        [0, end.constant_error_deviation],
        "--",
        color=palette.alert,
        lw=1.8,
        zorder=5,
        label="cap faux de 0,149 rad dès le départ",
    )
    axes.text(
        116.5, end.constant_error_deviation, "17,1 m", color=palette.alert, va="center", fontsize=11, weight="bold"
    )
    axes.text(116.5, -end.lateral_deviation, "9,9 m", color=palette.ink, va="center", fontsize=11, weight="bold")
    axes.set(xlim=(0, 128), ylim=(-34, 34), xlabel="avancée (m)", ylabel="écart latéral (m)")
    figure.legend(loc="outside lower center", ncols=2, fontsize=9.5)


CORRIDOR_DOORS = np.array([False, True, True, False, False])
CORRIDOR_TITLES = ("Au départ : aucune idée", "Il voit une porte", "Il avance d’une case", "Il voit encore une porte")


def corridor_beliefs() -> list[Floats]:
    """The belief over five cells: at first, after a door, after a move that fails one time in five, after a door."""
    likelihood = np.where(CORRIDOR_DOORS, 0.8, 0.2)
    start = np.full(5, 0.2)
    seen = start * likelihood / np.sum(start * likelihood)
    moved = 0.2 * seen + 0.8 * np.concatenate([[0.0], seen[:-1]])
    moved[-1] += 0.8 * seen[-1]
    return [start, seen, moved, moved * likelihood / np.sum(moved * likelihood)]


def draw_corridor(figure: Figure, palette: Palette) -> None:
    """The belief in a corridor of five cells, two of them with a door, through two corrections and a move."""
    figure.set_size_inches(5.8, 6.4)
    colours = (palette.faint, palette.measure, palette.estimate, palette.measure)
    panels = figure.subplots(4, 1, sharex=True)
    for axes, belief, title, colour in zip(panels, corridor_beliefs(), CORRIDOR_TITLES, colours, strict=True):
        for cell in np.flatnonzero(CORRIDOR_DOORS):
            axes.axvspan(cell + 0.5, cell + 1.5, color=palette.second, alpha=0.13, lw=0)
        axes.bar(range(1, 6), belief, width=0.72, color=colour, zorder=3)
        for cell, mass in enumerate(belief, start=1):
            axes.text(cell, mass + 0.03, french(float(mass), 3), ha="center", fontsize=10)
        axes.set(ylim=(0, 0.76), yticks=[], xlim=(0.4, 5.6))
        axes.set_title(title, loc="left", fontsize=11)
        axes.spines["left"].set_visible(False)
        axes.grid(False)
    panels[-1].set_xticks(
        range(1, 6), ["case 1", "case 2\n(porte)", "case 3\n(porte)", "case 4", "case 5"], fontsize=10
    )
    panels[-1].tick_params(length=0)


def draw_comb(figure: Figure, palette: Palette) -> None:
    """Weights laid end to end, and the eight teeth of the comb."""
    figure.set_size_inches(5.8, 2.9)
    axes = figure.subplots()
    weights = np.array([0.05, 0.32, 0.03, 0.20, 0.08, 0.02, 0.25, 0.05])
    ends, offset = np.cumsum(weights), 0.09
    teeth = offset + np.arange(8) / 8
    owners = np.searchsorted(ends, teeth)
    copies = np.bincount(owners, minlength=8)
    for number, (end, weight) in enumerate(zip(ends, weights, strict=True)):
        kept = copies[number] > 0
        axes.add_patch(
            Rectangle(
                (end - weight, 0),
                weight,
                1,
                facecolor=palette.estimate if kept else palette.faint,
                alpha=0.65,
                edgecolor=palette.paper,
                lw=1.5,
            )
        )
        axes.text(end - weight / 2, 0.5, str(number), ha="center", va="center", fontsize=12, weight="bold")
        axes.text(end - weight / 2, -0.28, f"×{copies[number]}", ha="center", va="center", fontsize=11)
    axes.plot([teeth[0], teeth[-1]], [1.75, 1.75], color=palette.ink, lw=4, solid_capstyle="round")
    for tooth in teeth:
        axes.plot([tooth, tooth], [1.75, 0.86], color=palette.ink, lw=2)
    axes.annotate(
        "", xy=(teeth[0], 1.32), xytext=(0, 1.32), arrowprops={"arrowstyle": "<->", "color": palette.alert, "lw": 1.4}
    )
    axes.text(teeth[0] / 2, 1.48, "u", color=palette.alert, ha="center", fontsize=13, style="italic")
    axes.set(xlim=(-0.01, 1.01), ylim=(-0.5, 2.0), yticks=[], xticks=[0, 0.25, 0.5, 0.75, 1])
    axes.grid(False)
    axes.spines["left"].set_visible(False)


FIGURES = {
    "monde-simule": (
        draw_world,
        "En haut, la carte du module : des murs, un robot dans le couloir et 36 rayons qui s’arrêtent sur les murs. "
        "En bas, les 36 distances du scan, en bâtons.",
        (5.8, 6.6),
    ),
    "lancer-de-rayon": (
        draw_ray_casting,
        "Un rayon traverse une grille. Ses croisements avec les lignes verticales et horizontales sont marqués, les "
        "cases visitées sont numérotées de 0 à 7, et le rayon s’arrête au bord de la case pleine.",
        (5.8, 3.9),
    ),
    "que-verrais-je": (
        draw_hypotheses,
        "Le même scan posé sur la carte depuis deux poses. Depuis la bonne, tous les impacts tombent sur des murs ; "
        "depuis l’autre, beaucoup tombent à côté.",
        (5.8, 7.4),
    ),
    "derive-odometrie": (
        draw_drift,
        "Des trajets simulés s’écartent en éventail de la ligne droite de 115 mètres que le robot croit suivre. "
        "L’écart-type latéral atteint 9,9 m ; la droite de l’estimation pessimiste atteint 17,1 m.",
        (5.8, 5.0),
    ),
    "croyance-couloir": (
        draw_corridor,
        "Quatre histogrammes de la croyance sur cinq cases : uniforme, puis deux barres à 0,364 sur les portes, puis "
        "étalée vers la droite, puis une barre dominante à 0,576 sur la case 3.",
        (5.8, 6.4),
    ),
    "peigne": (
        draw_comb,
        "Les poids de huit particules mis bout à bout sur un segment, et un peigne de huit dents régulières : chaque "
        "dent désigne la particule copiée. La particule 1 est copiée trois fois, la 3 et la 6 deux fois, la 7 une fois "
        "; les quatre autres disparaissent.",
        (5.8, 2.9),
    ),
}
