"""Drawings of moves: turn, advance, turn; the banana of samples; turns and clouds in space."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Ellipse
from numpy.typing import NDArray

from graders.plotting import Palette
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry
from reference.registration import kabsch

Floats = NDArray[np.float64]

# The move of the lesson's example, and the noises of the three clouds.
MOVE = np.array([4.0, 3.0, np.pi / 2])
NOISES = (
    ("surtout en tournant", OdometryNoise(0.0, 0.12, 0.02, 0.0)),
    ("surtout en avançant", OdometryNoise(0.0, 0.012, 0.25, 0.0)),
    ("les deux", OdometryNoise(0.1, 0.1, 0.15, 0.02)),
)
STEPS = 5
SAMPLES = 500


@cache
def cloud(kind: int) -> Floats:
    """Where the samples of a noise are after some steps of 2 cells straight ahead, (SAMPLES, 3)."""
    rng = np.random.default_rng(3)
    poses = np.zeros((SAMPLES, 3))
    for _ in range(STEPS):
        poses = sample_odometry(poses, (2.0, 0.0, 0.0), NOISES[kind][1], rng)
    return poses


def _bare(axes: Axes) -> None:
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _arrow(axes: Axes, start: Floats, end: Floats, colour: str, width: float = 2.2) -> None:
    axes.annotate(
        "",
        xy=(float(end[0]), float(end[1])),
        xytext=(float(start[0]), float(start[1])),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0},
        zorder=5,
    )


def draw_three_moves(figure: Figure, palette: Palette) -> None:
    """A move by odometry as a turn, a straight line and a turn."""
    axes = figure.subplots()
    _bare(axes)
    start, end = np.zeros(2), MOVE[:2]
    towards = float(np.degrees(np.arctan2(MOVE[1], MOVE[0])))
    for place, angle, colour in ((start, 0.0, palette.truth), (end, 90.0, palette.estimate)):
        along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        axes.plot(*place, "o", color=colour, ms=17)
        _arrow(axes, place, place + 1.2 * along, colour)
    axes.plot(*np.transpose([start, end]), color=palette.ink, lw=1.6, ls=(0, (5, 3)))
    axes.plot(*np.transpose([end, end + 1.4 * end / 5]), color=palette.ink, lw=1, ls=":")
    axes.add_patch(Arc((0, 0), 1.9, 1.9, theta1=0, theta2=towards, color=palette.measure, lw=2))
    axes.add_patch(Arc((4, 3), 1.9, 1.9, theta1=towards, theta2=90, color=palette.measure, lw=2))
    axes.text(1.1, 0.28, r"$\delta_1$", color=palette.measure, fontsize=14)
    axes.text(4.42, 3.95, r"$\delta_2$", color=palette.measure, fontsize=14)
    axes.text(1.75, 1.85, r"$\delta$", color=palette.ink, fontsize=14)
    axes.text(-0.1, -0.65, "avant", color=palette.truth, fontsize=11, ha="center")
    axes.text(3.5, 3.2, "après", color=palette.estimate, fontsize=11, ha="right")
    axes.set(xlim=(-0.8, 5.6), ylim=(-0.9, 4.4))


def draw_bananas(figure: Figure, palette: Palette) -> None:
    """The same journey under three noises: an arc, a line, a banana; and the ellipse that would sum each up."""
    for kind, (axes, (title, _)) in enumerate(zip(figure.subplots(1, 3, sharey=True), NOISES, strict=True)):
        poses = cloud(kind)
        axes.set_title(title, fontsize=10)
        axes.plot([0, 2 * STEPS], [0, 0], color=palette.truth, lw=1.6)
        axes.plot([0], [0], "o", color=palette.truth, ms=7)
        axes.scatter(*poses[:, :2].T, s=4, color=palette.estimate, alpha=0.6, linewidths=0, zorder=3)
        mean, covariance = poses[:, :2].mean(axis=0), np.cov(poses[:, :2].T)
        variances, directions = np.linalg.eigh(covariance)
        angle = float(np.degrees(np.arctan2(directions[1, 1], directions[0, 1])))
        small, large = (float(4 * np.sqrt(variance)) for variance in variances)
        axes.add_patch(Ellipse(tuple(mean), large, small, angle=angle, fill=False, color=palette.second, lw=1.6))
        axes.plot(*mean, "+", color=palette.second, ms=10, mew=2, zorder=6)
        axes.set(xlim=(-1, 13), ylim=(-8, 8), aspect="equal", xticks=[0, 5, 10])


# A view of space: x to the right and towards us, y to the right and away, z up.
VIEW = np.array([[0.82, 0.62, 0.0], [-0.34, 0.26, 0.95]])
ABOUT_X = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
ABOUT_Z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def _frame(axes: Axes, turn: Floats, palette: Palette) -> None:
    for axis, colour, name in zip(turn.T, (palette.alert, palette.measure, palette.truth), "xyz", strict=True):
        end = VIEW @ axis
        _arrow(axes, np.zeros(2), end, colour)
        axes.text(*(1.16 * end), name, color=colour, fontsize=12, ha="center", va="center")


def draw_turns_in_space(figure: Figure, palette: Palette) -> None:
    """A frame, turned by a quarter around x, then around z."""
    steps = (
        ("au départ", np.eye(3)),
        ("quart de tour autour de x", ABOUT_X),
        ("puis autour de z", ABOUT_Z @ ABOUT_X),
    )
    for axes, (title, turn) in zip(figure.subplots(1, 3), steps, strict=True):
        _bare(axes)
        axes.set_title(title, fontsize=10)
        for axis in np.eye(3):
            axes.plot(*np.transpose([-1.1 * VIEW @ axis, 1.1 * VIEW @ axis]), color=palette.faint, lw=1)
        _frame(axes, turn, palette)
        axes.set(xlim=(-1.2, 1.2), ylim=(-1.2, 1.3))


@cache
def clouds() -> tuple[Floats, Floats]:
    """A corner of a room with a box in it, seen from two poses: paired points (n, 3)."""
    rng = np.random.default_rng(8)
    marks, heights = np.arange(0.2, 2.0, 0.4), np.arange(0.2, 1.2, 0.3)
    floor = np.array([(x, y, 0.0) for x in marks for y in marks])
    left = np.array([(0.0, y, z) for y in marks for z in heights])
    right = np.array([(x, 2.0, z) for x in marks for z in heights])
    box = np.array([(x, y, z) for x in (0.8, 1.3) for y in (0.7, 1.2) for z in (0.0, 0.5)])
    room = np.vstack([floor, left, right, box])
    seen = room @ (ABOUT_Z @ ABOUT_X).T + [0.4, 0.3, 0.2] + 0.02 * rng.standard_normal(room.shape)
    return room, seen


def draw_clouds_in_space(figure: Figure, palette: Palette) -> None:
    """Two clouds of space before and after the best rigid motion."""
    moving, still = clouds()
    best = kabsch(moving, still)
    before, after = figure.subplots(1, 2)
    for axes, title, cloud_ in (
        (before, "donnés", moving),
        (after, "recalés par Kabsch", moving @ best.R_q_p.T + best.t_q_p),
    ):
        _bare(axes)
        axes.set_title(title, fontsize=10)
        axes.scatter(*(VIEW @ still.T), s=26, facecolors="none", edgecolors=palette.truth, linewidths=1.2)
        axes.scatter(*(VIEW @ cloud_.T), s=9, color=palette.estimate, linewidths=0, zorder=4)
        axes.margins(0.06)


FIGURES = {
    "mouvement-tourner-avancer-tourner": (
        draw_three_moves,
        "Un robot avant et après un déplacement. D'abord tourné vers la droite, il pivote d'un angle delta 1 vers le "
        "point d'arrivée, avance en ligne droite de delta, puis pivote de delta 2 pour regarder vers le haut.",
        (5.4, 4.2),
    ),
    "mouvement-banane": (
        draw_bananas,
        "Trois nuages de cinq cents points, après un même trajet de dix cases en ligne droite. Si le bruit est "
        "surtout dans les rotations, un arc mince ; s'il est surtout dans l'avance, un trait couché le long du "
        "trajet ; avec les deux, un croissant épais. L'ellipse qui résume chaque nuage "
        "déborde du premier et du troisième.",
        (6.4, 2.9),
    ),
    "espace-quarts-de-tour": (
        draw_turns_in_space,
        "Trois flèches x, y, z d'un repère de l'espace. Après un quart de tour autour de x, y pointe vers le haut et z "
        "à l'opposé de l'ancien y. Après un second quart de tour, autour de z, x est là où était y, y là où était z, "
        "et z là où était x.",
        (6.4, 2.5),
    ),
    "espace-nuages": (
        draw_clouds_in_space,
        "Le coin d'une pièce, avec une boîte, en deux nuages de 73 points de l'espace. À gauche, l'un est couché et "
        "décalé par rapport à l'autre ; à droite, après recalage, chaque point de l'un est dans un cercle de l'autre.",
        (6.4, 3.4),
    ),
}
