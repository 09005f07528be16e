"""Drawings of the theorems: the error of ICP, a wrong minimum, a chain of springs, paths that drift."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from graders.plotting import Palette
from reference import se2
from reference.odometry import DifferentialDrive, LateralDrift, integrate_poses
from reference.registration.rigid import kabsch, squared_residual

Floats = NDArray[np.float64]

POSTS = np.arange(10.0)


def _outline() -> Floats:
    """A room with an alcove, as a lidar sees its walls."""
    corners = np.array(
        [[0, 0], [6, 0], [6, 4], [3.8, 4], [3.8, 5.2], [2.6, 5.2], [2.6, 4], [0, 4], [0, 0]], dtype=float
    )
    walls = pairwise(corners)
    return np.vstack(
        [a + np.linspace(0, 1, int(6 * np.linalg.norm(b - a)), endpoint=False)[:, None] * (b - a) for a, b in walls]
    )


def _half_steps(p: Floats, q: Floats, rounds: int) -> Floats:
    """The cost of ICP from the identity, after each pairing and each motion in turn."""
    R, t, costs = np.eye(2), np.zeros(2), []
    for _ in range(rounds):
        moved = p @ R.T + t
        pairs = q[np.argmin(((moved[:, None] - q) ** 2).sum(axis=2), axis=1)]
        costs.append(squared_residual(R, t, p, pairs))
        best = kabsch(p, pairs)
        R, t = best.R_q_p, best.t_q_p
        costs.append(squared_residual(R, t, p, pairs))
    return np.array(costs)


def draw_staircase(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    q = _outline()
    p = (q - np.array([2.95, 1.97])) @ se2.rotation_matrix(np.radians(14.0)).T + np.array([3.5, 2.3])
    costs = _half_steps(p, q, 16)
    halves = np.arange(1, len(costs) + 1) / 2
    axes.step(halves, costs, where="mid", color=palette.faint, lw=1.4)
    axes.plot(halves[0::2], costs[0::2], "o", color=palette.measure, ms=6, label="après l’appariement (a)")
    axes.plot(halves[1::2], costs[1::2], "s", color=palette.estimate, ms=5, label="après le déplacement (b)")
    axes.set(xlabel="tour", ylabel="somme des carrés", ylim=(0, None), xlim=(0, halves[-1] + 0.5))
    axes.legend()


def fence_cost(shift: float) -> float:
    """G: the sum of the squared distances of shifted posts to the nearest posts."""
    return float(np.square(np.abs(POSTS[:, None] + shift - POSTS).min(axis=1)).sum())


def draw_wrong_minimum(figure: Figure, palette: Palette) -> None:
    fence, axes = figure.subplots(2, 1, height_ratios=[1, 2.4])
    fence.plot(POSTS, np.ones(10), "|", color=palette.ink, ms=22, mew=3)
    fence.plot(POSTS + 0.9, np.zeros(10), "|", color=palette.estimate, ms=22, mew=3)
    for post in POSTS[:-1]:
        fence.plot([post + 0.9, post + 1.0], [0.25, 0.75], color=palette.faint, lw=1.2)
    fence.plot([9.9, 9.0], [0.25, 0.75], color=palette.alert, lw=1.4)
    fence.set(yticks=[0, 1], yticklabels=["vus, recalés", "clôture"], xticks=[], ylim=(-0.7, 1.6))
    fence.grid(False)
    for spine in fence.spines.values():
        spine.set_visible(False)
    shifts = np.linspace(-0.5, 2.3, 561)
    axes.plot(shifts, [fence_cost(s) for s in shifts], color=palette.truth, lw=2)
    for shift, label, colour, place in (
        (0.6, "départ", palette.ink, (0.72, 2.3)),
        (0.9, "arrêt d’ICP", palette.alert, (0.9, -0.55)),
        (0.0, "vrai minimum", palette.measure, (0.0, -0.9)),
    ):
        axes.plot(shift, fence_cost(shift), "o", color=colour, ms=8, zorder=4)
        axes.text(*place, label, color=colour, ha="center")
    axes.set(xlabel="décalage qui reste (en écarts de poteaux)", ylabel=r"somme $G$", ylim=(-1.3, 8))


def _spring(axes: Axes, start: float, end: float, height: float, colour: str, slack: float) -> None:
    """A zigzag; more coils stand for a softer spring."""
    coils = int(4 + 8 * slack)
    x = np.concatenate(
        [[start], np.linspace(start + 0.15 * (end - start), end - 0.15 * (end - start), 2 * coils), [end]]
    )
    y = height + 0.13 * np.concatenate([[0.0], np.tile([1.0, -1.0], coils), [0.0]])
    axes.plot(x, y, color=colour, lw=1.5)


def draw_chain(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    steps, variances, closure, target = np.array([2.0, 3.0, 2.0]), np.array([0.01, 0.04, 0.01]), 0.01, 8.4
    gap = target - steps.sum()
    force = gap / (variances.sum() + closure)
    before = np.concatenate([[0.0], np.cumsum(steps)])
    after = np.concatenate([[0.0], np.cumsum(steps + force * variances)])
    for places, height, colour in ((before, 1.0, palette.truth), (after, 0.0, palette.estimate)):
        for k in range(3):
            _spring(axes, places[k], places[k + 1], height, colour, variances[k] / 0.04)
        axes.plot(places, np.full(4, height), "o", color=colour, ms=11, zorder=4)
    for k in range(4):
        axes.plot([before[k], after[k]], [0.85, 0.15], color=palette.faint, lw=1.2, ls=(0, (4, 3)))
        axes.text(after[k], -0.3, f"$x_{k}$", ha="center", va="top", fontsize=13, color=palette.estimate)
    axes.plot([target, target], [-0.18, 1.38], color=palette.measure, lw=1.6, ls=(0, (4, 3)))
    axes.text(target + 0.1, 1.45, "fermeture", color=palette.measure, ha="center", fontsize=11)
    axes.annotate(
        "",
        xy=(target, 1),
        xytext=(before[-1] + 0.15, 1),
        arrowprops={"arrowstyle": "<->", "color": palette.alert, "lw": 1.6},
    )
    axes.text((before[-1] + target) / 2, 1.08, "$g$", color=palette.alert, ha="center", va="bottom", fontsize=13)
    axes.text(-0.35, 1.0, "odométrie", color=palette.truth, ha="right", va="center", fontsize=11)
    axes.text(-0.35, 0.0, "corrigée", color=palette.estimate, ha="right", va="center", fontsize=11)
    axes.text(3.5, 1.3, "plus incertaine, plus souple", color=palette.truth, ha="center", fontsize=10)
    axes.set(xlim=(-2.3, 9.2), ylim=(-0.75, 1.75), xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_drift(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    steps, length = 1000, 0.115
    drive = DifferentialDrive(track=0.3, sigma=1e-3)
    rng = np.random.default_rng(20)
    wheels = length + rng.normal(0.0, drive.sigma, (100, steps, 2))
    paths = integrate_poses(drive, wheels)
    axes.plot(paths[:, ::25, 0].T, paths[:, ::25, 1].T, color=palette.estimate, lw=0.6, alpha=0.5)
    turn = drive.turn_deviation(length, length)
    counts = np.arange(25, steps + 1, 25)
    band = np.array([LateralDrift(int(n), n * length, turn).lateral_deviation for n in counts])
    axes.fill_between(counts * length, -band, band, color=palette.truth, alpha=0.25, lw=0, zorder=1)
    axes.plot(counts * length, band, color=palette.truth, lw=2, zorder=3)
    axes.plot(counts * length, -band, color=palette.truth, lw=2, zorder=3)
    end = LateralDrift(steps, steps * length, turn)
    for sign in (1, -1):
        axes.plot(
            [0, end.distance],
            [0, sign * end.constant_error_deviation],
            color=palette.alert,
            lw=1.6,
            ls=(0, (5, 3)),
            zorder=4,
        )
    for height, colour in ((end.lateral_deviation, palette.truth), (end.constant_error_deviation, palette.alert)):
        axes.text(116.5, height, f"{height:.1f} m".replace(".", ","), color=colour, va="center", fontsize=10)
    axes.set(xlabel="distance (m)", ylabel="écart latéral (m)", xlim=(0, 130), ylim=(-28, 28))


FIGURES = {
    "fiche-icp-escalier": (
        draw_staircase,
        "La somme des carrés d'ICP sur seize tours, après chaque appariement et chaque déplacement. Elle "
        "descend vite, puis de plus en plus lentement, sans jamais remonter, jusqu'à un palier.",
        (5.6, 3.6),
    ),
    "fiche-icp-faux-minimum": (
        draw_wrong_minimum,
        "En haut, une clôture de dix poteaux et la même, recalée avec 0,9 intervalle de décalage : neuf "
        "poteaux sont près d'un mauvais voisin, le dernier loin du sien. En bas, la somme en fonction du "
        "décalage : un minimum nul en 0, un faux en 0,9.",
        (5.6, 3.6),
    ),
    "fiche-chaine-elastique": (
        draw_chain,
        "Quatre poses reliées par trois ressorts, avant et après une fermeture de boucle. Le ressort du "
        "milieu, le plus souple, s'allonge plus que les deux autres, et la dernière pose s'approche de "
        "l'endroit que dit la fermeture.",
    ),
    "fiche-derive": (
        draw_drift,
        "Cent trajets de 115 mètres qui s'écartent peu à peu d'une ligne droite. La bande à un écart-type "
        "s'ouvre jusqu'à 9,9 mètres ; deux droites en tirets, l'estimation pessimiste, atteignent 17,1 mètres.",
        (5.6, 3.6),
    ),
}
