"""La carte du module, comme la trousse la dessine : une case y mesure une unité, la ligne 0 est en haut."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import numpy as np

from graders.core.syntax_trees import parse_source
from graders.scene.replay import Grid, Segments, View, decimal
from reference.world.grid_map import GridMap

KIT = Path(__file__).parents[1] / "kit" / "l20.py"


@cache
def carte() -> GridMap:
    """Le plan de la trousse."""
    module = parse_source(KIT.read_text(encoding="utf-8"))
    values = {
        target.id: node.value
        for node in module.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    return GridMap.from_text(ast.literal_eval(values["PLAN"]))


def murs() -> Grid:
    return Grid(~carte().free, "walls")


def vue() -> View:
    height, width = carte().shape
    return View(0, 0, width, height)


def plus_proche_libre(x: float, y: float, marge: float = 0.3) -> tuple[float, float]:
    """Le point libre le plus proche de (x, y), à `marge` d'un mur au moins quand la case le permet."""
    free = carte().free
    rows, columns = np.nonzero(free)
    height, width = free.shape
    padded = np.pad(~free, 1, constant_values=True)

    def clamped(values, cells, before, after):
        low = cells + np.where(before, marge, 0.0)
        high = cells + 1.0 - np.where(after, marge, 0.0)
        return np.clip(values, low, high)

    left, right = padded[rows + 1, columns], padded[rows + 1, columns + 2]
    above, below = padded[rows, columns + 1], padded[rows + 2, columns + 1]
    near_x, near_y = clamped(x, columns, left, right), clamped(y, rows, above, below)
    best = int(np.argmin((near_x - x) ** 2 + (near_y - y) ** 2))
    return float(min(near_x[best], width - 1e-6)), float(min(near_y[best], height - 1e-6))


def milliers(nombre: float) -> str:
    """« 3 851 » : un nombre entier, ses milliers séparés."""
    return f"{nombre:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def pluriel(nombre: int, un: str, plusieurs: str) -> str:
    """« 1 rayon », « 3 rayons » : le nombre et le mot qui va avec."""
    return f"{nombre} {un if nombre < 2 else plusieurs}"


@cache
def contours() -> Segments:
    """Le trait fin qui sépare les cases libres des murs."""
    free = np.pad(carte().free, 1)
    rows, columns = np.nonzero(free[1:] != free[:-1])
    across = np.column_stack([columns - 1, rows, columns, rows])
    rows, columns = np.nonzero(free[:, 1:] != free[:, :-1])
    down = np.column_stack([columns, rows - 1, columns, rows])
    ends = np.vstack([across, down])
    return Segments(ends[:, :2], ends[:, 2:], "truth", width=1.2, opacity=0.6)


def en_cases(longueur: float, decimales: int = 2) -> str:
    """« 0,4 case », « 2,0 cases » : une longueur et son unité."""
    return f"{decimal(longueur, decimales)} {'cases' if round(longueur, decimales) >= 2.0 else 'case'}"
