"""What is promised of `gonfler`, `cout` and `planifier`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import OtherForm
from graders.core.compare.forms import GRID, NOTHING, NUMBER, TEXT, AcceptedVariant, ArrayForm, RefusedAnswer, array
from graders.core.contract.values import Value
from graders.l20.planifier.truth import UNKNOWN, WALL, best_path


def paths(value: Value) -> Iterator[AcceptedVariant]:
    """Yield a path in each of its forms."""
    cells = [(int(i), int(j)) for i, j in value]
    yield AcceptedVariant("une liste de couples", cells)
    yield AcceptedVariant("une liste de listes", [list(cell) for cell in cells])
    yield AcceptedVariant("un tuple", tuple(cells))
    yield AcceptedVariant("un tableau", np.array(cells, dtype=np.int64).reshape(-1, 2))
    yield AcceptedVariant("des flottants entiers", np.array(cells, dtype=np.float64).reshape(-1, 2))
    if not cells:
        yield AcceptedVariant("un tableau vide à une dimension", np.array([]))


def no_paths(value: Value) -> Iterator[RefusedAnswer]:
    named = ("forme", "cases", "couple")
    yield from (NOTHING, TEXT)
    yield RefusedAnswer("un seul nombre", 1.0, named)
    yield RefusedAnswer("des cases de trois nombres", [(0, 0, 0)], named)
    yield RefusedAnswer("des nombres qui ne sont pas entiers", [(0.5, 0.5)], named)


def is_cell(value: Value) -> bool:
    return type(value) is tuple and len(value) == 2 and all(type(item) is int for item in value)


CELL = OtherForm(told="un couple (ligne, colonne) d’entiers", given=is_cell)
PATH = OtherForm(
    told="la liste des cases, des couples (ligne, colonne)",
    accepts="liste, tuple ou tableau (n, 2), de couples, de listes ou de tableaux ; sans chemin, une liste ou un "
    "tableau vide",
    given=lambda value: type(value) is list and bool(value) and all(map(is_cell, value)),
    recasts=paths,
    outsiders=no_paths,
    precision="Jugé par la validité du chemin et par son prix, à 10⁻⁹ près : à prix égal, tous conviennent.",
)
MAP = ArrayForm(shape=("H", "W"), dtype="int64")

CONTRACTS = (
    FunctionContract(
        "gonfler",
        {"grille": MAP, "rayon": NUMBER, "resolution": NUMBER},
        GRID,
        (
            Boundary("un rayon nul", lambda grid, radius, side: radius == 0.0),
            Boundary("un rayon plus grand que la grille", lambda grid, radius, side: radius > side * max(grid.shape)),
            Boundary("un mur au bord, un mur dans un coin", lambda grid, radius, side: bool(grid[0, -1] == WALL)),
            Boundary("des cases inconnues", lambda grid, radius, side: bool(np.any(grid == UNKNOWN))),
            Boundary("une seule ligne", lambda grid, radius, side: len(grid) == 1),
            Boundary("un rayon égal à une distance", free="il n’est pas demandé : > comme ≥"),
            Boundary("une carte sans mur", free="elle n’est pas demandée"),
        ),
    ),
    FunctionContract(
        "cout",
        {"chemin": PATH, "couts": array("H", "W")},
        NUMBER,
        (
            Boundary("une seule case", lambda path, costs: len(path) == 1),
            Boundary("un seul pas, droit ou oblique", lambda path, costs: len(path) == 2),
            Boundary("une case où l’on repasse", lambda path, costs: len(set(path)) < len(path)),
            Boundary("des coûts tous nuls", lambda path, costs: not costs.any()),
            Boundary("un chemin vide", free="il n’est pas demandé"),
        ),
    ),
    FunctionContract(
        "planifier",
        {"permises": GRID, "couts": array("H", "W"), "depart": CELL, "but": CELL},
        PATH,
        (
            Boundary("pas de chemin", lambda free, costs, start, goal: not best_path(free, costs, start, goal)),
            Boundary("un départ ou un but interdit", lambda free, costs, start, goal: not free[start]),
            Boundary("un départ qui est le but", lambda free, costs, start, goal: start == goal),
            Boundary("une grille d’une seule case", lambda free, costs, start, goal: free.size == 1),
            Boundary("des coûts tous nuls", lambda free, costs, start, goal: not costs.any()),
            Boundary("une carte sans murs au bord", lambda free, costs, start, goal: bool(free.all())),
            Boundary("plusieurs chemins de même prix", free="n’importe lequel"),
        ),
    ),
)
