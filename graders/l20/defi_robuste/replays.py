"""What `gauss_newton_robuste` did: stopped after a few iterations, then as judged, beside plain least squares."""

from __future__ import annotations

from typing import Any

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.defi_robuste.graphs import DELTA, RATIO, WEIGHT, Robust
from graders.l20.slam_graphe.graphs import edge
from graders.scene.replay import (
    Chart,
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
from reference.pose_graph import Huber, robust_gauss_newton

ALT = (
    "Une carte vue de dessus : le trajet en boucle d'un robot, vingt-quatre poses orange, et ses fermetures de boucle, "
    "en vert les vraies et en rouge les fausses, d'autant plus pâles que leur poids est petit. D'abord le départ, puis "
    "les moindres carrés ordinaires, que les fausses tordent, puis votre programme après quelques itérations. En "
    "pointillé bleu, le vrai trajet. Dessous, deux courbes : l'écart à la vérité, et le poids des fausses arêtes."
)
#: Closures are drawn by weight, in so many shades.
SHADES = (0.12, 0.35, 0.65, 1.0)
BEFORE = 2  # frames: the start, plain least squares


def robust(data: dict[str, Any]) -> Replay:
    """The start and plain least squares, then the program of the student, then Huber's map by the reference."""
    one = Robust(
        np.array(data["start"]),
        tuple(edge(i, j, z, a, b) for i, j, z, a, b in data["edges"]),
        np.array(data["truth"]),
        np.array(data["false"], dtype=np.bool_),
    )
    everything = np.ones(len(one.edges))
    stops = [int(stop) for stop, _, _ in data["frames"]]
    steps = [(one.poses, everything), (one.plain, everything)]
    steps += [(np.array(poses), np.array(weights)) for _, poses, weights in data["frames"]]
    wanted = robust_gauss_newton(one.model, one.poses, Huber(DELTA))
    steps.append((wanted.poses, wanted.weights))
    errors = [one.error(poses) for poses, _ in steps]
    lies = [float(weights[one.false].max()) for _, weights in steps]
    wrong = _wrong(one, errors, lies, len(stops))
    why = "" if wrong is None else _reason(errors[wrong], lies[wrong], errors[1])
    numbers = np.arange(1.0, len(steps) + 1.0)
    return Replay(
        _view(one),
        [
            Frame(_layers(one, *step, k), _caption(k, stops, errors, lies, why if k == wrong else ""))
            for k, step in enumerate(steps)
        ],
        _summary(errors, lies, len(stops)),
        layers=[Polyline(one.truth[:, :2], "truth", 1.2, dashed=True)],
        charts=[
            Chart(
                "Écart quadratique moyen à la vérité",
                [Series("écart", "estimate", errors, numbers, style="bars")],
                "image",
                (0.0, None),
                levels=[Level(RATIO * errors[1], "à ne pas dépasser", "ink")],
                marks=[] if wrong is None else [Mark(wrong + 1.0, _mark(errors[wrong], lies[wrong], errors[1]))],
                cursor=numbers.tolist(),
            ),
            Chart(
                "Poids de la fausse arête la mieux crue",
                [Series("poids", "alert", lies, numbers, style="bars")],
                "image",
                (0.0, 1.05),
                levels=[Level(WEIGHT, "à ne pas dépasser", "ink")],
                cursor=numbers.tolist(),
            ),
        ],
        legend=[
            Key("dot", "estimate", "poses"),
            Key("dashed", "truth", "vrai trajet"),
            Key("line", "measure", "vraie fermeture (pâle : petit poids)"),
            Key("line", "alert", "fausse fermeture"),
        ],
        period=1.4,
        alt=ALT,
    )


def _view(one: Robust) -> View:
    places = np.vstack([one.truth[:, :2], one.poses[:, :2], one.plain[:, :2]])
    low, high = places.min(axis=0), places.max(axis=0)
    room = 0.12 * float((high - low).max())
    (x0, y0), (x1, y1) = (low - room).tolist(), (high + room).tolist()
    return View(x0, y0, x1, y1, up=True)


def _layers(one: Robust, poses: Floats, weights: Floats, k: int) -> list[Layer]:
    glide = k > 0
    drawn: list[Layer] = []
    closures = np.abs(one.model.j - one.model.i) != 1
    shade = np.searchsorted(SHADES[:-1], weights)
    for colour, which in (("measure", closures & ~one.false), ("alert", one.false)):
        for level, opacity in enumerate(SHADES):
            chosen = which & (shade == level)
            starts, ends = poses[one.model.i[chosen], :2], poses[one.model.j[chosen], :2]
            width = 3.0 if colour == "alert" else 2.0
            drawn.append(Segments(starts, ends, colour, width=width, opacity=opacity, dashed=level == 0))  # type: ignore[arg-type]
    drawn.append(Polyline(poses[:, :2], "estimate", 1.6, glide=glide))
    drawn.append(Points(poses[:, :2], "estimate", size=3.0, headings=poses[:, 2], glide=glide))
    return drawn


def _wrong(one: Robust, errors: list[float], lies: list[float], count: int) -> int | None:
    """The frame where what was judged goes wrong: the first from which the false edge is believed to the end."""
    if not count or (errors[BEFORE + count - 1] < RATIO * errors[1] and lies[BEFORE + count - 1] < WEIGHT):
        return None
    bad = [k for k in range(BEFORE, BEFORE + count) if errors[k] >= RATIO * errors[1] or lies[k] >= WEIGHT]
    first = BEFORE + count - 1
    while first - 1 in bad:
        first -= 1
    return first


def _reason(error: float, lie: float, plain: float) -> str:
    """What is wrong with a map, as its caption says it."""
    if error < RATIO * plain:
        return "Ici, la carte est bonne, mais vos poids croient encore la fausse fermeture."
    if lie < WEIGHT:
        return "Ici, la fausse fermeture est débranchée, mais la carte reste loin de la vérité."
    return "Ici, la fausse fermeture tire encore la carte."


def _mark(error: float, lie: float, plain: float) -> str:
    return "ici la fausse est crue" if lie >= WEIGHT and error < RATIO * plain else "ici la carte est tordue"


def _caption(k: int, stops: list[int], errors: list[float], lies: list[float], here: str) -> str:
    away = f"écart à la vérité : {decimal(errors[k], 2)}"
    if k == 0:
        return f"Le départ, l'odométrie seule ; {away}."
    if k == 1:
        return f"Les moindres carrés ordinaires croient tout le monde ; {away}."
    if k == len(errors) - 1:
        return f"La référence, avec le noyau de Huber et δ = {decimal(DELTA, 0)} ; {away}."
    stop = stops[k - BEFORE]
    turns = "1 itération" if stop == 1 else f"{stop} itérations"
    return f"Votre programme, {turns} ; {away} ; la fausse arête pèse {decimal(lies[k], 2)}. {here}".rstrip()


def _summary(errors: list[float], lies: list[float], count: int) -> list[str]:
    texts = [
        f"Les moindres carrés ordinaires s'écartent de la vérité de {decimal(errors[1], 2)}, "
        f"le noyau de Huber de {decimal(errors[-1], 2)}."
    ]
    if not count:
        return [*texts, "Votre programme n'a rien renvoyé que l'on puisse dessiner."]
    mine = BEFORE + count - 1
    texts.append(
        f"Votre carte s'en écarte de {decimal(errors[mine], 2)}, et la fausse fermeture y garde un poids de "
        f"{decimal(lies[mine], 3)}."
    )
    return texts


REPLAYS = {"robuste": robust}
