"""Figures of l20/defi_robuste: the map with its false edges beside the true one, the weights; and a graph in pieces."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graders.plotting import EXPECTED, OBTAINED, THIRD, ink_of

PIECES = (EXPECTED, OBTAINED, THIRD, "#7747c2", "#b3202c")
ALERT = "#c8323e"


def draw_robust(figure: Figure, data: dict[str, Any]) -> None:
    """Left: the true places, those of plain least squares, those obtained. Right: the weight of each loop closure."""
    left, right = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
    _draw_map(left, data)
    _draw_weights(right, data)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _draw_map(axes: Axes, data: dict[str, Any]) -> None:
    truth, plain = np.array(data["truth"]), np.array(data["plain"])
    axes.plot(truth[:, 0], truth[:, 1], "-o", color=EXPECTED, ms=3.5, lw=1.4, label="vérité")
    axes.plot(plain[:, 0], plain[:, 1], "-", color=ink_of(axes), lw=1.0, alpha=0.5, label="moindres carrés")
    if data["got"] is not None:
        got = np.array(data["got"])
        if np.abs(got[:, :2]).max() < 6.0 * np.abs(truth[:, :2]).max():
            axes.plot(got[:, 0], got[:, 1], "--o", color=OBTAINED, ms=3.0, lw=1.4, label="obtenu")
    for (i, j), lies in zip(data["edges"], data["false"], strict=True):
        if lies:
            axes.plot(truth[[i, j], 0], truth[[i, j], 1], ":", color=ALERT, lw=2.2)
    axes.plot([], [], ":", color=ALERT, lw=2.2, label="fausse arête")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title("La carte", fontsize=10)


def _draw_weights(axes: Axes, data: dict[str, Any]) -> None:
    closures = [k for k, (i, j) in enumerate(data["edges"]) if abs(i - j) != 1]
    names = ["{} → {}".format(*data["edges"][k]) for k in closures]
    weights = [0.0 if data["weights"] is None else data["weights"][k] for k in closures]
    colours = [ALERT if data["false"][k] else EXPECTED for k in closures]
    axes.barh(np.arange(len(closures)), weights, 0.7, color=colours)
    axes.set_yticks(np.arange(len(closures)), names)
    for label, k in zip(axes.get_yticklabels(), closures, strict=True):
        if data["false"][k]:
            label.set_color(ALERT)
    axes.axvline(0.1, color=ink_of(axes), lw=0.8, ls="--")
    axes.set_ylim(len(closures) - 0.4, -0.6)
    axes.set_xlim(min(0.0, *weights) * 1.05, max(1.05, *weights) * 1.02)
    axes.grid(axis="y", visible=False)
    title = "Les poids (rouge : fausse)" if data["weights"] is not None else "Aucun poids à montrer"
    axes.set_title(title, fontsize=10)


def draw_pieces(figure: Figure, data: dict[str, Any]) -> None:
    """The graph, a colour for each piece."""
    axes = figure.subplots()
    poses, edges = np.array(data["poses"]), data["edges"]
    piece = list(range(len(poses)))
    for i, j in edges:
        old, new = piece[j], piece[i]
        piece = [new if one == old else one for one in piece]
    order = sorted(set(piece))
    for i, j in edges:
        colour = PIECES[order.index(piece[i]) % len(PIECES)]
        axes.plot(poses[[i, j], 0], poses[[i, j], 1], color=colour, lw=1.8)
    for k, (x, y, _) in enumerate(poses):
        axes.plot(x, y, "o", color=PIECES[order.index(piece[k]) % len(PIECES)], ms=9)
        axes.annotate(f"{k}", (x, y), textcoords="offset points", xytext=(8, 6), color=ink_of(axes))
    count = len(order)
    pieces = "un seul morceau" if count == 1 else f"{count} morceaux"
    got = "" if data["got"] is None else f" ; obtenu : {data['got']:g}".replace(".", ",")
    axes.set_title(f"Un graphe en {pieces} : on attend {data['expected']}{got}", fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.2)


FIGURES = {
    "robuste": (
        draw_robust,
        "À gauche, la carte vue de dessus : la vérité en bleu, les moindres carrés en gris, votre résultat en "
        "tirets orange, les fausses arêtes en pointillés rouges. À droite, le poids que vous donnez à chaque "
        "fermeture : proche de 1 si elle est vraie (bleu), sous le trait à 0,1 si elle est fausse (rouge).",
    ),
    "pieces": (
        draw_pieces,
        "Le graphe vu de dessus, une couleur par morceau relié : les poses sont des ronds numérotés, les arêtes des "
        "traits. Le titre dit combien de morceaux on attend et ce que votre programme a renvoyé.",
    ),
}
