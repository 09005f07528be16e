"""Figures of l19/gain: measurements and what they make together, as curves; a chain, as a band that narrows."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from graders.l19.curves import draw_beliefs
from graders.l19.gain.pictures import CHAIN, FUSION
from graders.plotting import EXPECTED, OBTAINED, THIRD


def draw_fusion(figure: Figure, data: dict[str, Any]) -> None:
    """The expected curve is narrower than each of those that it is made of."""
    draw_beliefs(figure, {**data, "title": "Fusionner : plus étroite que chacune des mesures"})


def draw_chain(figure: Figure, data: dict[str, Any]) -> None:
    """The belief, one deviation on either side, before the first reading and after each."""
    axes = figure.add_subplot()
    steps = np.arange(1, len(data["measured"]) + 1)
    deviations = np.sqrt(np.maximum(data["variances"], 0.0))
    axes.errorbar(steps, data["measured"], deviations, fmt="s", color=THIRD, ms=5, capsize=4, label="mesures")
    _draw_band(axes, data["start"], data["expected"], EXPECTED, "attendu", 0.25)
    if data["got"] is not None:
        _draw_band(axes, data["start"], data["got"], OBTAINED, "obtenu", 0.2)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="mesure n°", ylabel="position (m)", title="La croyance, plus ou moins un écart-type")
    figure.legend(loc="outside lower center", ncols=3)


def _draw_band(axes: Axes, start: Any, rows: Any, colour: str, name: str, opacity: float) -> None:
    """Means joined by a line, a band of one deviation; none where a variance is negative."""
    means, variances = np.vstack([start, rows]).T
    steps, sigma = np.arange(len(means)), np.sqrt(np.where(variances < 0.0, np.nan, variances))
    axes.plot(steps, means, "o-", color=colour, lw=2.0, ms=4, label=name)
    axes.fill_between(steps, means - sigma, means + sigma, color=colour, alpha=opacity, lw=0)


FIGURES = {
    FUSION: (
        draw_fusion,
        "Densités de probabilité en fonction de la position, en mètres. Les courbes en tirets sont les mesures ; en "
        "bleu, leur fusion attendue, plus étroite que chacune ; en orange, la fusion de votre programme.",
    ),
    CHAIN: (
        draw_chain,
        "Position en mètres au fil des mesures, qui sont des carrés verts avec leur écart-type. La ligne et la "
        "bande bleues sont la moyenne attendue et son écart-type, qui se resserre à chaque mesure ; celles de votre "
        "programme sont en orange.",
    ),
}
