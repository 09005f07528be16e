"""The scenes, from one obstacle in the middle of 36 beams to a drive towards a wall.

Judged obstacles stand at least two beams inside the window, or three outside; a scan that must not stop the robot has
all its near readings outside or none, and most beams of the window have read something.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Floats
from graders.l20.noeud_ros.scenes import HALF, MARGIN, Phase, Scene, phase

Rng = np.random.Generator
Drawing = Callable[[Rng], Iterator[Scene]]
FAR = 5.0
INF, NAN = math.inf, math.nan
#: No judged reading is nearer than that to a bound.
APART = 1e-3


def beams(count: int, near: dict[int, float] | None = None, *, far: float = FAR) -> Floats:
    """A scan that reads `far` everywhere but at some beams."""
    ranges = np.full(count, far)
    for beam, distance in (near or {}).items():
        ranges[beam] = distance
    return ranges


def examples(rng: Rng) -> Iterator[Scene]:
    """36 beams, the threshold of the beginning."""
    yield Scene(
        [
            phase(beams(36), "rien à moins de 5 m"),
            phase(beams(36, {18: 0.2}), "un obstacle à 0,2 m, au milieu"),
            phase(beams(36, {18: 0.4}), "un obstacle à 0,4 m, au milieu"),
            phase(beams(36, {15: 0.28}), "un obstacle à 0,28 m, devant"),
            phase(beams(36, {15: 0.32}), "un obstacle à 0,32 m, devant"),
            phase(beams(36, {20: 0.27}), "un obstacle à 0,27 m, devant"),
            phase(beams(36, {20: 0.297}), "un obstacle à 0,297 m, devant"),
            phase(beams(36, {20: 0.303}), "un obstacle à 0,303 m, devant"),
            phase(beams(36, {0: 0.2, 35: 0.2}), "un obstacle à 0,2 m, aux deux bouts du scan"),
            phase(beams(36, dict.fromkeys(range(10, 26), 0.25)), "un mur à 0,25 m devant"),
            phase(beams(36), "rien à moins de 5 m"),
        ]
    )
    yield _drawn_obstacles(rng, 36)


def _drawn_obstacles(rng: Rng, count: int) -> Scene:
    """Obstacles nearer and farther than the threshold, inside the window, among others farther away.

    They stand no farther from the middle than those by hand: a window too narrow passes or fails with those alone.
    """
    phases = []
    for _ in range(3):
        ranges = np.round(rng.uniform(1.0, 8.0, count), 2)
        phases.append(phase(ranges, "rien à moins de 1 m"))
        ranges = ranges.copy()
        ranges[count // 2 + rng.integers(-3, 3)] = near = round(float(rng.uniform(0.1, 0.28)), 2)
        phases.append(phase(ranges, f"un obstacle à {_metres(near)}, devant"))
    return Scene(phases)


def _metres(distance: float) -> str:
    return f"{distance:g} m".replace(".", ",")


def windows(rng: Rng) -> Iterator[Scene]:
    """Scans of several sizes, even and odd, with one near beam just inside the window, or just outside."""
    phases = []
    for count in (36, 360, 181, 45, 90, 26, 720):
        middle = count // 2
        for beam in (middle - HALF + MARGIN, middle - HALF - MARGIN - 1, middle + HALF - MARGIN - 1, middle + HALF + 2):
            where = "dans" if abs(beam + 0.5 - middle) < HALF else "hors de"
            told = f"un seul rayon à 0,2 m, le n° {beam}, {where} la fenêtre"
            phases.append(phase(beams(count, {beam: 0.2}), told))
    yield Scene(phases)
    count = int(rng.integers(50, 300))
    middle = count // 2
    sides = beams(count, {k: 0.15 for k in range(count) if abs(k - middle) > HALF + MARGIN})
    yield Scene(
        [
            phase(sides, "des murs à 0,15 m partout, sauf devant"),
            phase(beams(count, {middle + int(rng.integers(-8, 8)): 0.2}), "un obstacle à 0,2 m devant"),
        ]
    )


def readings(rng: Rng) -> Iterator[Scene]:
    """Readings that are no distances, and a lidar with another reach."""
    holes = {8 + 3 * k: NAN for k in range(6)}
    short = {"range_min": 0.02, "range_max": 0.8, "distance": 0.9}
    yield Scene(
        [
            phase(beams(36, {7: NAN, 8: NAN, 9: NAN, 18: 0.2}), "nan aux rayons 7 à 9, puis 0,2 m au rayon 18"),
            phase(beams(36, holes), "des nan devant, entre des lectures à 5 m"),
            phase(beams(36, {17: 0.2, 18: NAN}), "0,2 m au rayon 17, puis nan au rayon 18"),
            phase(beams(36, far=INF), "+inf partout : aucun rayon n'a rien touché"),
            phase(beams(36, holes | {14: 0.25}, far=INF), "0,25 m au rayon 14, parmi des nan et des +inf"),
            phase(beams(36, {19: INF, 12: 12.0}), "+inf et 12 m devant, alors que range_max vaut 10 m"),
            phase(beams(36, {18: 0.06}), "un obstacle à 0,06 m, juste au-dessus de range_min (0,05 m)"),
        ]
    )
    yield Scene(
        [
            phase(beams(37, {18: 0.85}, far=INF), "0,85 m devant, alors que range_max vaut 0,8 m", **short),
            phase(beams(37, {18: 0.75}, far=INF), "0,75 m devant, en deçà de range_max (0,8 m)", **short),
            phase(beams(37, {16: 0.88, 20: 0.82, 12: NAN}, far=INF), "deux lectures au-delà de range_max", **short),
        ],
        launched=0.9,
    )
    far = {"distance": 2.5}
    yield Scene(
        [
            phase(beams(36, {18: 2.4}), "un obstacle à 2,4 m, alors que distance_min vaut 2,5 m", **far),
            phase(beams(36, {18: 2.6}), "un obstacle à 2,6 m, alors que distance_min vaut 2,5 m", **far),
        ],
        launched=2.5,
    )
    yield Scene(list(one_sided()))
    ranges = np.where(rng.random(72) < 0.25, NAN, np.round(rng.uniform(1.0, 6.0, 72), 2))
    near = ranges.copy()
    near[36 + rng.integers(-4, 1)] = 0.22
    told = "0,22 m devant, et des nan çà et là"
    yield Scene([phase(ranges, "des nan çà et là, rien à moins de 1 m"), phase(near, told)])


def one_sided() -> Iterator[Phase]:
    """Many invalid readings on one side: the window is that of all beams, and not of those that have read something."""
    for nothing, name in ((NAN, "nan"), (INF, "+inf")):
        blind = dict.fromkeys(range(34), nothing)
        told = f"{name} aux rayons 0 à 33"
        yield phase(beams(90, blind | {44: 0.2}), f"{told}, 0,2 m au rayon 44, dans la fenêtre")
        yield phase(beams(90, blind | {62: 0.2}), f"{told}, 0,2 m au rayon 62, hors de la fenêtre")


def settings(rng: Rng) -> Iterator[Scene]:
    """The parameter changes while the node runs; then a node that is launched with another value."""
    asked = [(0.5, 0.3), (0.5, 0.8), (0.7, 0.8), (0.85, 0.8), (0.25, 0.15), (0.12, 0.15), (0.25, 0.6), (0.17, 0.15)]
    yield Scene([_setting(near, distance) for near, distance in asked])
    at_launch = [_setting(near, 0.6, "donné au lancement :") for near in (0.5, 0.7)]
    yield Scene([*at_launch, _setting(0.5, 0.4), _setting(0.35, 0.4)], launched=0.6)
    drawn = []
    for distance in np.round(rng.uniform(0.2, 0.9, 3), 2).tolist():
        drawn += [_setting(round(distance - 0.05, 2), distance), _setting(round(distance + 0.05, 2), distance)]
    yield Scene(drawn)


def _setting(near: float, distance: float, how: str = "réglé à") -> Phase:
    told = f"un obstacle à {_metres(near)} devant, distance_min {how} {_metres(distance)}"
    return phase(beams(36, {18: near}), told, distance=distance)


def lidars(rng: Rng) -> Iterator[Scene]:
    """The middle is that of the list, whichever angle the lidar begins at."""
    phases = []
    drawn = round(float(rng.uniform(0.5, 3.0)), 2)
    begins = ((0.0, "0"), (-math.pi, "−π"), (-math.pi / 2.0, "−π/2"), (drawn, f"{drawn:g}".replace(".", ",")))
    for angle, name in begins:
        for place, told in ((20, "au milieu de la liste"), (0, "au début de la liste"), (39, "à la fin de la liste")):
            words = f"angle_min vaut {name} : un obstacle à 0,2 m {told}"
            phases.append(phase(beams(41, {place: 0.2}), words, angle_min=angle))
    yield Scene(phases)


def approaches(rng: Rng) -> Iterator[Scene]:
    """A corridor that a wall closes, seen from nearer and nearer, then from farther and farther.

    With 61 beams the window is so wide that the wall at 0.26 m is farther than 0.3 m on the average.
    """
    for count, half_width in ((91, 0.6), (61, 0.6), (int(rng.integers(60, 180)), float(rng.uniform(0.5, 0.9)))):
        there = [1.5, 0.8, 0.5, 0.36, 0.26, 0.18]
        yield Scene([corridor(ahead, count, half_width) for ahead in [*there, *there[-2::-2]]])


def corridor(ahead: float, count: int, half_width: float) -> Phase:
    """What a lidar of a full turn reads in the middle of a corridor, with a wall at so many metres."""
    angles = -math.pi + 2.0 * math.pi * np.arange(count) / count
    with np.errstate(divide="ignore"):
        wall = np.where(np.cos(angles) > 0.0, ahead / np.cos(angles), INF)
        sides = half_width / np.abs(np.sin(angles))
    ranges = np.minimum(wall, sides)
    ranges = np.where(ranges < 9.0, np.round(ranges, 3), INF)
    return phase(ranges, f"un couloir fermé par un mur, à {_metres(ahead)} devant")


def fair(one: Phase) -> bool:
    """Whether every way of reading the contract judges this phase alike."""
    places = np.abs(np.arange(len(one.ranges)) + 0.5 - one.middle)
    ahead = one.ranges[one.middle - HALF : one.middle + HALF]
    seen = np.count_nonzero(~np.isnan(ahead)) > HALF
    sound = bool(seen and np.all(~(one.ranges <= one.range_min)) and len(one.ranges) >= 2 * HALF + 4)
    if one.stop:
        return sound and bool(np.any(_near(one, -APART) & (places < HALF - MARGIN + 0.6)))
    return sound and not bool(np.any(_near(one, APART) & (places < HALF + MARGIN)))


def _near(one: Phase, slack: float) -> NDArray[np.bool_]:
    """Which readings are valid and below the threshold, by so much less or more than it takes."""
    with np.errstate(invalid="ignore"):
        within = (one.ranges > one.range_min - slack) & (one.ranges < one.range_max + slack)
        return np.asarray(within & (one.ranges < one.distance + slack))


EVERY: Sequence[Drawing] = (examples, windows, readings, settings, lidars, approaches)
