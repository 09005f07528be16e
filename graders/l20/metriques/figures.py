"""Figures of l20/metriques: a trajectory laid over the truth, and motions compared one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from graders.core.compare.words import number
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

Floats = NDArray[np.float64]


def draw_alignment(figure: Figure, data: dict[str, Any]) -> None:
    """The truth, the estimate as it is given, and laid over the truth: what the error measures is dotted."""
    axes = figure.add_subplot()
    truth, estimate, aligned = (np.array(data[name], dtype=float) for name in ("truth", "estimate", "aligned"))
    axes.plot(*estimate.T, "o-", color=ink_of(axes), alpha=0.5, ms=4, lw=1.0, label="estimée, telle quelle")
    axes.plot(*truth.T, "s-", color=EXPECTED, ms=6, lw=1.6, label="vraie")
    axes.plot(*aligned.T, "o-", color=THIRD, ms=5, lw=1.6, label="estimée, une fois alignée")
    _gaps(axes, truth, aligned, "écarts de l'ATE")
    axes.annotate("départ", tuple(truth[0]), textcoords="offset points", xytext=(8, -14), color=EXPECTED)
    _finish(figure, axes, "ATE", data)


def draw_motions(figure: Figure, data: dict[str, Any]) -> None:
    """From one start, where each motion of the truth leads, and the one that was estimated."""
    axes = figure.add_subplot()
    truth, estimate = (np.array(data[name], dtype=float) for name in ("truth", "estimate"))
    ink = ink_of(axes)
    for motion in truth:
        axes.plot([0, motion[0]], [0, motion[1]], color=EXPECTED, lw=1.0, alpha=0.6)
    for motion in estimate:
        axes.plot([0, motion[0]], [0, motion[1]], color=THIRD, lw=1.0, alpha=0.6)
    axes.plot(*truth.T, "s", color=EXPECTED, ms=7, label="vrai déplacement")
    axes.plot(*estimate.T, "o", color=THIRD, ms=5, label="déplacement estimé")
    _gaps(axes, truth, estimate, "écarts de la RPE")
    for place in np.unique(np.round(truth, 6), axis=0):
        pairs = [i for i, motion in enumerate(truth) if np.allclose(motion, place, atol=1e-6)]
        name = ", ".join(f"{i}→{i + data['delta']}" for i in pairs)
        axes.annotate(name, tuple(place), textcoords="offset points", xytext=(6, 7), color=EXPECTED, fontsize=8)
    axes.plot(0, 0, ">", color=ink, ms=9, label="robot en i, qui regarde vers la droite")
    _finish(figure, axes, "RPE", data)


def _gaps(axes: Axes, one: Floats, other: Floats, label: str) -> None:
    for k, (a, b) in enumerate(zip(one, other, strict=True)):
        axes.plot(*np.stack([a, b]).T, color=OBTAINED, lw=2.0, ls=":", label=label if k == 0 else None)


def _finish(figure: Figure, axes: Axes, name: str, data: dict[str, Any]) -> None:
    got = "" if data["got"] is None else f", obtenue : {number(float(np.asarray(data['got'])), 4)}"
    axes.set_title(f"{name} attendue : {number(float(data['expected']), 4)}{got}")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.set(xlabel="x (m)", ylabel="y (m)")
    figure.legend(loc="outside lower center", ncols=2)


FIGURES = {
    "alignment": (
        draw_alignment,
        "Vue de dessus en mètres : la trajectoire vraie (bleu), l’estimée telle quelle (gris) et l’estimée une fois "
        "alignée (vert). Les pointillés orange sont les écarts que mesure l’ATE ; le titre donne la valeur attendue "
        "et la vôtre.",
    ),
    "motions": (
        draw_motions,
        "Vue de dessus en mètres, robot à l’origine, tourné vers la droite : les vrais déplacements (carrés bleus) "
        "et les déplacements estimés (ronds verts). Les pointillés orange sont les écarts que mesure la RPE ; le "
        "titre donne la valeur attendue et la vôtre.",
    ),
}
