"""What stands where this manipulation would be, for who has no script."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from curriculum.l20.manipulations.faisceau import scene
from graders.plotting import Palette
from reference.sensors.beam import BeamModel, plain_densities
from reference.sensors.plain_beam_learning import plain_em_round

ROUNDS = 30


def draw(figure: Figure, palette: Palette) -> None:
    """The ranges, and what the mixture that EM finds foresees of them."""
    read, expected = scene.readings(), np.full(scene.COUNT, scene.EXPECTED)
    model = BeamModel(scene.REACH, 0.25, 0.25, 0.25, 0.25, 1.0, 1.0)
    for _ in range(ROUNDS):
        model = plain_em_round(model, read, expected)
    axes = figure.subplots()
    z = np.linspace(0.0, scene.REACH, 600, endpoint=False)
    foreseen = scene.COUNT * scene.BIN * (model.shares @ plain_densities(model, z, np.full(z.shape, scene.EXPECTED)))
    edges = np.arange(0.0, scene.REACH + scene.BIN, scene.BIN)
    axes.hist(read[read < scene.REACH], edges, color=palette.measure, alpha=0.5, label="lectures")
    axes.bar(scene.REACH + 0.5, np.sum(read >= scene.REACH), scene.BIN, color=palette.second, label="rien vu")
    axes.plot(z, foreseen, color=palette.estimate, label="mélange trouvé par EM")
    axes.set(xlabel="distance lue, en cases", ylabel="lectures", xlim=(0.0, scene.REACH + 1.0))
    axes.set_yscale("function", functions=(np.sqrt, np.square))
    axes.legend(frameon=False, fontsize=9)


FIGURES = {
    "manipulation-faisceau": (
        draw,
        "L’histogramme de quatre cents distances lues par un rayon qui en attend cinq : un pic serré à cinq, une pente "
        "qui descend depuis zéro, un fond presque plat, une barre à part pour celles qui n’ont rien vu. La courbe du "
        "mélange que trouve EM épouse les quatre.",
        (6.4, 3.2),
    ),
}
