"""Is an answer a cheapest path? It may be any of them: what is looked at is whether it can be walked, and its price."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from graders.core.compare.comparison import Mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20.planifier.truth import Cell, Grid, best_path, right_price

#: Of a price, relative, and absolute below one.
TOLERANCE = 1e-9
SHAPE = "On attend une liste de cases, chacune un couple (ligne, colonne)."
#: The faults of a path, in the order in which they are looked for; a path without any is a cheapest one.
KINDS = ("forme", "vide", "impossible", "depart", "but", "dehors", "interdite", "saut", "sur_place", "coin", "cher")


class FaultyPathError(Exception):
    """What is wrong with a path: `kind` of KINDS, and why in French. `price`: of a path that can be walked."""

    def __init__(self, kind: str, message: str, price: float | None = None) -> None:
        super().__init__(message)
        self.kind, self.message, self.price = kind, message, price


def read_path(value: Value) -> list[Cell]:
    """The cells of an answer. Raises UnreadableError for what holds no numbers, FaultyPathError for other numbers."""
    if value is None:
        raise UnreadableError("la fonction n'a rien renvoyé (None) : sans chemin, on attend une liste vide []")
    cells = read_array(value)
    if cells.size == 0 and cells.ndim in (1, 2):
        return []
    if cells.ndim != 2 or cells.shape[1] != 2 or not np.all(np.isfinite(cells)) or np.any(cells != np.round(cells)):
        raise FaultyPathError("forme", SHAPE)
    return [(int(i), int(j)) for i, j in cells.tolist()]


def mismatch_of(args: Arguments, value: Value) -> Mismatch | None:
    """What is wrong with an answer; None where it is a cheapest path."""
    try:
        check_path(args, read_path(value))
    except UnreadableError as error:
        return unreadable(error)
    except FaultyPathError as fault:
        return Mismatch(fault.message, "forme" if fault.kind == "forme" else None, Outcome.WRONG_ANSWER)
    return None


def check_path(args: Arguments, path: Sequence[Cell]) -> None:
    """Raises FaultyPathError."""
    permitted, costs, start, goal = args
    best = best_path(permitted, costs, start, goal)
    if not best:
        if path:
            raise FaultyPathError("impossible", "Il n'y a pas de chemin : on attend une liste vide.")
        return
    if not path:
        raise FaultyPathError("vide", "Il y a un chemin, et la fonction renvoie une liste vide.")
    _check_ends(path, start, goal)
    _check_walk(permitted, path)
    price, least = right_price(path, costs), right_price(best, costs)
    if price > least + TOLERANCE * max(1.0, least):
        dear, cheap = number_text_pair(price, least)
        raise FaultyPathError("cher", f"Ce chemin se marche, mais coûte {dear} ; le meilleur coûte {cheap}.", price)


def _check_ends(path: Sequence[Cell], start: Cell, goal: Cell) -> None:
    turned = ""
    if path[0] == goal and path[-1] == start:
        turned = " Il va du but au départ : il reste à le retourner."
    elif path[0] == start[::-1] and path[-1] == goal[::-1]:
        turned = " Les couples ont l'air d'être (colonne, ligne)."
    if path[0] != start:
        raise FaultyPathError("depart", f"Le chemin commence en {path[0]}, et non au départ {start}.{turned}")
    if path[-1] != goal:
        raise FaultyPathError("but", f"Le chemin finit en {path[-1]}, et non au but {goal}.{turned}")


def _check_walk(permitted: Grid, path: Sequence[Cell]) -> None:
    height, width = permitted.shape
    for i, j in path:
        if not (0 <= i < height and 0 <= j < width):
            raise FaultyPathError("dehors", f"La case ({i}, {j}) est hors de la grille.")
        if not permitted[i, j]:
            raise FaultyPathError("interdite", f"La case ({i}, {j}) n'est pas permise.")
    for (i, j), (y, x) in pairwise(path):
        if (i, j) == (y, x):
            raise FaultyPathError("sur_place", f"La case ({i}, {j}) est répétée : chaque pas va à une voisine.")
        if max(abs(i - y), abs(j - x)) > 1:
            raise FaultyPathError("saut", f"De ({i}, {j}) à ({y}, {x}), le chemin saute : ce ne sont pas des voisines.")
        if not (permitted[i, x] and permitted[y, j]):
            beside = (i, x) if not permitted[i, x] else (y, j)
            raise FaultyPathError(
                "coin", f"De ({i}, {j}) à ({y}, {x}), le chemin coupe un coin : {beside} n'est pas permise."
            )


def simpler(args: Arguments) -> Iterator[Arguments]:
    """The map without its costs, without a row or a column at an end, then with whole costs."""
    permitted, costs, start, goal = args
    if np.any(costs):
        yield permitted, np.zeros(costs.shape), start, goal
    for axis in (0, 1):
        for end in (0, permitted.shape[axis] - 1):
            if permitted.shape[axis] > 1 and end not in (start[axis], goal[axis]):
                yield _cropped(permitted, costs, start, goal, axis, end)
    if np.any(costs != np.round(costs)):
        yield permitted, np.round(costs), start, goal


def _cropped(permitted: Grid, costs: Floats, start: Cell, goal: Cell, axis: int, end: int) -> Arguments:
    moved = [tuple(n - 1 if k == axis and end == 0 else n for k, n in enumerate(cell)) for cell in (start, goal)]
    return np.delete(permitted, end, axis), np.delete(costs, end, axis), moved[0], moved[1]
