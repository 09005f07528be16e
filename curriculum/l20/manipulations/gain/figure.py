"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from curriculum.l20.manipulations.gain import scene
from graders.plotting import Palette


def draw(figure: Figure, palette: Palette) -> None:
    """The three bells with which the manipulation begins."""
    spread, noise = scene.PARAMETERS["prediction"].default, scene.PARAMETERS["mesure"].default
    gain = spread**2 / (spread**2 + noise**2)
    mean = scene.PREDICTED + gain * (scene.MEASURED - scene.PREDICTED)
    x = np.linspace(0.0, scene.LENGTH, 401)
    axes = figure.subplots()
    axes.plot(x, norm.pdf(x, scene.PREDICTED, spread), "--", color=palette.second, label="prédiction")
    axes.plot(x, norm.pdf(x, scene.MEASURED, noise), color=palette.measure, label="mesure")
    axes.plot(x, norm.pdf(x, mean, noise * np.sqrt(gain)), color=palette.estimate, label="croyance corrigée")
    axes.set(xlabel="abscisse (m)", yticks=[], xlim=(0.0, scene.LENGTH), ylim=(0.0, None))
    axes.legend(frameon=False, fontsize=9)


FIGURES = {
    "manipulation-gain": (
        draw,
        "Trois cloches au-dessus d’un couloir de dix mètres : la prédiction, large, centrée en 5 mètres ; la mesure, "
        "plus étroite, en 5,6 mètres ; entre les deux, plus près de la mesure, la croyance corrigée, la plus haute.",
        (6.4, 3.0),
    ),
}
