"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from curriculum.l20.manipulations.elastique import scene
from graders.plotting import Palette


def draw(figure: Figure, palette: Palette) -> None:
    """The deviation of each pose of twenty links, before and after the closure."""
    k, one, end = np.arange(21), 0.1**2, 0.1**2
    so, all_ = k * one, 20 * one
    axes = figure.subplots()
    axes.plot(k, 100.0 * np.sqrt(so), "--", color=palette.second, label="sans fermeture")
    axes.plot(k, 100.0 * np.sqrt(so * (all_ - so + end) / (all_ + end)), color=palette.estimate, label="fermée")
    axes.plot(k, 100.0 * scene.GAP * so / (all_ + end), ":", color=palette.measure, label="glissement de la pose")
    axes.set(xlabel="pose", ylabel="cm", xlim=(0, 20), ylim=(0, 105))
    axes.legend(frameon=False, fontsize=9)


FIGURES = {
    "manipulation-elastique": (
        draw,
        "L’écart-type de chaque pose d’une chaîne de vingt maillons. Sans fermeture, il croît comme la racine du rang. "
        "Avec une fermeture, il monte jusqu’au milieu, puis redescend. Le glissement, lui, croît en ligne droite.",
        (6.4, 3.2),
    ),
}
