"""Figures of l20/kabsch: the clouds, P moved by the best transformation and by the student's, and what is left to Q."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from graders.plotting import EXPECTED, OBTAINED, ink_of

Floats = NDArray[np.float64]

READABLE = 6
"""Clouds of more points are drawn without numbers nor outline."""


def draw_clouds(figure: Figure, data: dict[str, Any]) -> None:
    """One panel in the plane; in space, the clouds seen from above and from the front."""
    clouds = {name: np.array(data[name], dtype=float) for name in ("P", "Q", "expected", "got") if data[name]}
    plane = clouds["P"].shape[1] == 2
    views = [("x", "y", "")] if plane else [("x", "y", "vu de dessus"), ("x", "z", "vu de face")]
    panels = figure.subplots(1, len(views), squeeze=False)[0]
    for axes, (right, up, name) in zip(panels, views, strict=True):
        seen = {key: cloud[:, ["xyz".index(right), "xyz".index(up)]] for key, cloud in clouds.items()}
        _panel(axes, seen)
        axes.set(xlabel=right, ylabel=up, title=name)
    best = "la meilleure" if data["unique"] else "une des meilleures"
    figure.suptitle(f"Le nuage P, déplacé par {best} transformation et par la vôtre", fontsize=11)
    handles, labels = panels[0].get_legend_handles_labels()
    handles.append(Line2D([], [], color=ink_of(panels[0]), lw=2.0, ls=":"))
    figure.legend(handles, [*labels, "écart à Q"], loc="outside lower center", ncols=5)


def _panel(axes: Axes, clouds: dict[str, Floats]) -> None:
    ink = ink_of(axes)
    _cloud(axes, clouds["P"], "P", {"marker": "o", "mfc": "none", "color": ink, "alpha": 0.6, "ms": 5.5})
    _cloud(axes, clouds["Q"], "Q", {"marker": "s", "mfc": "none", "color": ink, "ms": 10})
    _moved(axes, clouds, "expected", "R p + t attendu", EXPECTED, 7.0)
    if "got" in clouds:
        _moved(axes, clouds, "got", "R p + t obtenu", OBTAINED, 4.5)
    if len(clouds["P"]) <= READABLE:
        _number(axes, clouds["P"], ink, 0.6, (5, -12))
        _number(axes, clouds["Q"], ink, 1.0, (7, 6))
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.14)


def _moved(axes: Axes, clouds: dict[str, Floats], key: str, label: str, colour: str, size: float) -> None:
    """A moved cloud, and a dotted line from each of its points to its partner in Q."""
    for point, partner in zip(clouds[key], clouds["Q"], strict=True):
        axes.plot(*np.stack([point, partner]).T, color=colour, lw=2.0, ls=":")
    _cloud(axes, clouds[key], label, {"marker": "o", "color": colour, "ms": size})


def _cloud(axes: Axes, cloud: Floats, label: str, style: dict[str, Any]) -> None:
    """The points, joined in their order by a faint line when there are few of them."""
    if len(cloud) <= READABLE:
        axes.plot(cloud[:, 0], cloud[:, 1], lw=0.9, alpha=0.4, color=style["color"])
    axes.plot(cloud[:, 0], cloud[:, 1], ls="none", label=label, **style)


def _number(axes: Axes, cloud: Floats, colour: str, alpha: float, offset: tuple[int, int]) -> None:
    """Number the points; those seen at one place share a label."""
    places: dict[tuple[float, ...], list[str]] = {}
    for i, point in enumerate(cloud):
        places.setdefault(tuple(np.round(point, 6)), []).append(str(i))
    for place, names in places.items():
        style: dict[str, Any] = {
            "xytext": offset,
            "textcoords": "offset points",
            "color": colour,
            "alpha": alpha,
            "fontsize": 8.5,
        }
        axes.annotate(" et ".join(names), (place[0], place[1]), **style)


FIGURES = {
    "clouds": (
        draw_clouds,
        "Les nuages P (ronds vides) et Q (carrés vides), dans le plan ou vus de dessus et de face. En bleu, P "
        "déplacé par la meilleure transformation ; en orange, P déplacé par la vôtre ; les pointillés sont les "
        "écarts de chacun à Q.",
    ),
}
