"""The film of l20/icp: the student's cloud after one iteration, two, three…, beside the reference's way."""

from __future__ import annotations

from typing import Any

import numpy as np

from graders.core.compare.told_apart import number_text_pair
from graders.core.contract.values import Floats
from graders.l20.icp.descent import Step, descend
from graders.scene.replay import (
    Chart,
    Frame,
    Key,
    Layer,
    Mark,
    Points,
    Polyline,
    Replay,
    Segments,
    Series,
    View,
    decimal,
)

MARGIN = 1.0


def iterations(data: dict[str, Any]) -> Replay:
    """Both clouds at each iteration, the student's pairs, the error of both ways, and where they part."""
    P, Q = np.array(data["P"], dtype=float), np.array(data["Q"], dtype=float)
    mine = [(np.eye(2), np.zeros(2))]
    mine += [(np.array(R, dtype=float), np.array(t, dtype=float)) for R, t in zip(data["R"], data["t"], strict=True)]
    steps = descend(P, Q, np.eye(2), np.zeros(2), max(1, len(mine) - 1))
    wrong = data["wrong"]
    frames, errors, wanted = [], [], []
    for k, (R, t) in enumerate(mine):
        own, right = P @ R.T + t, _reference(P, steps, k)
        pairs = _nearest(own, Q)
        errors.append(float(np.sum((own - Q[pairs]) ** 2)))
        wanted.append(float(np.sum((right - Q[_nearest(right, Q)]) ** 2)))
        layers: list[Layer] = [
            Segments(own, Q[pairs], "measure", width=1.2, opacity=0.7, glide=True),
            Points(right, "second", size=4.5, opacity=0.55, glide=True),
            Points(own, "estimate", size=3.0, glide=True),
        ]
        if wrong == k:
            layers.append(Polyline(_around(own), "alert", dashed=True))
        frames.append(Frame(layers, _caption(k, errors[-1], wanted[-1], wrong)))
    ends = np.vstack([Q, P, P @ mine[-1][0].T + mine[-1][1]])
    ends = ends[np.all(np.abs(ends) < 4.0 * np.max(np.abs(np.vstack([P, Q]))), axis=1)]
    (x0, y0), (x1, y1) = ends.min(axis=0) - MARGIN, ends.max(axis=0) + MARGIN
    marks = [] if wrong is None else [Mark(float(min(wrong, len(mine) - 1)), "ici les chemins se séparent")]
    return Replay(
        View(float(x0), float(y0), float(x1), float(y1), up=True),
        frames,
        _summary(mine, errors, wanted, wrong),
        layers=[Points(Q, "truth", size=3.0)],
        charts=[
            Chart(
                "Somme des carrés des distances aux plus proches",
                [Series("la vôtre", "estimate", errors), Series("attendue", "second", wanted, style="dashed")],
                "itération",
                (0.0, None),
                marks=marks,
            )
        ],
        legend=[
            Key("dot", "truth", "Q, le premier scan"),
            Key("dot", "estimate", "P, déplacé par votre code"),
            Key("dot", "second", "P, déplacé comme attendu"),
            Key("line", "measure", "paires"),
        ],
        period=0.9,
    )


def _reference(P: Floats, steps: list[Step] | Any, k: int) -> Floats:
    if k == 0:
        return P
    step = steps[min(k, len(steps)) - 1]
    return np.asarray(P @ step.R.T + step.t)


def _nearest(points: Floats, Q: Floats) -> Any:
    return np.argmin(np.sum((points[:, None] - Q[None]) ** 2, axis=2), axis=1)


def _around(points: Floats) -> Floats:
    (x0, y0), (x1, y1) = points.min(axis=0) - 0.2, points.max(axis=0) + 0.2
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]])


def _caption(k: int, error: float, wanted: float, wrong: int | None) -> str:
    if k == 0:
        return f"Au départ, chaque point prend le plus proche : la somme des carrés vaut {decimal(error, 2)}."
    text = f"Avec n_iter = {k} : la somme des carrés vaut {decimal(error, 2)}"
    if wrong == k:
        return f"{text}. Ici votre nuage quitte le chemin attendu, où elle vaut {decimal(wanted, 2)}."
    return f"{text}."


def _summary(mine: list[Any], errors: list[float], wanted: list[float], wrong: int | None) -> list[str]:
    if wrong is None:
        return [
            f"En {len(mine) - 1} itérations, la somme des carrés passe de {decimal(errors[0], 1)} à "
            f"{decimal(errors[-1], 2)}, et votre nuage suit le chemin attendu.",
            "Chaque image est un appel de votre fonction, avec une itération de plus.",
        ]
    texts = [f"Les chemins se séparent avec n_iter = {wrong}."]
    if len(mine) <= wrong:
        return [*texts, "Votre fonction n'y a pas rendu de triplet : le film s'arrête là."]
    return [
        *texts,
        "À la fin, votre somme des carrés vaut {}, au lieu de {}.".format(*number_text_pair(errors[-1], wanted[-1], 3)),
    ]


REPLAYS = {"iterations": iterations}
