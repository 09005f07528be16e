"""The figure of l20/noeud_ros: the scan that was judged, beam by beam, with the window and the two bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.l20.noeud_ros.scenes import HALF
from graders.plotting import EXPECTED, OBTAINED, ink_of

#: Metres above which a reading is drawn at the top: the threshold must be seen.
TOP = 1.2


def draw_scan(figure: Figure, data: dict[str, Any]) -> None:
    ranges = np.array([float(value) for value in data["ranges"]])
    middle, beams = len(ranges) // 2, np.arange(len(ranges))
    top = max(TOP, 1.3 * data["distance"])
    with np.errstate(invalid="ignore"):
        valid = (ranges > data["range_min"]) & (ranges < data["range_max"])
        near = valid & (ranges < data["distance"]) & (beams >= middle - HALF) & (beams < middle + HALF)
    axes = figure.subplots()
    ink = ink_of(axes)
    axes.axvspan(middle - HALF - 0.5, middle + HALF - 0.5, color=EXPECTED, alpha=0.15, lw=0, label="les 20 du milieu")
    axes.axhline(data["distance"], color=OBTAINED, lw=1.6, ls="--", label="distance_min")
    if data["range_max"] < top:
        axes.axhline(data["range_max"], color=ink, lw=1.2, ls=":", label="range_max")
    heights = np.minimum(np.nan_to_num(ranges, nan=top, posinf=top), top)
    kinds = (
        (valid & ~near, "o", ink, "distances"),
        (near, "o", OBTAINED, "trop près"),
        (~valid, "x", ink, "nan, inf, au-delà de range_max"),
    )
    for chosen, marker, colour, name in kinds:
        if np.any(chosen):
            axes.plot(beams[chosen], heights[chosen], marker, color=colour, ms=5, label=name)
    axes.set(xlabel="numéro du rayon", ylabel="distance (m), coupée en haut", ylim=(0.0, 1.06 * top))
    figure.suptitle(f"Attendu : {data['expected']}\nObtenu : {data['got']}", fontsize=11)
    figure.legend(loc="outside lower center", ncols=3)


FIGURES = {
    "scan": (
        draw_scan,
        "Distance en mètres selon le numéro du rayon ; la bande bleue couvre les vingt rayons du milieu, le trait "
        "orange en tirets est distance_min. Les points orange sont trop près, les croix sont des lectures à ignorer "
        "; le titre dit ce que l’on attend du nœud et ce qu’il a fait.",
    ),
}
