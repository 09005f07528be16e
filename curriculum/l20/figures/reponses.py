"""Drawings of the folded answers: what a reader's own change of a cell draws."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from curriculum.l20.figures._plan import RANGE, draw_impacts, french, module_map, ray_ends
from graders.plotting import Palette
from reference.registration import icp
from reference.se2 import compose, inverse, transform
from reference.world.scan import full_turn_angles

Floats = NDArray[np.float64]

VIEWS = (
    ("la pose de départ", (8.6, 7.4, 0.35)),
    ("un quart de tour de plus", (8.6, 7.4, 1.92)),
    ("une case plus loin", (9.6, 7.4, 0.35)),
)


def draw_turned_scans(figure: Figure, palette: Palette) -> None:
    """The same scan, then turned, then taken elsewhere, as the robot sees them: ahead is up."""
    figure.set_size_inches(6.4, 2.9)
    for k, (title, pose) in enumerate(VIEWS):
        axes = figure.add_subplot(1, 3, k + 1, projection="polar")
        ranges = module_map().cast_scans([pose], full_turn_angles(72), RANGE)[0]
        axes.plot(full_turn_angles(72), ranges, "o", color=palette.measure, ms=3)
        axes.set_theta_zero_location("N")  # type: ignore[attr-defined]
        axes.set_theta_direction(-1)  # type: ignore[attr-defined]
        axes.set(xticks=np.arange(0, 2 * np.pi, np.pi / 2), xticklabels=[], ylim=(0, RANGE), yticks=[4, 8, 12])
        axes.tick_params(labelsize=8)
        axes.set_title(title, fontsize=10)


DOORS = (0, 1, 0, 0, 1, 1, 0, 0, 0, 1)
CORRIDORS = (
    ("porte, porte, mur, mur", DOORS, (1, 1, 0, 0), 0.8),
    ("dernière lecture : porte", DOORS, (1, 1, 0, 1), 0.8),
    ("sans la porte 4", (0, 1, 0, 0, 0, 1, 0, 0, 0, 1), (1, 1, 0, 0), 0.8),
    ("capteur qui répond au hasard", DOORS, (1, 1, 0, 0), 0.5),
)


def corridor(doors: tuple[int, ...], readings: tuple[int, ...], trust: float) -> Floats:
    """The belief after the readings, one step to the right between two of them."""
    belief = np.full(len(doors), 1.0 / len(doors))
    for k, reading in enumerate(readings):
        if k:
            moved = np.roll(belief, 1)
            moved[0] = 0.0
            moved[-1] += belief[-1]
            belief = 0.2 * belief + 0.8 * moved
        belief = belief * np.where(np.array(doors) == reading, trust, 1.0 - trust)
        belief /= belief.sum()
    return belief


def draw_corridors(figure: Figure, palette: Palette) -> None:
    """The last belief, as the cell has it and with each change."""
    figure.set_size_inches(6.4, 4.2)
    for axes, (title, *case) in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, CORRIDORS, strict=True):
        belief = corridor(*case)
        colours = [palette.second if door else palette.estimate for door in case[0]]
        axes.bar(range(10), belief, color=colours)
        best = int(belief.argmax())
        axes.annotate(french(float(belief[best]), 3), (best, belief[best]), ha="center", va="bottom", fontsize=9)
        axes.set(title=title, ylim=(0, 0.52), xticks=range(10), yticks=[0, 0.2, 0.4])
        axes.set_yticklabels(["0", "0,2", "0,4"])
        axes.title.set_fontsize(10)
    figure.supxlabel("case", fontsize=10)


ROOM = (11.5, 3.5, 0.0)
BESIDE = (12.7, 4.1, 0.3)
STARTS = (0.0, 1.5, -1.0)


def room_clouds() -> tuple[Floats, Floats]:
    """Points of two scans of a room, each in the frame of its robot: (n, 2) and (m, 2)."""
    clouds = []
    for pose in (ROOM, BESIDE):
        ranges = module_map().cast_scans([pose], full_turn_angles(120), RANGE)[0]
        clouds.append(ray_ends((0.0, 0.0, 0.0), ranges)[ranges < RANGE])
    return clouds[0], clouds[1]


def settled(start: float) -> Floats:
    """Where ICP ends from this angle, (x, y, theta)."""
    first, second = room_clouds()
    return icp(second, first, np.array([0.0, 0.0, start]), max_iterations=40, tolerance=0.0).T_q_p


def draw_three_ends(figure: Figure, palette: Palette) -> None:
    """The two scans, laid on each other from three starts: the right way, and two wrong ones."""
    figure.set_size_inches(6.4, 2.9)
    first, second = room_clouds()
    for axes, start in zip(figure.subplots(1, 3, sharex=True, sharey=True), STARTS, strict=True):
        end = settled(start)
        draw_impacts(axes, first, palette.truth, 9)
        draw_impacts(axes, transform(end, second), palette.estimate, 9)
        axes.set(aspect="equal", xticks=[], yticks=[])
        axes.invert_yaxis()
        axes.set_title(f"départ {french(start)} rad\narrivée {french(float(end[2]), 2)} rad", fontsize=10)


def draw_bent_corridors(figure: Figure, palette: Palette) -> None:
    """Scans taken along a straight corridor, drawn where a heading that drifts believes they were."""
    figure.set_size_inches(6.0, 4.6)
    xs = np.linspace(2, 20, 13)
    taken = module_map().cast_scans([(x, 8.0, 0.0) for x in xs], full_turn_angles(90), RANGE)
    for axes, drift in zip(figure.subplots(2, 1, sharex=True), (0.05, -0.05), strict=True):
        for k, (x, ranges) in enumerate(zip(xs, taken, strict=True)):
            believed = (x, 8.0 + (x - 2.0) * drift * k / 2.0, drift * k)
            draw_impacts(axes, ray_ends(believed, ranges)[ranges < RANGE], palette.measure, 3)
            axes.plot(*believed[:2], "o", color=palette.estimate, ms=4)
        axes.set(aspect="equal", xticks=[], yticks=[])
        axes.invert_yaxis()
        axes.set_title(f"dérive de {french(drift, 2)} rad par pas", fontsize=10)


def corrected(every: int) -> Floats:
    """The robot's way (100, 2) in the map's frame, its odometry put right each so many steps."""
    step, biased = (0.1, 0.0, 0.0), (0.1, 0.0, 0.006)
    true, odometry, correction = np.zeros(3), np.zeros(3), np.zeros(3)
    way = []
    for k in range(100):
        true, odometry = compose(true, np.array(step)), compose(odometry, np.array(biased))
        if k % every == every - 1:
            correction = compose(true, inverse(odometry))
        way.append(compose(correction, odometry)[:2])
    return np.array(way)


def draw_corrections(figure: Figure, palette: Palette) -> None:
    """The same way, put right each twenty steps, each ten, each five."""
    figure.set_size_inches(6.4, 3.2)
    axes: Axes = figure.subplots()
    for every, colour in ((20, palette.estimate), (10, palette.second), (5, palette.measure)):
        x, y = corrected(every).T
        axes.plot(x, 100 * y, color=colour, label=f"tous les {every} pas")
    axes.axhline(0.0, color=palette.ink, lw=0.8)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("écart (cm)")
    axes.set_ylim(-0.5, 13)
    axes.legend(fontsize=9, ncols=3, loc="upper center")


FIGURES = {
    "reponse-scan": (
        draw_turned_scans,
        "Trois scans en coordonnées polaires, droit devant en haut. Le deuxième est le premier, tourné d'un quart de "
        "tour. Le troisième, pris une case plus loin, n'a plus la même forme.",
        (6.4, 2.9),
    ),
    "reponse-couloir": (
        draw_corridors,
        "Quatre diagrammes de la dernière croyance sur dix cases. Avec porte, porte, mur, mur, la case 7 l'emporte. "
        "Avec une porte à la fin, c'est la case 9. Sans la porte 4, les cases 3 et 7 sont à égalité. "
        "Avec un capteur au hasard, la case 9 grandit seule, au bout du couloir.",
        (6.4, 4.2),
    ),
    "reponse-icp": (
        draw_three_ends,
        "Deux nuages de points d'une même pièce, superposés par ICP. Depuis 0 radian, ils se confondent. Depuis 1,5 "
        "et depuis −1 radian, ils restent de travers l'un sur l'autre.",
        (6.4, 2.9),
    ),
    "reponse-derives": (
        draw_bent_corridors,
        "Un couloir droit, dessiné deux fois par un robot dont le cap dérive. Avec une dérive positive, il se courbe "
        "vers le bas ; avec une dérive négative, vers le haut. Ses deux murs restent presque parallèles.",
        (6.0, 4.6),
    ),
    "reponse-reperes": (
        draw_corrections,
        "Trois courbes en dents de scie : l'écart de côté le long du trajet. Corrigé tous les vingt pas, il monte "
        "jusqu'à dix centimètres avant chaque correction ; tous les dix, à deux ; tous les cinq, il se voit à peine.",
        (6.4, 3.2),
    ),
}
