"""Figures of l20/icp: where the cloud starts, where it must end, where it has ended, and its pairs there."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.plotting import EXPECTED, OBTAINED, ink_of


def draw_clouds(figure: Figure, data: dict[str, Any]) -> None:
    """Both clouds; P moved as expected, with a dotted line from each point to its last partner; P as obtained."""
    axes = figure.add_subplot()
    ink = ink_of(axes)
    Q, start, expected = (np.array(data[name], dtype=float) for name in ("Q", "P", "expected"))
    pairs = np.array(data["pairs"], dtype=int)
    for point, partner in zip(expected, Q[pairs], strict=True):
        axes.plot(*np.stack([point, partner]).T, color=EXPECTED, lw=1.6, ls=":")
    dots: dict[str, Any] = {"ls": "none", "marker": "o"}
    axes.plot(*Q.T, ls="none", marker="s", mfc="none", color=ink, ms=10, label="Q")
    axes.plot(*start.T, **dots, mfc="none", color=ink, ms=5, alpha=0.6, label="P au départ")
    axes.plot(*expected.T, **dots, color=EXPECTED, ms=7, label="P attendu")
    if data["got"]:
        axes.plot(*np.array(data["got"], dtype=float).T, **dots, color=OBTAINED, ms=4.5, label="P obtenu")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set(xlabel="x", ylabel="y", title="Le nuage P, au départ et à l’arrivée")
    figure.legend(loc="outside lower center", ncols=4)


FIGURES = {
    "clouds": (
        draw_clouds,
        "Plan x, y : le nuage Q en carrés vides et le nuage P au départ en ronds vides. En ronds bleus, P là où on "
        "l’attend, avec des pointillés vers ses partenaires de Q ; en ronds orange, P là où votre programme le "
        "place.",
    ),
}
