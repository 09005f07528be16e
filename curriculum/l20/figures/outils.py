"""Drawings of the toolbox of mathematics: products, traces, singular values, ellipses, gradients, turns, logarithms."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from curriculum.l20.figures._gestes import gestures
from graders.plotting import Palette
from reference.se2 import rotation_matrix

Floats = NDArray[np.float64]

# What the sheet computes by hand, which its test computes again.
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
STRETCH = np.diag([2.0, 1.0])
CROSS = np.array([[3.0, 1.0], [-2.0, 1.0]])
MATRIX = np.array([[1.0, -1.0], [2.0, 2.0]])
COVARIANCE = np.array([[5.0, 3.0], [3.0, 5.0]])
FLAG = np.array([(0.0, 0.0), (0.0, 1.0), (0.7, 0.75), (0.0, 0.5)])


def valley(x: float | Floats, y: float | Floats) -> float | Floats:
    """The sum of three squares of which the sheet looks for the minimum."""
    return x**2 + (y - x) ** 2 + (y - 0.3) ** 2


def slope(x: float, y: float) -> Floats:
    """Its gradient."""
    return np.array([4 * x - 2 * y, -2 * x + 4 * y - 0.6])


def _plane(axes: Axes, palette: Palette, left: float, right: float, bottom: float, top: float) -> None:
    axes.axhline(0, color=palette.faint, lw=1, zorder=1)
    axes.axvline(0, color=palette.faint, lw=1, zorder=1)
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _arrow(axes: Axes, end: Floats, colour: str, start: Floats | None = None) -> None:
    foot = np.zeros(2) if start is None else start
    axes.annotate(
        "",
        xy=(float(end[0]), float(end[1])),
        xytext=(float(foot[0]), float(foot[1])),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2, "shrinkA": 0, "shrinkB": 0},
        zorder=5,
    )


def _flag(axes: Axes, matrix: Floats, colour: str) -> None:
    shape = FLAG @ matrix.T
    axes.fill(*shape[1:].T, color=colour, alpha=0.35, lw=0, zorder=3)
    axes.plot(*np.vstack([shape, shape[1:2]])[:3].T, color=colour, lw=2, zorder=4)
    axes.plot(*shape[[2, 3]].T, color=colour, lw=2, zorder=4)


def draw_product(figure: Figure, palette: Palette) -> None:
    """A flag that is stretched then turned, and turned then stretched."""
    for axes, (title, matrices) in zip(
        figure.subplots(1, 3),
        (
            ("au départ", []),
            ("étirer, puis tourner : R E", [STRETCH, TURN]),
            ("tourner, puis étirer : E R", [TURN, STRETCH]),
        ),
        strict=True,
    ):
        _plane(axes, palette, -2.2, 1.6, -0.4, 1.6)
        axes.set_title(title, fontsize=10)
        done = np.eye(2)
        for step, matrix in enumerate([np.eye(2), *matrices]):
            done = matrix @ done
            last = step == len(matrices)
            _flag(axes, done, palette.estimate if last and matrices else palette.truth if not step else palette.faint)


def draw_trace(figure: Figure, palette: Palette) -> None:
    """The trace of R(angle) H, whose greatest value is the angle that Kabsch looks for."""
    axes = figure.subplots()
    angles = np.linspace(-np.pi, np.pi, 361)
    traces = [float(np.trace(rotation_matrix(float(angle)) @ CROSS)) for angle in angles]
    best = float(np.arctan2(CROSS[0, 1] - CROSS[1, 0], np.trace(CROSS)))
    axes.plot(np.degrees(angles), traces, color=palette.truth, lw=2.2)
    axes.plot([np.degrees(best)] * 2, [-5.6, 5], color=palette.estimate, lw=1.2, ls=(0, (4, 3)))
    axes.plot([np.degrees(best)], [5], "o", color=palette.estimate, ms=8)
    axes.text(np.degrees(best) + 6, 5.15, "36,9° : la trace vaut 5", color=palette.estimate, fontsize=10)
    axes.plot([0], [4], "o", color=palette.ink, ms=6)
    axes.text(-8, 4.1, "sans tourner : 4", color=palette.ink, fontsize=10, ha="right")
    axes.set(xlim=(-180, 180), ylim=(-5.6, 6.2), xlabel="angle de la rotation R (degrés)", ylabel="trace de R H")
    axes.set_xticks([-180, -90, 0, 90, 180])


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):+.0f}°".replace("-", "\N{MINUS SIGN}")


def draw_svd(figure: Figure, palette: Palette) -> None:
    """The three gestures of a matrix: a turn, a stretch along the axes, a turn."""
    found = gestures(MATRIX)
    steps = (
        ("un cercle", found.after(0, 0, 0)),
        (f"1. tourner de {_degrees(found.first)}", found.after(1, 0, 0)),
        ("2. étirer", found.after(1, 1, 0)),
        (f"3. tourner de {_degrees(found.last)}", found.after(1, 1, 1)),
    )
    circle = np.array([(np.cos(t), np.sin(t)) for t in np.linspace(0, 2 * np.pi, 100)])
    for axes, (title, matrix) in zip(figure.subplots(2, 2).flat, steps, strict=True):
        _plane(axes, palette, -3.1, 3.1, -3.1, 3.1)
        axes.set_title(title, fontsize=10)
        axes.plot(*(circle @ matrix.T).T, color=palette.truth, lw=1.6)
        _flag(axes, matrix, palette.second)
        for axis, colour in zip(rotation_matrix(found.first), (palette.estimate, palette.measure), strict=True):
            _arrow(axes, matrix @ axis, colour)


def draw_ellipse(figure: Figure, palette: Palette) -> None:
    """A cloud drawn from a covariance, and its ellipses at one and two standard deviations."""
    axes = figure.subplots()
    variances, directions = np.linalg.eigh(COVARIANCE)
    cloud = np.random.default_rng(4).multivariate_normal((0, 0), COVARIANCE, 400)
    axes.scatter(*cloud.T, s=9, color=palette.measure, alpha=0.55, linewidths=0, zorder=2)
    for sigmas in (1, 2):
        width, height = 2 * sigmas * np.sqrt(variances[::-1])
        axes.add_patch(
            Ellipse((0, 0), float(width), float(height), angle=45, fill=False, color=palette.estimate, lw=2, zorder=4)
        )
    for variance, direction in zip(variances, directions.T, strict=True):
        _arrow(axes, np.sqrt(variance) * direction * np.sign(direction[1]), palette.truth)
    for x, y, text in ((3.1, 0.6, "√8 ≈ 2,83"), (-2.6, 2.2, "√2 ≈ 1,41")):
        box = {"facecolor": palette.paper, "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
        axes.text(x, y, text, color=palette.truth, fontsize=11, ha="center", bbox=box, zorder=6)
    axes.set(xlim=(-8, 8), ylim=(-6.6, 6.6), aspect="equal", xlabel="x", ylabel="y")


def draw_gradient(figure: Figure, palette: Palette) -> None:
    """Level lines of a sum of squares, and gradients that cross them at a right angle."""
    axes = figure.subplots()
    x, y = np.meshgrid(np.linspace(-0.5, 0.7, 121), np.linspace(-0.4, 0.8, 121))
    axes.contour(x, y, valley(x, y), levels=[0.04, 0.08, 0.16, 0.3, 0.5, 0.8], colors=palette.truth, linewidths=1.1)
    for point in ((-0.3, 0.1), (0.1, -0.2), (0.45, 0.15), (0.1, 0.5), (0.45, 0.5), (-0.15, 0.35), (0.0, 0.0)):
        start = np.array(point)
        colour = palette.alert if point == (0.0, 0.0) else palette.estimate
        axes.plot(*start, "o", color=colour, ms=4)
        _arrow(axes, start + 0.08 * slope(*point), colour, start)
    axes.plot([0.1], [0.2], "o", color=palette.measure, ms=9)
    axes.text(0.13, 0.17, "minimum", color=palette.measure, fontsize=10, va="top")
    axes.set(xlim=(-0.5, 0.7), ylim=(-0.4, 0.8), aspect="equal", xlabel="x", ylabel="y")


def draw_turn(figure: Figure, palette: Palette) -> None:
    """Multiplying by cos + i sin turns a number around zero without changing its length."""
    axes = figure.subplots()
    _plane(axes, palette, -2.4, 2.9, -1.2, 2.5)
    z, turn = 2 + 1j, 0.6 + 0.8j
    for number, colour, text, (x, y) in (
        (turn, palette.measure, "0,6 + 0,8 i", (-0.12, 1.1)),
        (z, palette.truth, "2 + i", (2.08, 0.98)),
        (turn * z, palette.estimate, "0,4 + 2,2 i", (0.5, 2.3)),
    ):
        _arrow(axes, np.array([number.real, number.imag]), colour)
        axes.text(x, y, text, color=colour, fontsize=11, ha="right" if x < 0 else "left")
    angles = np.linspace(0, 2 * np.pi, 200)
    for radius, colour in ((1.0, palette.measure), (abs(z), palette.faint)):
        axes.plot(radius * np.cos(angles), radius * np.sin(angles), color=colour, lw=1, ls=(0, (4, 3)))
    swept = np.linspace(np.angle(z), np.angle(turn * z), 40)
    axes.plot(1.5 * np.cos(swept), 1.5 * np.sin(swept), color=palette.estimate, lw=1.6)
    axes.text(1.12, 1.3, "53,1°", color=palette.estimate, fontsize=10)


def draw_logarithm(figure: Figure, palette: Palette) -> None:
    """A product of likelihoods that no computer can hold, and the sum of logarithms that it can."""
    above, below = figure.subplots(2, 1, sharex=True)
    counts = np.arange(361)
    with np.errstate(under="ignore"):
        products = np.cumprod(np.concatenate([[1.0], np.full(360, 0.1)]))
    held = products > 0
    above.semilogy(counts[held], products[held], color=palette.truth, lw=2.2)
    above.axvline(counts[held][-1], color=palette.alert, lw=1.2, ls=(0, (4, 3)))
    above.text(counts[held][-1] + 5, 1e-140, "ensuite :\nzéro", color=palette.alert, fontsize=10)
    above.set_ylabel("produit")
    above.set_yticks([1, 1e-100, 1e-200, 1e-300])
    below.plot(counts, counts * np.log(0.1), color=palette.measure, lw=2.2)
    below.set(xlabel="nombre de rayons", ylabel="somme des ln", xlim=(0, 380))


FIGURES = {
    "outil-produit": (
        draw_product,
        "Un petit drapeau, au départ debout. Étiré en largeur puis tourné d'un quart de tour, il est couché et long "
        "vers le haut. Tourné puis étiré en largeur, il est couché et sa hampe est deux fois plus longue : les deux "
        "résultats diffèrent.",
        (6.4, 1.9),
    ),
    "outil-trace": (
        draw_trace,
        "La trace de R H selon l'angle de R, entre -180 et 180 degrés : une sinusoïde. Elle vaut 4 à l'angle nul, et "
        "atteint son maximum, 5, à 36,9 degrés.",
        (5.8, 3.4),
    ),
    "outil-svd": (
        draw_svd,
        "Un cercle et un petit drapeau, en quatre dessins. D'abord tels quels, avec deux flèches en diagonale ; puis "
        "tournés de 45 degrés, si bien que les flèches sont sur les axes ; puis étirés, le cercle devenant une ellipse "
        "couchée ; puis tournés d'un quart de tour, l'ellipse étant debout.",
        (5.2, 5.4),
    ),
    "outil-ellipse": (
        draw_ellipse,
        "Quatre cents points en nuage allongé selon la diagonale qui monte, et deux ellipses de mêmes axes, à un et "
        "deux écarts-types. Deux flèches en donnent les demi-axes : 2,83 le long de la diagonale, 1,41 en travers.",
        (5.8, 4.6),
    ),
    "outil-gradient": (
        draw_gradient,
        "Les lignes de niveau d'une somme de carrés : des ellipses emboîtées autour du minimum, en (0,1 ; 0,2). En "
        "sept points, une flèche perpendiculaire à la ligne de niveau pointe vers l'extérieur ; celle de l'origine "
        "pointe droit vers le bas.",
        (5.4, 5.0),
    ),
    "outil-complexe": (
        draw_turn,
        "Le plan complexe. Le nombre 0,6 + 0,8 i est sur le cercle de rayon 1. En multipliant 2 + i par lui, on "
        "obtient 0,4 + 2,2 i, sur le même cercle que 2 + i, tourné de 53,1 degrés.",
        (5.2, 4.2),
    ),
    "outil-logarithme": (
        draw_logarithm,
        "En haut, le produit de vraisemblances égales à 0,1, en échelle logarithmique : une droite qui s'arrête à 323 "
        "rayons, après quoi l'ordinateur rend zéro. En bas, la somme des logarithmes, une droite qui descend "
        "tranquillement jusqu'à -829 pour 360 rayons.",
        (5.8, 4.2),
    ),
}
