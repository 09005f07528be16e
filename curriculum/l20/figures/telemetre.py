"""Drawings of the course on the likelihood of a range finder: a mixture, a passer-by, rays that are no strangers."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from curriculum.l20.figures._plan import (
    RANGE,
    draw_impacts,
    draw_robot,
    draw_walls,
    french,
    mark_axes,
    module_map,
    ray_ends,
)
from graders.plotting import Palette
from reference.world.grid_map import GridMap
from reference.world.scan import full_turn_angles
from reference.world.simulation import SimulatedLidar

Floats = NDArray[np.float64]

HIT, SHORT, BEYOND, STRAY = 0.7, 0.1, 0.1, 0.1
SIGMA, RATE = 0.2, 0.5


def bell(z: Floats, expected: Floats | float, sigma: float = SIGMA) -> Floats:
    """The Gaussian density of z around what was expected."""
    return np.asarray(np.exp(-0.5 * ((z - expected) / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi)))


def mixture(z: Floats, expected: Floats | float) -> Floats:
    """The formula of the course, neither truncated nor normalised."""
    short = RATE * np.exp(-RATE * z) * (z <= expected)
    return np.asarray(HIT * bell(z, expected) + SHORT * short + BEYOND * (z >= RANGE) + STRAY / RANGE)


def draw_mixture(figure: Figure, palette: Palette) -> None:
    """The four causes of a reading when 5 is expected, each with its share, and their sum."""
    figure.set_size_inches(5.8, 4.0)
    axes = figure.subplots()
    z = np.linspace(0.0, 11.99, 1200)
    stray = np.full_like(z, STRAY / RANGE)
    short = stray + SHORT * RATE * np.exp(-RATE * z) * (z <= 5.0)
    total = short + HIT * bell(z, 5.0)
    axes.fill_between(z, stray, color=palette.second, alpha=0.65, lw=0)
    axes.fill_between(z, stray, short, color=palette.estimate, alpha=0.65, lw=0)
    axes.fill_between(z, short, total, color=palette.measure, alpha=0.65, lw=0)
    axes.plot(z, total, color=palette.ink, lw=1.3)
    axes.vlines(12.0, 1e-4, BEYOND + STRAY / RANGE, color=palette.alert, lw=5)
    labels = (
        (5.6, 0.55, "bon écho : 0,7", palette.measure, "left"),
        (0.15, 0.11, "objet imprévu : 0,1", palette.estimate, "left"),
        (11.7, 0.17, "rien vu : 0,1", palette.alert, "right"),
        (8.5, 0.0125, "n’importe quoi : 0,1", palette.second, "center"),
    )
    for x, y, text, colour, side in labels:
        axes.text(x, y, text, color=colour, fontsize=11, ha=side, weight="bold")
    axes.set(yscale="log", ylim=(4e-3, 2.2), xlim=(0, 12.4), xticks=[0, 5, 12])
    axes.set_yticks([0.01, 0.1, 1.0], ["0,01", "0,1", "1"])
    axes.minorticks_off()
    axes.set_xlabel("distance lue z (attendue : 5 ; portée : 12)")
    axes.set_ylabel("p(z), échelle logarithmique")


def draw_penalty(figure: Figure, palette: Palette) -> None:
    """What one ray costs, in natural logarithms: without bound for the Gaussian, bounded for the mixture."""
    figure.set_size_inches(5.8, 3.8)
    axes = figure.subplots()
    z = np.linspace(0.0, 11.99, 1500)
    peak = float(np.log(mixture(np.array(5.0), 5.0)))
    axes.plot(z, 0.5 * ((z - 5.0) / SIGMA) ** 2, color=palette.alert, lw=2.6, label="gaussienne seule")
    axes.plot(z, peak - np.log(mixture(z, 5.0)), color=palette.measure, lw=2.6, label="mélange de quatre causes")
    axes.axhline(peak - np.log(STRAY / RANGE), color=palette.ink, lw=1.0, ls=":")
    axes.text(11.9, peak - np.log(STRAY / RANGE) + 0.45, "plafond : 5,13", ha="right", fontsize=10.5)
    axes.set(
        ylim=(0, 20),
        xlim=(0, 12),
        yticks=[0, 5, 10, 15, 20],
        xlabel="distance lue z (on attendait 5)",
        ylabel="pénalité d’un rayon",
    )
    figure.legend(loc="outside lower center", ncols=2, fontsize=10.5)


TRUTH = (8.5, 8.0, 0.0)
PASSER_BY = (slice(7, 9), 11)


@cache
def passer_by_scan() -> tuple[Floats, NDArray[np.bool_]]:
    """36 readings with somebody in the corridor who is not on the map, and which of the rays they stopped."""
    free = module_map().free.copy()
    free[PASSER_BY] = False
    angles = full_turn_angles(36)
    seen, mapped = (world.cast_scans([TRUTH], angles, RANGE)[0] for world in (GridMap.from_free(free), module_map()))
    read = SimulatedLidar.full_turn(36, RANGE, SIGMA).add_noise(seen, np.random.default_rng(4))
    return read, seen < mapped - 1e-9


@cache
def candidates() -> tuple[Floats, Floats]:
    """Poses every half cell and every 15 degrees on free cells, the true one among them, and what they should see."""
    y, x = (part.ravel() + 0.5 for part in np.mgrid[0:15.5:0.5, 0:23.5:0.5])
    places = np.column_stack([x, y])[module_map().is_free(np.column_stack([x, y]))]
    headings = 2.0 * np.pi * np.arange(24) / 24
    poses = np.column_stack([np.repeat(places, 24, axis=0), np.tile(headings, len(places))])
    return poses, module_map().cast_scans(poses, full_turn_angles(36), RANGE)


def favourites() -> dict[str, tuple[Floats, float]]:
    """For each model, the pose that it likes best, and by how many nats more than the true one."""
    ranges, _ = passer_by_scan()
    poses, expected = candidates()
    true = module_map().cast_scans([TRUTH], full_turn_angles(36), RANGE)
    best = {}
    for name, model in (("gaussienne", bell_log), ("mélange", mixture_log)):
        scores = model(ranges, expected)
        best[name] = (poses[int(np.argmax(scores))], float(scores.max() - model(ranges, true)[0]))
    return best


def bell_log(ranges: Floats, expected: Floats) -> Floats:
    """The naive log likelihood, up to its constant: it would underflow otherwise."""
    return np.asarray(-0.5 * np.sum(((ranges - expected) / SIGMA) ** 2, axis=1))


def mixture_log(ranges: Floats, expected: Floats) -> Floats:
    """The log likelihood of the mixture."""
    return np.asarray(np.sum(np.log(mixture(ranges, expected)), axis=1))


def draw_passer_by(figure: Figure, palette: Palette) -> None:
    """Five rays stopped by somebody, and where the naive model would rather have the robot."""
    figure.set_size_inches(5.8, 4.05)
    axes = figure.subplots()
    ranges, stopped = passer_by_scan()
    draw_walls(axes, palette, module_map(), 0.45)
    for end, blocked in zip(ray_ends(TRUTH, ranges), stopped, strict=True):
        colour = palette.alert if blocked else palette.measure
        axes.plot(
            [TRUTH[0], end[0]], [TRUTH[1], end[1]], color=colour, lw=2.0 if blocked else 0.9, alpha=0.75, zorder=4
        )
    axes.fill_between([11, 12], 7, 9, color=palette.alert, alpha=0.35, lw=0, zorder=1)
    axes.text(12.3, 7.75, "passant", color=palette.alert, fontsize=11, weight="bold", va="center")
    draw_robot(axes, TRUTH, palette.truth, palette)
    wrong, gap = favourites()["gaussienne"]
    draw_robot(axes, wrong, palette.alert, palette)
    draw_impacts(axes, ray_ends(wrong, ranges)[ranges < RANGE], palette.alert, 9)
    axes.set_title(f"La pose rouge serait $e^{{{gap:.0f}}}$ fois plus vraisemblable", fontsize=12)


def draw_correlated(figure: Figure, palette: Palette) -> None:
    """How far off an estimate really is, and how far off the product of independent rays believes it to be."""
    figure.set_size_inches(5.8, 4.0)
    axes = figure.subplots()
    own, shared = 10.0, 5.0
    x = np.linspace(-16.0, 16.0, 801)
    real = float(np.hypot(shared, own / np.sqrt(360)))
    laws = (
        (real, palette.truth, f"erreur réelle : ± {french(real)} cm"),
        (own / np.sqrt(360), palette.alert, f"annoncée, 360 rayons : ± {french(own / np.sqrt(360))} cm"),
        (own / np.sqrt(30), palette.estimate, f"annoncée, 30 rayons : ± {french(own / np.sqrt(30))} cm"),
    )
    for sigma, colour, name in laws:
        curve = np.exp(-0.5 * (x / sigma) ** 2)
        axes.plot(x, curve, color=colour, lw=2.4, label=name)
        if colour == palette.truth:
            axes.fill_between(x, curve, color=colour, alpha=0.18, lw=0)
    axes.set(xlim=(-16, 16), ylim=(0, 1.05), yticks=[], xlabel="erreur sur la position (cm)")
    axes.spines["left"].set_visible(False)
    figure.legend(loc="outside lower center", ncols=1, fontsize=10.5)


FINE = 8


@cache
def fine_map() -> GridMap:
    """The module's map with eight cells where there was one."""
    return GridMap.from_free(np.kron(module_map().free, np.ones((FINE, FINE), dtype=np.bool_)), 1.0 / FINE)


