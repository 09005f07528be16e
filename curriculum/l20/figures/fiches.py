"""Drawings of the sheet of formulas: a step on two wheels, composed poses, log-odds, clouds once centred."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc
from numpy.typing import NDArray

from graders.plotting import Palette
from reference import se2
from reference.occupancy import log_odds, probability_of_log_odds
from reference.odometry import DifferentialDrive
from reference.registration.rigid import kabsch

Floats = NDArray[np.float64]

TOUCH = float(log_odds(0.7))


def _bare(axes: Axes) -> None:
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _arrow(axes: Axes, start: Floats, end: Floats, colour: str, width: float = 1.8, style: str = "-|>") -> None:
    axes.annotate(
        "",
        xy=(float(end[0]), float(end[1])),
        xytext=(float(start[0]), float(start[1])),
        arrowprops={"arrowstyle": style, "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0},
        zorder=4,
    )


def _axle(axes: Axes, pose: Floats, track: float, colour: str) -> None:
    """The axle and its two wheels, seen from above."""
    along = np.array([np.cos(pose[2]), np.sin(pose[2])])
    left = np.array([-along[1], along[0]]) * track / 2
    axes.plot(*np.transpose([pose[:2] - left, pose[:2] + left]), color=colour, lw=2)
    for side in (left, -left):
        wheel = np.array([pose[:2] + side - 0.13 * along, pose[:2] + side + 0.13 * along])
        axes.plot(*wheel.T, color=colour, lw=7, solid_capstyle="round")


def draw_wheels(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    _bare(axes)
    drive = DifferentialDrive(track=0.9)
    left, right = 0.95, 1.75
    paths = np.array([drive.step_along_arc((0, 0, 0), left * k, right * k) for k in np.linspace(0, 1, 60)])
    normals = np.column_stack([-np.sin(paths[:, 2]), np.cos(paths[:, 2])]) * drive.track / 2
    start, end, turn = paths[0], paths[-1], float(paths[-1, 2])
    axes.plot(*paths[:, :2].T, color=palette.truth, lw=2.4)
    for side in (1, -1):
        axes.plot(*(paths[:, :2] + side * normals).T, color=palette.truth, lw=1.2, ls=(0, (4, 3)))
    _axle(axes, start, drive.track, palette.ink)
    _axle(axes, end, drive.track, palette.ink)
    _arrow(axes, start[:2], end[:2], palette.estimate)
    axes.plot([0, 1.0], [0, 0], color=palette.ink, lw=0.8, ls=":")
    axes.add_patch(Arc((0, 0), 1.5, 1.5, theta1=0, theta2=float(np.degrees(turn / 2)), color=palette.estimate, lw=1.2))
    axes.text(0.82, 0.13, r"$\Delta\theta/2$", color=palette.estimate, fontsize=13)
    _arrow(axes, end[:2], end[:2] + 0.55 * np.array([np.cos(turn), np.sin(turn)]), palette.ink, 1.2)
    ahead = end[:2] + np.array([0.5, 0.0])
    axes.plot(*np.transpose([end[:2], ahead]), color=palette.ink, lw=0.8, ls=":")
    axes.text(end[0] + 0.42, end[1] + 0.12, r"$\Delta\theta$", color=palette.ink, fontsize=13)
    middle = len(paths) // 2
    for side, label, gap in ((1, r"$\Delta s_g$", 0.08), (-1, r"$\Delta s_d$", -0.2)):
        x, y = paths[middle, :2] + side * normals[middle]
        axes.text(x, y + gap, label, color=palette.truth, fontsize=13, ha="center")
    axes.text(0.72, -0.06, r"$\Delta s$", color=palette.truth, fontsize=13, va="top")
    axes.text(-0.1, 0.2, r"$L$", color=palette.ink, fontsize=13, ha="right")
    axes.set(xlim=(-0.45, 2.0), ylim=(-0.75, 1.25))


def draw_composition(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    _bare(axes)
    world, first, second = np.zeros(3), np.array([1.4, 0.7, np.pi / 6]), np.array([1.7, 0.8, np.pi / 4])
    composed = se2.compose(first, second)
    corner = se2.compose(first, (second[0], 0.0, 0.0))
    for pose, name, colour in (
        (world, "monde", palette.ink),
        (first, "robot 1", palette.truth),
        (composed, "2", palette.estimate),
    ):
        turn = se2.rotation_matrix(float(pose[2]))
        for axis in (0, 1):
            _arrow(axes, pose[:2], pose[:2] + 0.55 * turn[:, axis], colour, 2.2)
        below = pose[:2] + turn @ np.array([-0.05, -0.2])
        axes.text(below[0], below[1], name, color=colour, fontsize=11, ha="center", va="top")
    by_two_legs = np.array([first[:2], corner[:2], composed[:2]])
    axes.plot(*by_two_legs.T, lw=1.2, ls=(0, (4, 3)), color=palette.measure)
    axes.plot([first[0], first[0] + 0.95], [first[1]] * 2, color=palette.ink, lw=0.8, ls=":")
    axes.add_patch(Arc((first[0], first[1]), 1.6, 1.6, theta1=0, theta2=30, color=palette.truth, lw=1.2))
    axes.text(first[0] + 0.86, first[1] + 0.16, r"$\theta_1$", color=palette.truth, fontsize=13)
    along, across = (first + corner) / 2, (corner + composed) / 2
    axes.text(along[0] + 0.4, along[1] + 0.1, r"$x_2$", color=palette.measure, fontsize=13, va="top")
    axes.text(across[0] + 0.08, across[1], r"$y_2$", color=palette.measure, fontsize=13)
    _arrow(axes, world[:2], composed[:2], palette.estimate, 1.0)
    axes.set(xlim=(-0.4, 3.9), ylim=(-0.4, 2.9))


def draw_log_odds(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    levels = np.linspace(-7, 7, 300)
    axes.plot(levels, probability_of_log_odds(levels), color=palette.truth, lw=2.2)
    for bound in (-5.0, 5.0):
        axes.axvline(bound, color=palette.alert, lw=1.2, ls=(0, (4, 3)))
        axes.text(
            bound, 0.5, " borne " if bound > 0 else "borne ", color=palette.alert, ha="left" if bound > 0 else "right"
        )
    touches = TOUCH * np.arange(7)
    axes.plot(touches, probability_of_log_odds(touches), "o", color=palette.estimate, ms=6, zorder=4)
    for start, end in pairwise(touches[:4]):
        low, high = float(probability_of_log_odds(start)), float(probability_of_log_odds(end))
        axes.plot([start, end, end], [low, low, high], color=palette.estimate, lw=1)
    axes.annotate(
        "un touché : +0,847",
        xy=(TOUCH / 2, 0.5),
        xytext=(0.9, 0.3),
        color=palette.estimate,
        arrowprops={"arrowstyle": "-", "color": palette.estimate, "lw": 0.8},
    )
    axes.set(xlabel=r"log-odds $\ell$", ylabel=r"probabilité $p$", xlim=(-7, 7), ylim=(-0.02, 1.02))
    axes.set_xticks([-6, -4, -2, 0, 2, 4, 6])


def draw_centred(figure: Figure, palette: Palette) -> None:
    shape = np.array([[0.0, 0.0], [1.9, 0.1], [2.0, 1.0], [1.0, 1.1], [0.9, 2.2]])
    noise = 0.05 * np.array([[1, -1], [-1, 1], [0, 1], [1, 0], [-1, -1]])
    moved = shape @ se2.rotation_matrix(np.radians(55.0)).T + np.array([3.9, 0.5]) + noise
    best = kabsch(shape, moved)
    before, after = figure.subplots(1, 2)
    centred = (shape - shape.mean(axis=0), moved - moved.mean(axis=0))
    for axes, clouds, title in ((before, (shape, moved), "donnés"), (after, centred, "centrés")):
        _bare(axes)
        axes.set_title(title)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.1)
        for p, q in zip(*clouds, strict=True):
            axes.plot(*np.transpose([p, q]), color=palette.faint, lw=1.2, zorder=1)
        for cloud, colour, marker in zip(clouds, (palette.truth, palette.estimate), "os", strict=True):
            axes.plot(*np.vstack([cloud, cloud[:1]]).T, color=colour, lw=1, alpha=0.5)
            axes.plot(*cloud.T, marker, color=colour, ms=7)
            axes.plot(*cloud.mean(axis=0), "+", color=colour, ms=13, mew=2)
    before.text(*(shape.mean(axis=0) + np.array([0.12, -0.5])), r"$\bar p$", color=palette.truth, fontsize=13)
    before.text(*(moved.mean(axis=0) + np.array([0.15, -0.45])), r"$\bar q$", color=palette.estimate, fontsize=13)
    turn = float(np.degrees(np.arctan2(best.R_q_p[1, 0], best.R_q_p[0, 0])))
    after.set_xlabel(f"il reste à tourner de {turn:.0f}°", fontsize=11)


FIGURES = {
    "fiche-deux-roues": (
        draw_wheels,
        "Un essieu à deux roues avant et après un pas. La roue droite a parcouru un arc plus long que la "
        "gauche. Le milieu de l'essieu suit un arc, et la corde de cet arc fait avec la direction de départ "
        "la moitié de l'angle tourné.",
    ),
    "fiche-composition": (
        draw_composition,
        "Trois repères : celui du monde, celui du robot 1, tourné de 30 degrés, et un repère 2 que l'on "
        "atteint depuis le robot en avançant de x2 selon son premier axe puis de y2 selon le second.",
    ),
    "fiche-logodds": (
        draw_log_odds,
        "La probabilité en fonction du log-odds : une courbe en S, de 0 à 1, qui passe par un demi en 0. Six "
        "touchés y avancent de pas égaux en abscisse et de plus en plus courts en ordonnée. Deux traits "
        "verticaux marquent les bornes, -5 et 5.",
        (5.6, 3.6),
    ),
    "fiche-kabsch": (
        draw_centred,
        "À gauche, deux nuages de cinq points appariés, l'un tourné et déplacé par rapport à l'autre. À "
        "droite, les mêmes après centrage : leurs centres coïncident et seule une rotation les sépare.",
    ),
}
