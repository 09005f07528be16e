"""Replays of l20/slam_graphe: how the student's program moves the poses of a graph, beside the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.slam_graphe.filming import STEPS
from graders.scene.replay import (
    Chart,
    Frame,
    Key,
    Layer,
    Mark,
    Points,
    Replay,
    Segments,
    Series,
    View,
    decimal,
)
from reference.pose_graph import PoseGraph, chi2, edge_chi2, gauss_newton
from reference.se2 import compose

YOURS, THEIRS = 0, 1
ENOUGH = 30
#: Poses farther from the graph than so many times its size are not drawn: they would flatten it.
FAR = 4.0
#: Springs by their share in chi2, from slack to tight: up to what share of the tightest at the start, colour and width.
TENSIONS = ((0.05, "measure", 2.0), (0.4, "estimate", 3.0), (np.inf, "alert", 4.0))
SMALLEST = 1e-3
CLOSE = 1e-3
RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
ALT = (
    "Deux dessins du même graphe de poses : le vôtre, et à côté celui de la référence, à chaque itération. Chaque "
    "point est une pose, son trait dit vers où le robot regarde. Les arêtes sont des ressorts : verts si leur mesure "
    "est satisfaite, orange puis rouges et plus épais quand elle ne l'est pas ; un trait pointillé va de la pose à "
    "l'endroit où la mesure la voudrait. Dessous, deux courbes suivent la somme des erreurs."
)


@dataclass(frozen=True)
class Moment:
    """After so many iterations: the poses of the student's program (None: nothing to draw) and of the reference."""

    name: str
    got: Floats | None
    wanted: Floats


def graphe(data: dict[str, Any]) -> Replay:
    """The film of one graph (`filming.film`), beside the reference's iterations from the same start."""
    start = np.array(data["start"], dtype=np.float64)
    graph = _graph(data, len(start))
    moments = _moments(graph, start, data)
    yours = [_cost(graph, moment.got) for moment in moments]
    theirs = [chi2(graph, moment.wanted) for moment in moments]
    wrong = None if data["right"] else _wrong(moments, yours, theirs)
    scale = float(edge_chi2(graph, start).max())
    frames = []
    for k, moment in enumerate(moments):
        layers = [*_drawn(graph, moment.got, scale, YOURS, k > 0), *_drawn(graph, moment.wanted, scale, THEIRS, k > 0)]
        frames.append(Frame(layers, _caption(moments, yours, theirs, k, wrong)))
    return Replay(
        _view([start, *(moment.wanted for moment in moments)], [m.got for m in moments if m.got is not None]),
        frames,
        _summary(moments, yours, theirs, wrong),
        charts=[_chart(moments, yours, theirs, wrong)],
        legend=[
            Key("dot", "ink", "pose"),
            Key("dot", "truth", "pose fixée"),
            Key("line", "measure", "ressort détendu"),
            Key("line", "estimate", "ressort tendu"),
            Key("line", "alert", "ressort très tendu"),
            Key("dashed", "second", "écart à la mesure"),
        ],
        period=1.2,
        alt=ALT,
        panels=("Votre graphe", "Celui de la référence"),
        wrong=wrong,
    )


def _graph(data: dict[str, Any], n: int) -> PoseGraph:
    rows = zip(data["ends"], data["z"], data["weights"], strict=True)
    return PoseGraph.from_edges(n, [(int(i), int(j), np.array(z), np.diag([a, a, b])) for (i, j), z, (a, b) in rows])


def _moments(graph: PoseGraph, start: Floats, data: dict[str, Any]) -> list[Moment]:
    moments = [Moment("départ", start, start)]
    asked = data["n_iter"]
    for steps, poses in zip(STEPS, data["steps"], strict=False):
        if asked is None or steps < asked:
            wanted = gauss_newton(graph, start, max_iterations=steps).poses
            moments.append(Moment(f"itération {steps}", _poses(poses), wanted))
    name = "fin" if asked is None else f"itération {asked}"
    wanted = gauss_newton(graph, start, max_iterations=asked or ENOUGH).poses
    return [*moments, Moment(name, _poses(data["end"]), wanted)]


def _poses(rows: Any) -> Floats | None:
    return None if rows is None else np.array(rows, dtype=np.float64)


def _cost(graph: PoseGraph, poses: Floats | None) -> float:
    return float("nan") if poses is None else chi2(graph, poses)


def _wrong(moments: Sequence[Moment], yours: Sequence[float], theirs: Sequence[float]) -> int:
    """The first moment where nothing is left, chi2 climbs though the reference's does not, the first pose has moved, or
    nothing moves though springs pull; else the end."""
    for k in range(1, len(moments)):
        before, now = moments[k - 1].got, moments[k].got
        if now is None or before is None or (_climbs(yours, k) and not _climbs(theirs, k)):
            return k
        if _unfixed(moments, k) or (_still(moments, k) and yours[k] > theirs[k] * (1.0 + CLOSE) + CLOSE):
            return k
    return len(moments) - 1


def _climbs(costs: Sequence[float], k: int) -> bool:
    return costs[k] > costs[k - 1] * (1.0 + 1e-6) + 1e-9


def _unfixed(moments: Sequence[Moment], k: int) -> bool:
    now = moments[k].got
    return now is not None and float(np.abs(now[0] - moments[0].wanted[0]).max()) >= CLOSE


