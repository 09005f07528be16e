"""Figures of l20/tf_date: a pose between those that are known, and the chain of frames at the date of a scan."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.core.compare.words import number
from graders.l20.tf_date.pictures import BETWEEN, CHAIN
from graders.plotting import EXPECTED, OBTAINED, ink_of
from graders.robotics.frames import draw_frame


def draw_between(figure: Figure, data: dict[str, Any]) -> None:
    """The poses that are known in ink, the one that is asked, and the one that came back."""
    axes = figure.add_subplot()
    known = np.asarray(data["known"], dtype=float)
    ink = ink_of(axes)
    size = _size(known[:, :2])
    axes.plot(*known[:, :2].T, ":", color=ink, lw=1.2, label="poses connues")
    for pose in known:
        draw_frame(axes, pose, size, ink)
    draw_frame(axes, data["expected"], 1.3 * size, EXPECTED)
    axes.plot([], [], color=EXPECTED, lw=2.2, label="attendue")
    if data["got"] is not None:
        draw_frame(axes, data["got"], size, OBTAINED)
        axes.plot([], [], color=OBTAINED, lw=2.2, label="obtenue")
    _finish(figure, axes, "Entre deux poses : la flèche longue est le cap")


def draw_chain(figure: Figure, data: dict[str, Any]) -> None:
    """Each frame on the way, seen from the target; the last one is what is asked."""
    axes = figure.add_subplot()
    ink = ink_of(axes)
    poses = np.array([[0.0, 0.0, 0.0], *(pose for _, pose in data["frames"])], dtype=float)
    names = [data["target"], *(name for name, _ in data["frames"])]
    size = _size(poses[:, :2])
    axes.plot(*poses[:, :2].T, ":", color=ink, lw=1.2)
    for k, (name, pose) in enumerate(zip(names, poses, strict=True)):
        draw_frame(axes, pose, size, EXPECTED if k == len(names) - 1 else ink)
        axes.annotate(name, pose[:2], textcoords="offset points", xytext=(6, -13), color=ink, fontsize=9)
    axes.plot([], [], color=EXPECTED, lw=2.2, label=f"{data['source']}, attendu")
    if data["got"] is not None:
        draw_frame(axes, data["got"], size, OBTAINED)
        axes.plot([], [], color=OBTAINED, lw=2.2, label=f"{data['source']}, obtenu")
    _finish(figure, axes, f"Les repères vus de « {data['target']} », à la date {number(data['date'])}")


def _size(places: np.ndarray[Any, Any]) -> float:
    return max(0.18 * float(np.max(np.ptp(places, axis=0))), 0.25)


def _finish(figure: Figure, axes: Axes, title: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title)
    figure.legend(loc="outside lower center", ncols=3)


FIGURES = {
    BETWEEN: (
        draw_between,
        "Vue de dessus en mètres : les poses connues, de la couleur du texte, reliées par des pointillés. Le repère "
        "bleu est la pose attendue à la date demandée, le repère orange celle de votre programme ; la flèche longue "
        "de chacun est le cap.",
    ),
    CHAIN: (
        draw_chain,
        "Vue de dessus en mètres : les repères de la chaîne, nommés, vus du repère cible et reliés par des "
        "pointillés. Le dernier est en bleu là où on l’attend, en orange là où votre programme le place.",
    ),
}
