"""Figures of l20/icp_droite: a wall with its normals, and pairs with what is measured across the walls."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.l20.icp_droite.pictures import NORMALS, PAIRS
from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of


def draw_normals(figure: Figure, data: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    points, expected = np.array(data["points"]), np.array(data["expected"])
    axes.plot(*points.T, "o-", color=ink_of(axes), lw=1.0, ms=5, label="points du mur, dans l'ordre")
    size = 0.35 * max(1.0, 0.5 * float(np.ptp(points, axis=0).max()))
    for k, (rows, colour, width) in enumerate(((expected, EXPECTED, 4.0), (data["got"], OBTAINED, 1.8))):
        if rows is None:
            continue
        aligned = np.array(rows)
        aligned = aligned * np.where(np.sum(aligned * expected, axis=1) < 0.0, -1.0, 1.0)[:, None]
        tips = points + size * np.clip(aligned, -4.0, 4.0)
        for point, tip in zip(points, tips, strict=True):
            axes.plot(*np.array([point, tip]).T, color=colour, lw=width, solid_capstyle="butt")
        axes.plot([], [], color=colour, lw=width, label=("attendues", "obtenues")[k])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.set(xlabel="x (m)", ylabel="y (m)", title="Les normales du mur")
    figure.legend(loc="outside lower center", ncols=3)


def draw_pairs(figure: Figure, data: dict[str, Any]) -> None:
    """Each target with the line that it lies on, each point with its gap across that line, and the centre."""
    axes = figure.add_subplot()
    P, Q, N = (np.array(data[name]) for name in ("P", "Q", "N"))
    along = np.column_stack([-N[:, 1], N[:, 0]])
    size = 0.3 * max(1.0, float(np.ptp(np.vstack([P, Q]), axis=0).max()) / 3.0)
    feet = P - np.sum(N * (P - Q), axis=1)[:, None] * N
    for p, q, t, foot in zip(P, Q, along, feet, strict=True):
        reach = size + abs(float(t @ (foot - q)))
        axes.plot(*np.array([q - reach * t, q + reach * t]).T, color=ink_of(axes), lw=1.2)
        axes.plot(*np.array([p, foot]).T, color=THIRD, lw=2.6)
    axes.plot(*Q.T, "s", color=ink_of(axes), mfc="none", ms=8, label="Q, et la droite de chacun")
    axes.plot(*P.T, "o", color=EXPECTED, ms=6, label="P")
    axes.plot(*data["centre"], "+", color=EXPECTED, ms=14, mew=2, label="centre de P")
    axes.plot([], [], color=THIRD, lw=2.6, label="écarts r")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set(xlabel="x (m)", ylabel="y (m)", title="Les écarts, en travers des murs")
    figure.legend(loc="outside lower center", ncols=4)


FIGURES = {
    NORMALS: (
        draw_normals,
        "Vue de dessus en mètres : les points du mur, reliés dans l’ordre, et la normale en chacun. Les traits "
        "bleus épais sont les normales attendues, les traits orange celles de votre programme ; leur sens n’est pas "
        "montré.",
    ),
    PAIRS: (
        draw_pairs,
        "Vue de dessus en mètres : les points P (ronds bleus), leur centre (croix bleue), et les points Q (carrés) "
        "avec la droite du mur où est chacun. Les traits verts sont les écarts attendus, de P à la droite, en "
        "travers du mur.",
    ),
}
