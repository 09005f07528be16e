"""Drawings of the course on the Bayes filter: one equation, and what each representation of a belief keeps of it."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray
from scipy.special import ndtr

from curriculum.l20.figures._plan import french
from graders.plotting import Palette
from reference.filters.corridor import Corridor
from reference.filters.histogram import HistogramFilter
from reference.filters.unscented import SigmaPoints, UnscentedParameters

Floats = NDArray[np.float64]

# The example of the lesson: x = 2 ± 1 m, a move of 3 ± 0.5 m, then a range of 4.4 ± 0.5 m to a wall at 10 m.
PRIOR = (2.0, 1.0)
PREDICTED = (5.0, float(np.sqrt(1.25)))
LIKELIHOOD = (5.6, 0.5)
POSTERIOR = (5.5, float(np.sqrt(0.25 / 1.2)))


def _bell(x: Floats, law: tuple[float, float]) -> Floats:
    mean, sigma = law
    return np.asarray(np.exp(-0.5 * ((x - mean) / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi)))


def draw_two_steps(figure: Figure, palette: Palette) -> None:
    """Above, the belief moves and spreads; below, a measurement concentrates it."""
    figure.set_size_inches(5.8, 4.4)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.7])
    x = np.linspace(-1.5, 9.5, 400)
    curves = (
        (above, PRIOR, palette.faint, "avant : 2 ± 1", (2.0, 0.44), "center"),
        (above, PREDICTED, palette.estimate, "prédite : 5 ± 1,12", (6.1, 0.36), "left"),
        (below, PREDICTED, palette.estimate, "prédite", (3.0, 0.26), "right"),
        (below, LIKELIHOOD, palette.measure, "vraisemblance", (6.25, 0.6), "left"),
        (below, POSTERIOR, palette.truth, "corrigée : 5,5 ± 0,46", (4.9, 0.86), "right"),
    )
    for axes, law, colour, name, (left, height), side in curves:
        axes.plot(x, _bell(x, law), color=colour, lw=2.4)
        axes.fill_between(x, _bell(x, law), color=colour, alpha=0.16, lw=0)
        shade = palette.ink if colour == palette.faint else colour
        axes.text(left, height, name, color=shade, fontsize=10.5, ha=side)
    above.annotate(
        "", xy=(4.7, 0.2), xytext=(2.5, 0.2), arrowprops={"arrowstyle": "-|>", "color": palette.ink, "lw": 1.6}
    )
    above.set_title("Prédire : la bosse avance et s’étale", loc="left")
    below.set_title("Corriger : la bosse se resserre", loc="left")
    for axes, top in ((above, 0.56), (below, 0.98)):
        axes.set(yticks=[], ylim=(0, top), xlim=(-1.5, 9.5))
        axes.spines["left"].set_visible(False)
        axes.grid(False)
    below.set_xlabel("position dans le couloir (m)")


@cache
def doors_belief() -> tuple[Floats, Floats]:
    """Cells of 10 cm and the belief of a robot that drove 4 m, with a door at the start and at the end."""
    corridor = Corridor(length=30.0, doors=(3.5, 7.5, 15.5), motion_sigma=0.4)
    histogram = HistogramFilter(corridor.door_model(), np.linspace(0.0, 30.0, 301))
    histogram.correct(True)
    histogram.predict(np.array([4.0]))
    histogram.correct(True)
    return histogram.centres, histogram.belief


def draw_representations(figure: Figure, palette: Palette) -> None:
    """One belief with several bumps, kept as a Gaussian, as a grid, and as particles."""
    figure.set_size_inches(5.8, 5.6)
    x, belief = doors_belief()
    density = belief / (x[1] - x[0])
    mean = float(belief @ x)
    sigma = float(np.sqrt(belief @ (x - mean) ** 2))
    titles = (
        f"Une gaussienne : deux nombres ({french(mean)} ; {french(sigma)})",
        "Une grille : vingt nombres",
        "Des particules : cent positions",
    )
    panels = figure.subplots(3, 1, sharex=True, sharey=True)
    for axes, title in zip(panels, titles, strict=True):
        axes.fill_between(x, density, color=palette.truth, alpha=0.22, lw=0)
        axes.plot(x, density, color=palette.truth, lw=1.2, alpha=0.8)
        axes.set_title(title, loc="left", fontsize=11)
        axes.set(yticks=[], ylim=(0, 1.05 * float(density.max())), xlim=(0, 20))
        axes.spines["left"].set_visible(False)
        axes.grid(False)
    panels[0].plot(x, _bell(x, (mean, sigma)), color=palette.alert, lw=2.4)
    panels[1].bar(
        np.arange(20) + 0.5, belief.reshape(30, 10).sum(axis=1)[:20], width=0.9, color=palette.estimate, alpha=0.75
    )
    particles = np.interp((np.arange(100) + 0.5) / 100, np.cumsum(belief), x)
    panels[2].vlines(particles, 0, 0.18 * density.max(), color=palette.estimate, lw=1.4)
    panels[2].set_xticks([0, 5, 10, 15, 20])
    panels[2].set_xlabel("position dans le couloir (m)")


def draw_three_filters(figure: Figure, palette: Palette) -> None:
    """The same question answered by Kalman, by a grid of half metres, and by a hundred particles."""
    figure.set_size_inches(5.8, 3.8)
    axes = figure.subplots()
    edges = np.arange(0.0, 10.25, 0.5)
    centres = 0.5 * (edges[:-1] + edges[1:])
    prior = np.diff(ndtr((edges - PRIOR[0]) / PRIOR[1]))
    moves = np.diff(ndtr((edges[None, :] - centres[:, None] - 3.0) / 0.5), axis=1)
    grid = (prior @ moves) * _bell(centres, LIKELIHOOD)
    rng = np.random.default_rng(2)
    particles = rng.normal(*PRIOR, 100) + rng.normal(3.0, 0.5, 100)
    weights = _bell(particles, LIKELIHOOD)
    x = np.linspace(2.5, 8.5, 300)
    axes.bar(centres, grid / grid.sum() / 0.5, width=0.46, color=palette.second, alpha=0.45, label="grille de 0,5 m")
    axes.plot(x, _bell(x, POSTERIOR), color=palette.truth, lw=2.6, label="Kalman")
    axes.vlines(
        particles,
        0,
        -0.30 * weights / weights.max(),
        color=palette.estimate,
        lw=1.6,
        label="particules (longueur : le poids)",
    )
    axes.axhline(0, color=palette.ink, lw=0.8)
    axes.set(xlim=(2.5, 8.5), ylim=(-0.34, 0.95), yticks=[], xlabel="position dans le couloir (m)")
    axes.spines["left"].set_visible(False)
    axes.grid(False)
    figure.legend(loc="outside lower center", ncols=2, fontsize=10)


RANGE_LAW, BEARING_LAW = (10.0, 0.3), (np.pi / 2.0, float(np.deg2rad(25.0)))


def _to_plane(polar: Floats) -> Floats:
    return np.column_stack([polar[:, 0] * np.cos(polar[:, 1]), polar[:, 0] * np.sin(polar[:, 1])])


def unscented_moments() -> tuple[Floats, Floats, Floats]:
    """The images of the sigma points, their mean and their covariance."""
    variances = np.diag([RANGE_LAW[1] ** 2, BEARING_LAW[1] ** 2])
    means, spread = np.array([RANGE_LAW[0], BEARING_LAW[0]]), UnscentedParameters(1.0, 0.0, 1.0)
    sigma = SigmaPoints.from_gaussian(means, variances, spread)
    images = _to_plane(sigma.points)
    mean = sigma.mean_weights @ images
    away = images - mean
    return images, mean, away.T @ (sigma.covariance_weights[:, None] * away)


def draw_banana(figure: Figure, palette: Palette) -> None:
    """A beacon at 10 ± 0.3 m, within 25 degrees: the truth, its tangent at the mean (EKF), and sigma points (UKF)."""
    figure.set_size_inches(5.8, 3.9)
    axes = figure.subplots()
    rng = np.random.default_rng(5)
    points = _to_plane(np.column_stack([rng.normal(*RANGE_LAW, 700), rng.normal(*BEARING_LAW, 700)]))
    axes.scatter(*points.T, s=7, color=palette.truth, alpha=0.4, linewidths=0)
    images, mean, covariance = unscented_moments()
    tangent = np.diag([(RANGE_LAW[0] * BEARING_LAW[1]) ** 2, RANGE_LAW[1] ** 2])
    laws = (
        (np.array([0.0, RANGE_LAW[0]]), tangent, palette.alert, "EKF", (8.0, 10.5)),
        (mean, covariance, palette.estimate, "UKF", (7.2, 7.2)),
    )
    for centre, spread, colour, name, place in laws:
        width, height = 4.0 * np.sqrt(np.diag(spread))
        axes.add_patch(Ellipse((centre[0], centre[1]), width, height, fill=False, edgecolor=colour, lw=2.4))
        axes.plot(*centre, "+", ms=13, mew=2.6, color=colour)
        axes.text(*place, name, color=colour, fontsize=12, weight="bold")
    axes.plot(*images.T, "s", ms=6, color=palette.estimate, mec=palette.paper, mew=1.0)
    axes.plot(*points.mean(axis=0), "o", ms=8, mfc="none", mec=palette.ink, mew=2.0)
    axes.plot(0, 0, "^", ms=11, color=palette.ink)
    axes.text(0.6, 0.0, "robot", fontsize=10.5, va="center")
    axes.set(xlim=(-10.5, 10.5), ylim=(-0.8, 12.4), aspect="equal", xticks=[-10, -5, 0, 5, 10], yticks=[0, 5, 10])


FIGURES = {
    "prediction-correction": (
        draw_two_steps,
        "En haut, une cloche étroite en 2 m devient une cloche plus large en 5 m. En bas, cette cloche large, "
        "multipliée par la vraisemblance centrée en 5,6 m, donne une cloche étroite en 5,5 m.",
        (5.8, 4.4),
    ),
    "representations": (
        draw_representations,
        "Une même croyance, concentrée sur une porte avec trois bosses plus faibles, représentée trois fois : une "
        "cloche unique et très large, vingt barres, cent traits de particules. Seule la cloche perd les bosses.",
        (5.8, 5.6),
    ),
    "trois-filtres": (
        draw_three_filters,
        "Le résultat du même exemple par trois filtres : la cloche de Kalman centrée en 5,5 m, les barres d’une grille "
        "de 50 cm qui la suivent, et cent particules dont les poids grandissent sous la cloche.",
        (5.8, 3.8),
    ),
    "banane": (
        draw_banana,
        "Des points en croissant, à dix mètres du robot. L’ellipse de l’EKF, tangente, dépasse le croissant par les "
        "côtés et place sa moyenne trop loin ; celle de l’UKF descend et englobe le croissant, moyenne presque exacte.",
        (5.8, 3.9),
    ),
}
