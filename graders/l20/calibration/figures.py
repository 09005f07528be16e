"""Figures of l20/calibration: where each step leads, counted and corrected; the paths through the laboratory."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.l20.calibration.pictures import PATHS, STEPS
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

#: Length of the arrow of a heading, as a part of the longest step.
ARROW = 0.25


def draw_steps(figure: Figure, data: dict[str, Any]) -> None:
    """Each step from the same start: its chord, and the heading at its end."""
    axes = figure.add_subplot()
    ink = ink_of(axes)
    kinds = (
        ("counted", ink, 1.2, ":", "compté"),
        ("expected", EXPECTED, 4.0, "-", "corrigé, attendu"),
        ("got", OBTAINED, 1.8, "-", "obtenu"),
    )
    rows = [np.array(data[name], dtype=float) for name, *_ in kinds if data[name] is not None]
    size = ARROW * max(1.0, float(np.abs(np.vstack(rows)[:, :2]).max()))
    for name, colour, width, style, label in kinds:
        for k, (x, y, theta) in enumerate(data[name] or []):
            axes.plot([0, x], [0, y], style, color=colour, lw=width, label=label if k == 0 else "_")
            tip = (x + size * np.cos(theta), y + size * np.sin(theta))
            axes.annotate("", tip, (x, y), arrowprops={"arrowstyle": "->", "color": colour, "lw": max(1.2, width / 2)})
            axes.plot(*tip, alpha=0)
    axes.plot(0, 0, ">", color=ink, ms=9, label="départ, cap vers la droite")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.set(xlabel="devant (m)", ylabel="à gauche (m)", title="Où mène chaque pas ; la flèche est le cap d'arrivée")
    figure.legend(loc="outside lower center", ncols=2)


def draw_paths(figure: Figure, data: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    axes.plot(*np.array(data["truth"]).T, color=EXPECTED, lw=3.0, label="poses du journal")
    axes.plot(*np.array(data["counted"]).T, color=THIRD, lw=1.4, label="odométrie, telle quelle")
    if data["corrected"] is not None:
        axes.plot(*np.array(data["corrected"]).T, color=OBTAINED, lw=1.6, label="avec vos pas corrigés")
    axes.plot(0, 0, "o", color=ink_of(axes), ms=7, label="départ")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (m)", ylabel="y (m)", title="Cent vingt scans dans le laboratoire d'Intel")
    figure.legend(loc="outside lower center", ncols=2)


FIGURES = {
    STEPS: (
        draw_steps,
        "Vue de dessus en mètres, départ à l’origine et cap vers la droite : chaque trait mène au bout d’un pas, sa "
        "flèche est le cap d’arrivée. En pointillés, les pas comptés ; en bleu épais, les pas corrigés attendus ; "
        "en orange, les vôtres.",
    ),
    PATHS: (
        draw_paths,
        "Vue de dessus en mètres de cent vingt poses dans le laboratoire d’Intel : en bleu, les poses du journal ; "
        "en vert, l’odométrie telle quelle ; en orange, la trajectoire avec vos pas corrigés, qui devrait suivre la "
        "bleue.",
    ),
}
