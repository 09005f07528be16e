"""Figures of declared exercises, from the data of `figure_data`. Loads matplotlib: never on the path of a verdict."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from graders.core.declared.figure_data import CURVE, GRID, POINTS
from graders.plotting import EXPECTED, OBTAINED, ink_of

#: Cells of a grid in which their numbers are written.
WRITTEN_CELLS = 64
CELL_TOLERANCE = 1e-6


def draw_curve(figure: Figure, data: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    x, y = data["expected"]
    marker = "o" if len(x) <= 60 else ""
    axes.plot(x, y, color=EXPECTED, marker=marker, markersize=5, label="attendu")
    if data["got"]:
        x, y = data["got"]
        axes.plot(x, y, color=OBTAINED, marker="x" if marker else "", linestyle="--", label="obtenu")
    axes.set_title(data["title"])
    axes.legend()


def draw_points(figure: Figure, data: dict[str, Any]) -> None:
    axes = figure.add_subplot()
    x, y = np.transpose(data["expected"][0])
    axes.scatter(x, y, color=EXPECTED, marker="o", s=42, label="attendu")
    if data["got"]:
        x, y = np.transpose(data["got"][0])
        axes.scatter(x, y, color=OBTAINED, marker="x", s=42, label="obtenu")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(data["title"])
    axes.legend()


def draw_grid(figure: Figure, data: dict[str, Any]) -> None:
    """Both grids side by side; a cross marks the cells that differ."""
    grids = {"attendu": np.array(data["expected"][0])}
    if data["got"]:
        grids["obtenu"] = np.array(data["got"][0])
    numbers = np.concatenate([grid.ravel() for grid in grids.values()])
    low, high = float(numbers.min()), float(numbers.max())
    figure.suptitle(data["title"])
    for place, (name, grid) in enumerate(grids.items(), 1):
        axes = figure.add_subplot(1, len(grids), place)
        axes.imshow(grid, vmin=low, vmax=high if high > low else low + 1.0, cmap="cividis")
        axes.grid(visible=False)
        axes.set_title(name)
        axes.set_xlabel("colonne")
        axes.set_ylabel("ligne")
        if grid.size <= WRITTEN_CELLS:
            middle = (low + high) / 2
            for (row, column), number in np.ndenumerate(grid):
                colour = "white" if number <= middle else "black"
                axes.text(column, row, f"{number:.3g}".replace(".", ","), ha="center", va="center", color=colour)
        if name == "obtenu":
            wrong = np.argwhere(np.abs(grid - grids["attendu"]) > CELL_TOLERANCE)
            axes.scatter(wrong[:, 1], wrong[:, 0], marker="s", s=260, facecolors="none", edgecolors=OBTAINED, lw=2)
            axes.title.set_color(ink_of(axes))


FIGURES = {
    CURVE: (
        draw_curve,
        "Courbe des nombres de la réponse : en bleu, trait plein, les valeurs attendues ; en orange, en tirets, "
        "celles de votre programme, si elles se dessinent. Les deux courbes devraient se superposer.",
    ),
    POINTS: (
        draw_points,
        "Points du plan, à la même échelle en x et en y : des ronds bleus aux places attendues, des croix orange à "
        "celles que donne votre programme. Chaque croix devrait tomber sur un rond.",
    ),
    GRID: (
        draw_grid,
        "Deux tableaux côte à côte, lignes de haut en bas et colonnes de gauche à droite : la réponse attendue, "
        "puis celle de votre programme. Plus une case est claire, plus son nombre est grand ; un carré orange "
        "entoure chaque case qui diffère.",
    ),
}
