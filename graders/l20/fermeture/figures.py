"""Figures of l20/fermeture: how well j is known before the eyes of i, and where the measurement falls."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.core.compare.words import number
from graders.l19.ellipses import draw_belief, ellipse
from graders.l20.fermeture.pictures import GATE, RELATIVE
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of


def draw_relative(figure: Figure, data: dict[str, Any]) -> None:
    """The ellipse of one deviation of the place of j in the frame of i, expected and obtained."""
    axes = figure.add_subplot()
    axes.plot(0.0, 0.0, ">", color=ink_of(axes), ms=12, label="robot i")
    draw_belief(axes, (data["seen"], data["expected"]), EXPECTED, "attendu", width=3.2)
    if data["got"] is not None:
        draw_belief(axes, (data["seen"], data["got"]), OBTAINED, "obtenu")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="devant i (m)", ylabel="à gauche de i (m)", title="Ce que l'on sait de j, vue de i")
    figure.legend(loc="outside lower center", ncols=3)


def draw_gate(figure: Figure, data: dict[str, Any]) -> None:
    """The shadow of the gate on the plane of positions, and the measurement; the angle is in the third dimension."""
    axes = figure.add_subplot()
    contour = ellipse(np.array(data["gate"]))
    seen = np.array(data["seen"])
    axes.plot(0.0, 0.0, ">", color=ink_of(axes), ms=12, label="robot i")
    axes.plot(*seen, "o", color=EXPECTED, ms=7, label="j selon les poses")
    if contour is not None:
        axes.plot(*(seen + contour).T, color=EXPECTED, lw=2.4, label="la porte (ombre sur le plan)")
    axes.plot(*data["measured"], "X", color=THIRD, ms=11, label="j selon la mesure")
    axes.set_aspect("equal", adjustable="datalim")
    answer = "acceptée" if data["accepted"] else "refusée"
    title = f"d² = {number(data['distance'], 4)}, seuil {number(data['limit'], 4)} : {answer}"
    axes.set(xlabel="devant i (m)", ylabel="à gauche de i (m)", title=title)
    figure.legend(loc="outside lower center", ncols=2)


FIGURES = {
    RELATIVE: (
        draw_relative,
        "Vue de dessus en mètres, dans le repère du robot i : l’ellipse à un écart-type de la place de j. L’ellipse "
        "bleue épaisse est celle que l’on attend, l’ellipse orange celle de votre programme : elles devraient se "
        "superposer.",
    ),
    GATE: (
        draw_gate,
        "Vue de dessus en mètres, dans le repère du robot i : la place de j selon les poses (rond bleu), la porte "
        "autour d’elle (ellipse bleue) et la place de j selon la mesure (croix verte). Le titre donne la distance "
        "d², le seuil et la réponse attendue, acceptée ou refusée.",
    ),
}
