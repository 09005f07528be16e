"""Beliefs of two numbers as ellipses of one deviation, for the figures of module L19."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from graders.core.contract.values import Floats
from graders.plotting import EXPECTED, OBTAINED, ink_of

TURN = np.linspace(0.0, 2.0 * np.pi, 121)


def draw_before_and_after(axes: Axes, data: dict[str, Any]) -> None:
    """The belief `before`, the one `expected` and, when it can be drawn, the one `got`."""
    draw_belief(axes, data["before"], ink_of(axes), "avant", style="--")
    draw_belief(axes, data["expected"], EXPECTED, "attendu", width=3.2)
    if data["got"] is not None:
        draw_belief(axes, data["got"], OBTAINED, "obtenu")


def draw_belief(
    axes: Axes, belief: Sequence[Any], colour: str, name: str, *, style: str = "-", width: float = 1.8
) -> None:
    """A mean (2,) and the ellipse of one deviation of its covariance (2, 2), if it is one."""
    centre, shape = (np.asarray(one, dtype=float) for one in belief)
    contour = ellipse(shape)
    if contour is None:
        axes.plot(*centre, "X", color=colour, ms=9, label=f"{name} (pas une covariance)")
        return
    axes.plot(*centre, "o", color=colour, ms=5)
    axes.plot(*(centre + contour).T, style, color=colour, lw=width, label=name)


def ellipse(covariance: Floats) -> Floats | None:
    """The points (n, 2) at one deviation around zero; None for what is not symmetric, or has a negative variance."""
    if not np.allclose(covariance, covariance.T):
        return None
    values, axes = np.linalg.eigh(covariance)
    if values[0] < -1e-9:
        return None
    return np.asarray(np.column_stack([np.cos(TURN), np.sin(TURN)]) * np.sqrt(np.maximum(values, 0.0)) @ axes.T)
