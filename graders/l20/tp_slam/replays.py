"""Replays of l20/tp_slam: the path and what was seen from it, stage by stage, beside the truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.tp_slam import journeys
from graders.l20.tp_slam.chain import ate, truth_at
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
from reference.se2 import transform

YOURS, TRUE = 0, 1
#: One point in so many is drawn.
THIN = 4
PATHS = ("odometry", "before", "matched", "solved")
#: Errors of which one is so many times another are shown on a logarithmic scale, from TINY metres on.
WIDE, TINY = 20.0, 1e-3
ELSEWHERE = "Ce qui échoue est le petit graphe de la vérification : ce parcours-ci n'est pas jugé."
ALT = (
    "Deux plans côte à côte : à gauche, votre trajectoire et les points vus d'elle, étape par étape ; à droite, la "
    "vraie trajectoire et les mêmes points. D'abord tordus par l'odométrie, vos murs se redressent avec les recalages, "
    "puis se rejoignent quand les boucles sont refermées. Dessous, l'erreur de trajectoire à chaque étape."
)


def chaine(data: dict[str, Any]) -> Replay:
    """From odometry to the graph, on one of the two journeys."""
    truth, clouds = _seen(data)
    paths = _paths(data)
    last = len(paths) - 1
    errors = [ate(path, truth) for _, path in paths]
    worse = next((k for k in range(1, last + 1) if errors[k] > errors[k - 1]), None)
    real = data["place"] == "intel"
    wide = max(errors) > WIDE * max(min(errors), TINY)
    stages = [float(k + 1) for k in range(last + 1)]
    frames = []
    for k, (name, path) in enumerate(paths):
        layers: list[Layer] = [
            *_drawn(path, clouds, "estimate", YOURS, k > 0),
            *_drawn(truth, clouds, "truth", TRUE, False),
        ]
        if name in ("Boucles", "Graphe") and data["loops"]:
            a, b = np.array(data["loops"], dtype=np.int64).T
            layers.append(Segments(path[a, :2], path[b, :2], "measure", width=1.5, opacity=0.6, panel=YOURS))
        frames.append(Frame(layers, _caption(name, errors[k], len(data["loops"]), k == worse)))
    return Replay(
        _view(paths, truth, clouds),
        frames,
        [
            *([ELSEWHERE] if data.get("unjudged") else []),
            *_summary(paths, errors, len(data["loops"]), worse, borrowed=bool(data.get("borrowed")), real=real),
        ],
        charts=[
            Chart(
                f"Erreur de la trajectoire (ATE, en m{', échelle logarithmique' if wide else ''})",
                [Series("ATE", "estimate", errors, stages, style="bars")],
                ", ".join(f"{k} {name.lower()}" for k, (name, _) in enumerate(paths, 1)),
                (max(min(errors) / 2.0, TINY), None) if wide else (0.0, None),
                wide,
                marks=[Mark(worse + 1.0, "ici, c'est pire qu'avant")] if worse is not None else [],
                levels=[Level(errors[0], "odométrie")],
                cursor=stages,
            )
        ],
        legend=[
            Key("line", "estimate", "votre trajectoire"),
            Key("line", "truth", "celle du journal" if real else "la vraie"),
            Key("line", "measure", "boucle refermée"),
            Key("dot", "ink", "point vu"),
        ],
        period=1.6,
        alt=ALT,
        panels=(
            "Étapes du cours, puis les vôtres" if data.get("borrowed") else "Vos étapes",
            "Le journal" if real else "La vérité",
        ),
        wrong=worse,
    )


def _paths(data: dict[str, Any]) -> list[tuple[str, Floats]]:
    """Each stage that was reached and the poses that it came to."""
    path = {name: np.array(data[name], dtype=np.float64) for name in PATHS if name in data}
    paths = [("Odométrie", path["odometry"]), ("Recalages", path.get("before", path["matched"]))]
    if "before" in path:
        paths.append(("Étalonnage", path["matched"]))
    return [*paths, ("Boucles", path["matched"]), ("Graphe", path["solved"])] if "solved" in path else paths


def _seen(data: dict[str, Any]) -> tuple[Floats, list[Floats]]:
    """The true poses of the key scans, and the points seen from each, in its frame."""
    if data["place"] == "intel":
        place = journeys.indoor()
        return place.truth, [cloud[::THIN] for cloud in place.clouds]
    keys = data["keys"]
    return truth_at(keys), [journeys.cloud(journeys.simulated().scans[k])[::THIN] for k in keys]


def _drawn(path: Floats, clouds: list[Floats], color: Any, panel: int, glide: bool) -> list[Layer]:
    points = np.vstack([transform(pose, cloud) for pose, cloud in zip(path, clouds, strict=True)])
    return [
        Points(points, "ink", 1.0, opacity=0.45, panel=panel, glide=glide),
        Polyline(path[:, :2], color, 2.0, panel=panel, glide=glide),
    ]


def _caption(name: str, error: float, loops: int, worse: bool) -> str:
    what = {
        "Odométrie": "ce que les roues ont compté",
        "Recalages": "chaque scan posé sur le précédent",
        "Étalonnage": "trois constantes corrigent l'odométrie, et les recalages repartent d'elle",
        "Boucles": f"{count_of(loops)}, pas encore dans le graphe",
        "Graphe": "tout mis d'accord",
    }[name]
    wrong = " Ici, l'erreur a grandi au lieu de diminuer." if worse else ""
    return f"{name} : {what}. ATE de {decimal(error, 2)} m.{wrong}"


def count_of(loops: int) -> str:
    return {0: "aucune boucle", 1: "une boucle"}.get(loops, f"{loops} boucles")


def _summary(
    paths: list[tuple[str, Floats]], errors: list[float], loops: int, worse: int | None, *, borrowed: bool, real: bool
) -> list[str]:
    """The error after each stage that changes it; whose matches and loops these are."""
    of = {name: decimal(error, 2) for (name, _), error in zip(paths, errors, strict=True)}
    calibrated = f", à {of['Étalonnage']} m une fois l'odométrie étalonnée" if "Étalonnage" in of else ""
    whose = "Recalages et boucles sont les vôtres."
    if borrowed:
        whose = "Recalages et boucles sont ceux du cours, partout où une étape d'avant n'a pas réussi."
    elif real:
        whose = "Tous les recalages sont les vôtres ; notre reconnaissance de lieux a proposé les boucles."
    graph = f", puis à {of['Graphe']} m avec {count_of(loops)} dans le graphe" if "Graphe" in of else ""
    told = (
        f"L'erreur est passée de {of['Odométrie']} m avec l'odométrie à {of['Recalages']} m avec les recalages"
        f"{calibrated}{graph}. {whose}"
    )
    return [told] if worse is None else [told, "Une étape a fait pire que celle d'avant : regardez-la d'abord."]


def _view(paths: list[tuple[str, Floats]], truth: Floats, clouds: list[Floats]) -> View:
    """All that is true, odometry, and the other paths as far as they do not make it tiny."""
    walls = np.vstack([transform(pose, cloud) for pose, cloud in zip(truth, clouds, strict=True)])
    low, high = np.percentile(walls, 0.1, axis=0), np.percentile(walls, 99.9, axis=0)
    ends = np.vstack([path[:, :2] for _, path in paths])
    slack = 0.3 * (high - low)
    counted = paths[0][1][:, :2]
    low = np.minimum(np.maximum(np.minimum(low, ends.min(axis=0)), low - slack), counted.min(axis=0)) - 0.5
    high = np.maximum(np.minimum(np.maximum(high, ends.max(axis=0)), high + slack), counted.max(axis=0)) + 0.5
    return View(float(low[0]), float(low[1]), float(high[0]), float(high[1]), up=True)


REPLAYS = {"chaine": chaine}
