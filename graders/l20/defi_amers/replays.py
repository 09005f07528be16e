"""What `slam_amers` did on the course's tour, one iteration after the other, beside the map that it should reach."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.defi_amers.maps import Map, sight
from graders.l20.slam_graphe.graphs import edge
from graders.l20.slam_graphe.optimum import POSE_TOLERANCE, gaps
from graders.scene.replay import (
    Chart,
    Circles,
    Frame,
    Key,
    Layer,
    Level,
    Mark,
    Points,
    Polyline,
    Replay,
    Segments,
    Series,
    View,
    decimal,
)

ALT = (
    "Une carte vue de dessus : le trajet en boucle d'un robot, vingt poses orange, et les huit balises qu'il voit. À "
    "chaque itération de votre programme, poses et balises se déplacent. En vert, ce que chaque pose voit ; en rouge, "
    "l'écart qui reste avec la balise. En pointillé bleu, le minimum à atteindre. Dessous, une courbe suit χ²."
)
#: Beyond the tour by this share of it, a map is out of sight; and the room left around all that is in it.
MARGIN, ROOM = 0.3, 0.06
#: What came back is rounded to thousandths.
SEEN = 20 * POSE_TOLERANCE
#: Sums above it are told by their power of ten.
HUGE = 1e6
RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def tour(data: dict[str, Any]) -> Replay:
    """The start, each iteration, then what was judged."""
    steps = [(np.array(poses), np.array(landmarks)) for poses, landmarks in data["frames"]]
    one = Map(
        *steps[0],
        tuple(edge(i, j, z, a, b) for i, j, z, a, b in data["edges"]),
        tuple(sight(i, j, z, w) for i, j, z, w in data["sightings"]),
    )
    costs = [one.chi2(*step) for step in steps]
    least = one.chi2(*one.optimum)
    lost = next((k for k in range(1, len(costs)) if costs[k] > 1.02 * costs[k - 1]), None)
    return Replay(
        _view(one, steps),
        [Frame(_layers(one, step, k), _caption(k, costs, lost, data["ended"])) for k, step in enumerate(steps)],
        _summary(one, steps[-1], costs, least, data["passed"]),
        layers=_under(one),
        charts=[
            Chart(
                "Somme des erreurs χ²",
                [Series("χ²", "estimate", np.maximum(costs, 1e-2))],
                "itération",
                logarithmic=True,
                levels=[Level(max(least, 1e-2), "minimum", "truth")],
                marks=[] if lost is None else [Mark(float(lost), "ici χ² augmente")],
            )
        ],
        legend=[
            Key("dot", "estimate", "vos poses"),
            Key("ring", "estimate", "vos balises"),
            Key("dashed", "truth", "le minimum : poses et balises"),
            Key("line", "measure", "ce que vos poses voient"),
            Key("line", "alert", "écart avec la balise"),
        ],
        period=1.0,
        alt=ALT,
    )


def _view(one: Map, steps: list[tuple[Floats, Floats]]) -> View:
    """The start and the optimum, and what comes between as far as it does not make them tiny."""
    places = np.vstack([one.optimum[0][:, :2], one.optimum[1], one.poses[:, :2], one.landmarks])
    low, high = places.min(axis=0), places.max(axis=0)
    size = float((high - low).max())
    seen = np.vstack([places, *(np.vstack([poses[:, :2], landmarks]) for poses, landmarks in steps)])
    low = np.maximum(seen.min(axis=0), low - MARGIN * size) - ROOM * size
    high = np.minimum(seen.max(axis=0), high + MARGIN * size) + ROOM * size
    (x0, y0), (x1, y1) = low.tolist(), high.tolist()
    return View(x0, y0, x1, y1, up=True)


def _under(one: Map) -> list[Layer]:
    poses, landmarks = one.optimum
    return [Polyline(poses[:, :2], "truth", 1.2, dashed=True), Circles(landmarks, 0.3, "truth", filled=False)]


def _layers(one: Map, step: tuple[Floats, Floats], k: int) -> list[Layer]:
    poses, landmarks = step
    glide = k > 0
    pairs = np.array([(i, j) for i, j, _, _ in one.sightings])
    seen = np.array([z for _, _, z, _ in one.sightings])
    c, s = np.cos(poses[pairs[:, 0], 2]), np.sin(poses[pairs[:, 0], 2])
    starts = poses[pairs[:, 0], :2]
    ends = starts + np.column_stack([c * seen[:, 0] - s * seen[:, 1], s * seen[:, 0] + c * seen[:, 1]])
    return [
        Segments(starts, ends, "measure", width=1.0, opacity=0.5, glide=glide),
        Segments(ends, landmarks[pairs[:, 1]], "alert", width=2.0, opacity=0.8, glide=glide),
        Polyline(poses[:, :2], "estimate", 1.6, glide=glide),
        Points(poses[:, :2], "estimate", size=3.0, headings=poses[:, 2], glide=glide),
        Circles(landmarks, 0.22, "estimate", glide=glide),
    ]


def _told(cost: float) -> str:
    """A cost, as one reads it: a huge one as so many times a power of ten."""
    if cost < HUGE:
        return decimal(cost, 1)
    power = math.floor(math.log10(cost))
    return f"{decimal(cost / 10.0**power, 1)} × 10{str(power).translate(RAISED)}"


def _caption(k: int, costs: list[float], lost: int | None, ended: bool) -> str:
    if k == 0:
        return f"Le départ : l'odométrie, et chaque balise là où elle a été vue d'abord. χ² = {_told(costs[0])}."
    if ended and k == len(costs) - 1:
        return f"Ce que votre programme a renvoyé quand il a été jugé : χ² = {_told(costs[k])}."
    if k == lost:
        return f"Itération {k} : ici χ² monte de {_told(costs[k - 1])} à {_told(costs[k])} ; le pas est faux."
    return f"Itération {k} de votre programme : χ² = {_told(costs[k])}."


def _summary(one: Map, last: tuple[Floats, Floats], costs: list[float], least: float, passed: bool) -> list[str]:
    equations = 3 * len(one.edges) + 2 * len(one.sightings)
    free = equations - 3 * (len(one.poses) - 1) - 2 * len(one.landmarks)
    texts = [f"χ² passe de {_told(costs[0])} à {_told(costs[-1])} ; au minimum, il vaut {decimal(least, 1)}."]
    poses, landmarks = one.optimum
    away = float(max(np.abs(gaps(poses, last[0])).max(), np.abs(landmarks - last[1]).max()))
    if passed and away < SEEN:
        texts.append(
            f"Vous y êtes. Il y a {equations} équations et {free} de plus que d'inconnues libres : "
            f"avec des bruits bien décrits, χ² finit près de {free}."
        )
    else:
        texts.append(f"La pose ou la balise la plus mal placée est à {decimal(away, 2)} de sa place.")
    return texts


REPLAYS = {"carte": tour}
