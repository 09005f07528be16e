"""Figures of l19/predire_corriger: the belief as a curve, before and after, beside the one that came back."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from graders.l19.curves import draw_beliefs
from graders.l19.predire_corriger.pictures import MEASURED, MOVED


def draw_move(figure: Figure, data: dict[str, Any]) -> None:
    """The curve moves and widens."""
    draw_beliefs(figure, {**data, "title": "Prédire : la cloche se déplace et s'élargit"})


def draw_reading(figure: Figure, data: dict[str, Any]) -> None:
    """The curve goes towards the reading and narrows."""
    draw_beliefs(figure, {**data, "title": "Corriger : la cloche va vers la mesure et se resserre"})


FIGURES = {
    MOVED: (
        draw_move,
        "Densités de probabilité en fonction de la position, en mètres. En tirets, ce qui est donné ; en bleu, la "
        "croyance attendue après le déplacement, décalée et élargie ; en orange, celle de votre programme.",
    ),
    MEASURED: (
        draw_reading,
        "Densités de probabilité en fonction de la position, en mètres. En tirets, la croyance donnée et la mesure "
        "; en bleu, la croyance attendue, entre les deux et plus étroite ; en orange, celle de votre programme.",
    ),
}
