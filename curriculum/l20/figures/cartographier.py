"""Drawings of the séance « Cartographier »: log-odds, rays through a grid, maps that grow and maps that drift."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from curriculum.l20.figures._slam_scenes import (
    EVERY,
    corrected_poses,
    draw_occupancy,
    draw_robot,
    frame_map,
    occupancy,
    panels,
    tour,
    world,
)
from graders.plotting import Palette
from reference.occupancy import InverseSensorModel, probability_of_log_odds
from reference.world.ray_cells import crossed_cells

Floats = NDArray[np.float64]

HIT = InverseSensorModel().hit


def draw_sigmoid(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    l = np.linspace(-6.2, 6.2, 300)
    axes.axvspan(-6.2, -5, color=palette.faint, alpha=0.35, lw=0)
    axes.axvspan(5, 6.2, color=palette.faint, alpha=0.35, lw=0)
    axes.plot(l, probability_of_log_odds(l), color=palette.truth, lw=2.2)
    steps = HIT * np.arange(-5, 6)
    axes.plot(steps, probability_of_log_odds(steps), "o", color=palette.estimate, ms=6, zorder=4)
    for a, b in pairwise(steps[5:]):
        height = -0.045
        axes.annotate("", (b, height), (a, height), arrowprops={"arrowstyle": "->", "color": palette.estimate})
    axes.text(2.1, -0.15, "+0,847 à chaque « touché »", color=palette.estimate, ha="center", va="center")
    for count in (0, 1, 2, 3):
        p = float(probability_of_log_odds(HIT * count))
        text = f"{p:.3g}".replace(".", ",")
        axes.text(HIT * count + 0.25, p - 0.045, text, color=palette.ink, fontsize=9.5)
    axes.text(5.6, 0.35, "saturé", rotation=90, ha="center", va="center", color=palette.ink, fontsize=9.5)
    axes.text(-5.6, 0.65, "saturé", rotation=90, ha="center", va="center", color=palette.ink, fontsize=9.5)
    axes.set_xlim(-6.2, 6.2)
    axes.set_ylim(-0.22, 1.05)
    axes.set_yticks([0, 0.25, 0.5, 0.75, 1])
    axes.set_xlabel("log-odds ℓ")
    axes.set_ylabel("probabilité d’être occupée")


def draw_ray(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    start, end = np.array([0.5, 4.4]), np.array([8.12, 1.62])
    stop = tuple(np.floor(end).astype(int))
    cells = crossed_cells(start[None], end[None])
    for cell in zip(cells.x.tolist(), cells.y.tolist(), strict=True):
        colour, alpha = (palette.estimate, 0.6) if cell == stop else (palette.truth, 0.25)
        axes.add_patch(Rectangle(cell, 1, 1, facecolor=colour, alpha=alpha, lw=0))
    for k in range(11):
        axes.plot([k, k], [0, 6], color=palette.faint, lw=0.8, zorder=0)
    for k in range(7):
        axes.plot([0, 10], [k, k], color=palette.faint, lw=0.8, zorder=0)
    axes.plot(*np.array([start, end]).T, color=palette.measure, lw=2.2, zorder=4)
    axes.plot(*_crossings(start, end).T, "o", color=palette.measure, ms=4.5, zorder=5)
    axes.plot(*end, "x", color=palette.alert, ms=10, mew=2.6, zorder=6)
    draw_robot(axes, np.array([*start, np.arctan2(*(end - start)[::-1])]), palette.ink, 0.22)
    axes.text(4.6, 4.5, "traversées : −0,847", ha="center", va="center", color=palette.truth, fontsize=11)
    axes.text(8.5, 0.5, "touchée : +0,847", ha="center", va="center", color=palette.estimate, fontsize=11)
    axes.text(2.5, 1.5, "les autres : rien", ha="center", va="center", color=palette.ink, fontsize=11)
    axes.set_xlim(-0.05, 10.05)
    axes.set_ylim(6.05, -0.05)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _crossings(start: Floats, end: Floats) -> Floats:
    """Where a segment crosses the lines of the grid."""
    parts = []
    for axis in (0, 1):
        low, high = sorted((start[axis], end[axis]))
        lines = np.arange(np.ceil(low), np.floor(high) + 1)
        parts.append((lines - start[axis]) / (end[axis] - start[axis]))
    t = np.sort(np.concatenate(parts))
    return np.asarray(start + t[:, None] * (end - start))


def draw_door(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    votes = HIT * np.concatenate([np.ones(20), -np.ones(25)])
    free, held = np.concatenate([[0.0], np.cumsum(votes)]), [0.0]
    for vote in votes:
        held.append(float(np.clip(held[-1] + vote, -5, 5)))
    times = np.arange(len(held))
    axes.axhspan(-5, 5, color=palette.faint, alpha=0.25, lw=0)
    axes.axhline(0, color=palette.ink, lw=0.8)
    axes.axvline(20, color=palette.ink, lw=1, ls=":")
    axes.text(20.4, 16.6, "la porte s’ouvre", ha="left", va="center")
    axes.plot(times, free, color=palette.second, lw=2)
    axes.plot(times, held, color=palette.estimate, lw=2.4)
    axes.text(13.2, 14.2, "sans borne", color=palette.second, ha="right")
    axes.text(9, 2.4, "bornée à ±5", color=palette.estimate, ha="center")
    axes.plot(26, held[26], "o", color=palette.estimate, ms=7, zorder=5)
    axes.plot(40, free[40], "o", color=palette.second, ms=7, zorder=5)
    axes.annotate("6 mesures", (26, held[26]), (21.8, -8.2), arrowprops={"arrowstyle": "-", "color": palette.ink})
    axes.annotate("20 mesures", (40, free[40]), (39.5, 6.8), arrowprops={"arrowstyle": "-", "color": palette.ink})
    axes.set_xlim(0, 45)
    axes.set_ylim(-10, 18.5)
    axes.set_xlabel("nombre de mesures de la case")
    axes.set_ylabel("log-odds ℓ")


def draw_growth(figure: Figure, palette: Palette) -> None:
    run = tour()
    for axes, count in zip(panels(figure, 2, 2), (1, 15, 55, len(run)), strict=True):
        draw_occupancy(axes, occupancy(run.truth, range(count)), palette)
        axes.plot(*run.truth[:count, :2].T, color=palette.truth, lw=1.8, zorder=3)
        draw_robot(axes, run.truth[count - 1], palette.truth)
        frame_map(axes)
        axes.set_title(f"{count} scan" + "s" * (count > 1))


def draw_drift(figure: Figure, palette: Palette) -> None:
    run = tour()
    stories = (
        ("poses vraies", run.truth, palette.truth),
        ("poses de l’odométrie", run.odometry, palette.estimate),
        ("poses corrigées par un SLAM", corrected_poses(), palette.measure),
    )
    *maps, last = panels(figure, 2, 2)
    for axes, (title, poses, colour) in zip(maps, stories, strict=True):
        draw_occupancy(axes, occupancy(poses, range(0, len(run), EVERY)), palette)
        axes.plot(*poses[:, :2].T, color=colour, lw=1.8, zorder=3)
        frame_map(axes, 2.9)
        axes.set_title(title)
    for (_, poses, colour), width in zip(stories, (4.5, 1.8, 1.6), strict=True):
        last.plot(*poses[:, :2].T, color=colour, lw=width, alpha=0.5 if width > 4 else 1.0)
    frame_map(last, 2.9)
    last.set_title("les trois trajets")


def draw_quadtree(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    size = 32
    states = np.zeros((size, size), dtype=int)
    height, width = world().shape
    states[8 : 8 + height, 0:width] = np.where(world().free, 1, 2)
    leaves = _leaves(states, 0, 0, size)
    shades = {0: palette.faint, 1: palette.paper, 2: palette.ink}
    for x, y, side, state in leaves:
        face = to_rgba(shades[state], 0.25 if state == 0 else 1.0)
        axes.add_patch(Rectangle((x, y), side, side, facecolor=face, edgecolor=palette.truth, lw=0.7))
    axes.set_xlim(-0.2, size + 0.2)
    axes.set_ylim(24.3, 7.7)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _leaves(states: NDArray[np.int64], x: int, y: int, side: int) -> list[tuple[int, int, int, int]]:
    """The squares (x, y, side, state) of one state into which a square is cut by four, again and again."""
    part = states[y : y + side, x : x + side]
    if np.all(part == part[0, 0]):
        return [(x, y, side, int(part[0, 0]))]
    half = side // 2
    quarters = [(x + i, y + j) for j in (0, half) for i in (0, half)]
    return [leaf for i, j in quarters for leaf in _leaves(states, i, j, half)]


def draw_signed_distance(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    r, wall, reach = np.linspace(0, 8, 400), 5.0, 1.2
    distance = np.clip(wall - r, -reach, reach)
    log_odds = np.where(r < wall, -HIT, np.where(r < wall + 0.4, HIT, 0.0))
    axes.axvspan(wall, wall + 0.4, color=palette.ink, alpha=0.75, lw=0)
    axes.axhline(0, color=palette.ink, lw=0.8)
    axes.step(r, log_odds, color=palette.estimate, lw=2, where="mid")
    axes.plot(r[r < wall + reach], distance[r < wall + reach], color=palette.truth, lw=2.4)
    axes.plot(wall, 0, "o", color=palette.alert, ms=7, zorder=5)
    axes.text(2.3, 1.3, "distance signée tronquée", color=palette.truth, ha="center", va="bottom")
    axes.text(2.3, -0.75, "log-odds ajouté", color=palette.estimate, ha="center", va="bottom")
    axes.text(wall + 0.5, 1.55, "mur", ha="left")
    axes.text(7.2, 0.1, "inconnu", ha="center")
    axes.set_ylim(-1.5, 1.85)
    axes.set_xlim(0, 8)
    axes.set_xlabel("distance le long du rayon (cases)")


def draw_cone(figure: Figure, palette: Palette) -> None:
    """A wide beam says that one cell of an arc is occupied; a product over cells cannot."""
    joint = {"vide, vide": (0.0, 0.25), "A seule": (0.5, 0.25), "B seule": (0.5, 0.25), "A et B": (0.0, 0.25)}
    axes: Axes = figure.subplots()
    places = np.arange(len(joint))
    for shift, which, colour, name in (
        (-0.18, 0, palette.truth, "ce que dit la mesure"),
        (0.18, 1, palette.estimate, "ce que retient la grille"),
    ):
        values = [pair[which] for pair in joint.values()]
        axes.bar(places + shift, values, 0.34, color=colour, label=name)
    axes.set_xticks(places, list(joint))
    axes.tick_params(axis="x", length=0)
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("probabilité")
    axes.set_ylim(0, 0.68)
    axes.legend(loc="upper right", ncols=2)


FIGURES = {
    "carto-sigmoide": (
        draw_sigmoid,
        "Courbe en S : la probabilité en fonction du log-odds. Des pas égaux de 0,847 sur l'axe mènent de 0,5 "
        "à 0,7, puis 0,845, puis 0,927 : les pas en probabilité sont de plus en plus petits.",
        (5.6, 3.4),
    ),
    "carto-rayon": (
        draw_ray,
        "Un rayon traverse une grille depuis le robot : chaque case traversée reçoit −0,85, la case où il s'arrête "
        "reçoit +0,85, les autres restent inconnues.",
        (5.6, 3.5),
    ),
    "carto-porte": (
        draw_door,
        "Log-odds d'une case : vingt « touchés », puis la porte s'ouvre. Bornée à 5, la valeur repasse sous zéro après "
        "6 mesures contraires ; sans borne, elle en demande 20.",
        (5.6, 3.4),
    ),
    "carto-croissance": (
        draw_growth,
        "Quatre états de la carte : après 1 scan, une pièce ; après 15, deux pièces ; après 55, le couloir et une "
        "salle ; après 143, presque tout le bâtiment. Le fond gris est inconnu.",
        (5.8, 4.4),
    ),
    "carto-derive": (
        draw_drift,
        "La même suite de scans placée sur trois trajets. Poses vraies : murs nets. Odométrie : murs dédoublés et "
        "tournés. Poses corrigées par le SLAM : murs nets de nouveau. Dernier dessin : "
        "les trois trajets superposés.",
        (5.8, 4.9),
    ),
    "carto-quadtree": (
        draw_quadtree,
        "La carte du module découpée en carrés emboîtés : de grands carrés là où tout est libre ou inconnu, de petits "
        "carrés le long des murs.",
        (5.8, 3.2),
    ),
    "carto-tsdf": (
        draw_signed_distance,
        "Le long d'un rayon qui frappe un mur à 5 cases : le log-odds ajouté est un créneau, la distance signée "
        "décroît en droite et passe par zéro exactement sur le mur.",
        (5.6, 3.1),
    ),
    "carto-independance": (
        draw_cone,
        "Probabilité des quatre états de deux cases A et B. La mesure dit : exactement l'une des deux. La grille, qui "
        "multiplie, donne un quart à chaque état, même aux deux impossibles.",
        (5.6, 2.7),
    ),
}
