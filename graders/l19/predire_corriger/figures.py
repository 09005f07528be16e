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


FIGURES = {MOVED: draw_move, MEASURED: draw_reading}