def _still(moments: Sequence[Moment], k: int) -> bool:
    before, now = moments[k - 1].got, moments[k].got
    return before is not None and now is not None and float(np.abs(now - before).max()) < CLOSE


def _drawn(graph: PoseGraph, poses: Floats | None, scale: float, panel: int, glide: bool) -> list[Layer]:
    if poses is None:
        return []
    places, shares = poses[:, :2], edge_chi2(graph, poses)
    layers: list[Layer] = []
    least = 0.0
    for part, color, width in TENSIONS:
        chosen = (shares >= least) & (shares < part * max(scale, SMALLEST))
        least = part * max(scale, SMALLEST)
        starts, ends = places[graph.i[chosen]], places[graph.j[chosen]]
        layers.append(Segments(starts, ends, color, width=width, glide=glide, panel=panel))  # type: ignore[arg-type]
    wished = compose(poses[graph.i], graph.z_i_j)[:, :2]
    layers.append(
        Segments(wished, places[graph.j], "second", width=1.5, opacity=0.9, dashed=True, glide=glide, panel=panel)
    )
    layers.append(Points(places, "ink", size=4.0, headings=poses[:, 2], glide=glide, panel=panel))
    layers.append(Points(places[:1], "truth", size=5.5, headings=poses[:1, 2], glide=glide, panel=panel))
    return layers


def _view(wanted: Sequence[Floats], got: Sequence[Floats]) -> View:
    """Around all that is near the graph."""
    points = np.vstack([poses[:, :2] for poses in wanted])
    centre, reach = points.mean(axis=0), max(1.0, float(np.ptp(points, axis=0).max()))
    for poses in got:
        if np.abs(poses[:, :2] - centre).max() <= FAR * reach:
            points = np.vstack([points, poses[:, :2]])
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    margin = 0.12 * max(1.0, x1 - x0, y1 - y0)
    short = max(0.0, 0.6 * max(x1 - x0, y1 - y0) - min(x1 - x0, y1 - y0)) / 2.0
    dx, dy = (short, 0.0) if x1 - x0 < y1 - y0 else (0.0, short)
    return View(x0 - margin - dx, y0 - margin - dy, x1 + margin + dx, y1 + margin + dy, up=True)


def _number(cost: float) -> str:
    if cost < 5e-4:
        return "0"
    if cost < 1e4:
        return decimal(cost, 3 if cost < 1.0 else 1)
    mantissa, exponent = f"{cost:.1e}".split("e+")
    return f"{mantissa.replace('.', ',')} × 10{str(int(exponent)).translate(RAISED)}"


def _caption(
    moments: Sequence[Moment], yours: Sequence[float], theirs: Sequence[float], k: int, wrong: int | None
) -> str:
    name = moments[k].name.capitalize()
    if k == 0:
        return f"{name} : χ² = {_number(theirs[0])}. Chaque ressort tire pour que sa mesure soit satisfaite."
    if moments[k].got is None:
        return f"{name} : votre programme ne renvoie pas de poses que l'on puisse dessiner."
    text = f"{name} : χ² = {_number(yours[k])} chez vous, {_number(theirs[k])} chez la référence."
    return text if k != wrong else f"{text} {_reason(moments, yours, theirs, k)}"


def _reason(moments: Sequence[Moment], yours: Sequence[float], theirs: Sequence[float], k: int) -> str:
    """What is wrong at this moment, in words."""
    now = moments[k].got
    if _climbs(yours, k) and not _climbs(theirs, k):
        return "Ici votre χ² monte, alors que celui de la référence descend."
    if _unfixed(moments, k):
        return "Ici votre première pose a bougé, alors qu'elle devait rester fixe."
    if _still(moments, k) and yours[k] > theirs[k] * (1.0 + CLOSE) + CLOSE:
        return "Ici plus rien ne bouge chez vous, et les ressorts tirent encore."
    if now is not None and np.abs(now[:, 2]).max() > np.pi + CLOSE:
        return "Un de vos caps sort de [−π, π]."
    return "Vos poses ne sont pas celles du minimum."


def _chart(moments: Sequence[Moment], yours: Sequence[float], theirs: Sequence[float], wrong: int | None) -> Chart:
    known = [cost for cost in (*yours, *theirs) if np.isfinite(cost)]
    steep = max(known) > 100.0 * max(min(known), SMALLEST)
    shown = [np.maximum(costs, SMALLEST) if steep else np.array(costs) for costs in (yours, theirs)]
    return Chart(
        "Somme des erreurs χ²",
        [Series("la référence", "truth", shown[1], style="dashed"), Series("votre code", "estimate", shown[0])],
        f"image (la dernière : {moments[-1].name})",
        (None if steep else 0.0, None),
        logarithmic=steep,
        marks=[] if wrong is None else [Mark(wrong, "ici")],
    )


def _summary(
    moments: Sequence[Moment], yours: Sequence[float], theirs: Sequence[float], wrong: int | None
) -> list[str]:
    texts = [f"De {_number(theirs[0])} au départ, la référence fait descendre χ² à {_number(theirs[-1])}."]
    if moments[-1].got is None:
        return [*texts, "Votre programme ne renvoie pas de poses que l'on puisse dessiner."]
    texts.append(f"Votre programme l'amène à {_number(yours[-1])}.")
    if wrong is None:
        texts.append("Les deux graphes finissent au même endroit.")
    return texts


REPLAYS = {"graphe": graphe}
