"""Two walks made by hand for the stage that recognises places: what must be a loop there, and what must not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Floats
from graders.l20.tp_slam.chain import Loop
from graders.l20.tp_slam.small import seen_from
from graders.l20.tp_slam.stages import GAP, TRUE_LOOP, TRUE_LOOP_TURN, read_loops
from reference.se2 import compose, relative, wrap_angle

Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Walk:
    """`scans` (k, beams), and the `chain` (k, 3) of the matches; `truth` (k, 3) says where each scan was taken.

    `sure`: the loops that every reading of the stage must find; `lure`: a place that is none of those it looks like,
    and why.
    """

    scans: Floats
    chain: Floats
    truth: Floats
    sure: Sequence[Pair]
    lure: int
    why: str


def _wall(start: tuple[float, float], end: tuple[float, float], points: int) -> Floats:
    return np.linspace(start, end, points, endpoint=False)


#: A corridor of 4 m by 1.4 that turns into a closet: seen in a mirror, it is another place.
CORRIDOR = np.vstack(
    [
        _wall((-1.5, -1.1), (2.5, -1.1), 400),
        _wall((2.5, -1.1), (2.5, 1.9), 300),
        _wall((2.5, 1.9), (1.4, 1.9), 110),
        _wall((1.4, 1.9), (1.4, 0.3), 160),
        _wall((1.4, 0.3), (-1.5, 0.3), 290),
        _wall((-1.5, 0.3), (-1.5, -1.1), 140),
    ]
)
MIRROR = 21
REACH = 8.0


def _scan(world: Floats, pose: Floats, beams: int) -> Floats:
    """A world seen from a pose: at each bearing, its nearest point, or nothing."""
    points = seen_from(pose, world)
    bearing = np.arctan2(points[:, 1], points[:, 0])
    nearest = np.full(beams, REACH)
    index = np.round(bearing / (2.0 * np.pi) * beams).astype(int) % beams
    np.minimum.at(nearest, index, np.hypot(points[:, 0], points[:, 1]))
    return nearest


def _around_the_corridor() -> Walk:
    """23 places: the last four see again where the first ones were, and the chain has drifted a little by then.

    The scan of one of these is what a mirror shows: the same signature, and no place of this world.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 24)[:23]
    truth = np.column_stack([0.5 + 1.5 * np.cos(angles), -0.4 + 0.5 * np.sin(angles), np.zeros(23)])
    truth[20:, :2] = truth[:3, :2] + 0.03
    truth[19, :2] = truth[0, :2] + 0.02
    drift = np.column_stack([0.004 * np.arange(23), -0.003 * np.arange(23), 0.002 * np.arange(23)])
    scans = np.array([_scan(CORRIDOR, pose, 60) for pose in truth])
    scans[MIRROR] = np.roll(scans[MIRROR][::-1], 1)
    return Walk(
        scans,
        truth + drift,
        truth,
        ((0, 20), (2, 22)),
        MIRROR,
        f"Le scan {MIRROR} est celui que montrerait un miroir : sa signature est la même, mais aucun recalage ne le "
        "confirme. Ce n’est pas une fermeture.",
    )


#: A hall that is open on one side: more than half of the rays see nothing.
HALL = np.vstack(
    [
        _wall((-1.5, -1.1), (2.5, -1.1), 400),
        _wall((2.5, -1.1), (2.5, 0.3), 140),
        _wall((2.5, 0.3), (-0.6, 0.3), 310),
        _wall((-1.5, -0.8), (-1.5, -1.1), 30),
    ]
)
TWIN, THERE, AGAIN = 3, 4, 24


def _back_in_the_hall() -> Walk:
    """25 places: the last is in the hall of place 4, further on and turned by a radian; place 3 is another hall, seven
    metres away, that looks the same. Places of which no two look alike come between.
    """
    k = np.arange(25)
    around = 2.0 * np.pi * k / 25.0
    truth = np.column_stack(
        [0.5 + 1.6 * np.cos(around), -0.4 + 0.55 * np.sin(around), wrap_angle(np.arange(0.0, 60.0, 2.4))]
    )
    longer = [_scan(CORRIDOR, pose, 180) + 0.5 + 0.12 * j for j, pose in enumerate(truth)]
    scans = np.minimum(longer, REACH)  # no reading goes beyond the reach that the statement tells
    truth[THERE] = -1.25, -0.31, -1.74
    truth[AGAIN] = compose(truth[THERE], np.array([0.18, -0.07, -0.99]))
    for place, pose in ((THERE, truth[THERE]), (AGAIN, truth[AGAIN])):
        scans[place] = _scan(HALL, pose, 180)
    scans[TWIN] = _scan(HALL, compose(truth[THERE], np.array([0.1, -0.03, -0.78])), 180)
    truth[TWIN] = 7.0, 3.0, 1.0
    drift = np.column_stack([0.003 * k, -0.002 * k, 0.001 * k])
    return Walk(
        scans,
        truth + drift,
        truth,
        ((THERE, AGAIN),),
        TWIN,
        f"La pose clé {TWIN} est dans un autre hall, qui ressemble à celui de la pose clé {AGAIN} : la chaîne les "
        "place à plus de cinq mètres. Ce n’est pas une fermeture.",
    )


WALKS = (_around_the_corridor(), _back_in_the_hall())


def loops(bench: Bench) -> None:
    """A corridor walked around once, where a mirror hangs; then a hall with a wide opening, and its twin elsewhere."""
    for walk in WALKS:
        found = read_loops(bench, bench.call("fermetures", walk.scans, walk.chain), len(walk.chain))
        fault = _fault(walk, found)
        bench.observe("fermetures", sorted(_pair(loop) for loop in found), ok=not fault)
        if fault:
            raise Rejection(
                fault,
                inputs={"poses clés": len(walk.chain), "rayons": walk.scans.shape[1]},
                expected=[list(pair) for pair in walk.sure],
                got=[[*_pair(loop), *np.round(np.clip(loop[2], -1e4, 1e4), 2).tolist()] for loop in found[:12]],
            )


def _pair(loop: Loop) -> Pair:
    return min(loop[:2]), max(loop[:2])


def _fault(walk: Walk, found: Sequence[Loop]) -> str:
    """What is wrong with the loops of a walk, in the student's words; nothing where all is well."""
    pairs = [_pair(loop) for loop in found]
    if any(walk.lure in pair for pair in pairs):
        return walk.why
    for a, b in pairs:
        if b - a < GAP:
            return f"Les poses clés {a} et {b} sont voisines sur le chemin : il faut au moins vingt rangs entre elles."
    for a, b in walk.sure:
        if (a, b) not in pairs:
            return f"Les poses clés {a} et {b} sont au même endroit : c’est une fermeture."
    for a, b, pose in found:
        x, y, theta = relative(relative(walk.truth[a], walk.truth[b]), pose)
        if np.hypot(x, y) > TRUE_LOOP or abs(theta) > TRUE_LOOP_TURN:
            return f"Les poses clés {a} et {b} se voient bien, mais la pose de {b} vue de {a} n’est pas la bonne."
    return ""
