"""The figure of l20/association: gates of the landmarks, measurements, pairs expected and obtained."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.l19.ellipses import ellipse
from graders.l20.association.pictures import SCAN
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of


def draw_scan(figure: Figure, data: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    ink, z, landmarks = ink_of(axes), np.array(data["z"]), np.array(data["landmarks"])
    for k, (place, gate) in enumerate(zip(landmarks, data["gates"], strict=True)):
        contour = ellipse(np.array(gate))
        if contour is not None:
            axes.plot(*(place + contour).T, color=ink, lw=0.9, ls="--", label="portes" if k == 0 else "_")
        axes.annotate(str(k), place, textcoords="offset points", xytext=(7, -14), color=ink)
    for name, colour, width in (("expected", EXPECTED, 4.0), ("got", OBTAINED, 1.8)):
        for i, k in enumerate(data[name] or []):
            if k >= 0:
                axes.plot(*np.array([z[i], landmarks[k]]).T, color=colour, lw=width)
        axes.plot([], [], color=colour, lw=width, label="paires attendues" if name == "expected" else "obtenues")
    axes.plot(*landmarks.T, "s", color=ink, ms=8, label="amers", ls="none")
    axes.plot(*z.T, "X", color=THIRD, ms=10, label="mesures", ls="none")
    for i, place in enumerate(z):
        axes.annotate(str(i), place, textcoords="offset points", xytext=(7, 6), color=THIRD)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (m)", ylabel="y (m)", title="Qui va avec qui ?")
    figure.legend(loc="outside lower center", ncols=3)


FIGURES = {
    SCAN: (
        draw_scan,
        "Vue de dessus en mètres : les amers (carrés numérotés), leurs portes en tirets et les mesures (croix "
        "vertes numérotées). Un trait bleu épais joint chaque mesure à l’amer attendu ; un trait orange plus fin, à "
        "celui que votre programme a choisi.",
    ),
}