def draw_field(figure: Figure, palette: Palette) -> None:
    """The distance to the nearest wall, and the ends of a scan laid on it from a pose a little off."""
    figure.set_size_inches(5.8, 4.05)
    axes = figure.subplots()
    field = fine_map().distances_to_wall
    nearness = np.ma.masked_where(fine_map().occupied, np.exp(-0.5 * (field / 0.6) ** 2))
    axes.imshow(
        nearness, cmap=palette.ramp, vmin=0, vmax=1.25, extent=(0, 24, 16, 0), interpolation="nearest", zorder=1
    )
    draw_walls(axes, palette, module_map(), 0.9)
    mark_axes(axes, palette)
    ranges = module_map().cast_scans([TRUTH], full_turn_angles(72), RANGE)[0]
    pose = (8.9, 7.8, 0.12)
    points = ray_ends(pose, ranges)[ranges < RANGE]
    axes.scatter(*points.T, s=26, color=palette.measure, edgecolors=palette.paper, linewidths=0.7, zorder=6)
    draw_robot(axes, pose, palette.estimate, palette)
    axes.set_title("Plus la couleur est forte, plus un mur est proche", fontsize=11)


FIGURES = {
    "melange-faisceau": (
        draw_mixture,
        "La densité d’une lecture quand on attend 5 : un pic autour de 5, une part d’objets imprévus qui décroît avant "
        "5, un fond constant, et un bâton à la portée maximale.",
        (5.8, 4.0),
    ),
    "penalite-bornee": (
        draw_penalty,
        "La pénalité d’un rayon selon la distance lue : une parabole sans limite pour la gaussienne, une courbe qui "
        "plafonne vers 5 pour le mélange.",
        (5.8, 3.8),
    ),
    "passant": (
        draw_passer_by,
        "Dans le couloir, cinq des 36 rayons du robot sont arrêtés par un passant absent de la carte. Le modèle "
        "gaussien place le robot ailleurs, où presque aucun impact ne tombe sur un mur.",
        (5.8, 4.05),
    ),
    "rayons-correles": (
        draw_correlated,
        "Trois cloches centrées en zéro : l’erreur réelle, large de 5 centimètres, et celles qu’annoncent 360 rayons "
        "ou 30 rayons supposés indépendants, bien plus étroites.",
        (5.8, 4.0),
    ),
    "champ-vraisemblance": (
        draw_field,
        "La carte colorée selon la distance au mur le plus proche, et les impacts d’un scan posés dessus depuis une "
        "pose un peu fausse : certains tombent sur un mur, d’autres à côté.",
        (5.8, 4.05),
    ),
}
