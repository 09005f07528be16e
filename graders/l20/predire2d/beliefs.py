"""Beliefs over a map: how they are compared, written in French, and simplified."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, Mismatch, are_close, shape_mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from reference.localisation.grid_filter import Cell, Grid

FEW = 6
LIKELIEST = 10
VISIBLE = 5e-10
#: Two cells as likely as each other are not told apart by this much.
ROUNDING = 1e-6


@dataclass(frozen=True)
class SameBelief:
    """Arrays (H, W) with the same values; says first what is not a belief: nan, mass on a wall, a sum other than 1."""

    free: Grid

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            belief = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        if belief.shape != wanted.shape:
            return shape_mismatch(wanted, belief)
        if not np.all(np.isfinite(belief)):
            return Mismatch("Le résultat contient « nan » ou l'infini, qui ne sont pas des probabilités.", "nan")
        return None if are_close(wanted, belief) else self._difference(wanted, belief)

    def _difference(self, wanted: Floats, belief: Floats) -> Mismatch:
        total = float(belief.sum())
        missing = abs(total - 1.0) > 1e3 * TOLERANCE
        if missing and total > 0.0 and are_close(wanted, belief / total, 1e-7):
            return Mismatch(f"La somme des probabilités vaut {instead(total, 1.0)}.", "non_normalise")
        on_walls = np.where(self.free, 0.0, np.abs(belief))
        if on_walls.max() > TOLERANCE:
            cell = spot(int(np.argmax(on_walls)), belief.shape)
            return Mismatch(f"Le mur {at(cell)} reçoit la probabilité {render.number(float(belief[cell]))}.")
        if missing:
            return Mismatch(f"La somme des probabilités vaut {instead(total, 1.0)}.")
        worst = spot(int(np.argmax(np.abs(belief - wanted))), belief.shape)
        values = instead(float(belief[worst]), float(wanted[worst]))
        return Mismatch(f"L'écart le plus grand est en {at(worst)} : {values}.")


@dataclass(frozen=True)
class SameShares(SameBelief):
    """The same belief up to a factor: that its sum is 1 is another check's business."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            belief = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        if belief.shape != wanted.shape or not np.all(np.isfinite(belief)) or not belief.sum() > 0.0:
            return super().__call__(expected, got)
        return super().__call__(expected, belief / belief.sum())


@dataclass(frozen=True)
class SumsToOne(SameBelief):
    """A belief (H, W) of sum 1, whatever its values."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        mismatch = super().__call__(expected, got)
        if mismatch is None or mismatch.slip == "non_normalise":
            return mismatch
        try:
            total = float(read_array(got).sum())
        except UnreadableError:
            return mismatch
        if np.shape(got) != np.shape(expected) or not abs(total - 1.0) <= TOLERANCE:
            return mismatch
        return None


@dataclass(frozen=True)
class SameLikeliest(SameBelief):
    """The greatest value in the cell where it is expected, and by more than rounding."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            belief = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        if belief.shape != wanted.shape or not np.all(np.isfinite(belief)):
            return super().__call__(expected, got)
        best = spot(int(np.argmax(wanted)), wanted.shape)
        others = np.delete(belief.ravel(), int(np.argmax(wanted)))
        if belief[best] > (1.0 + ROUNDING) * others.max():
            return None
        return Mismatch(f"La case la plus probable devrait être {at(best)}.")


def instead(got: float, wanted: float) -> str:
    """« 0,9999991 au lieu de 1 »."""
    obtained, expected = number_text_pair(got, wanted)
    return f"{obtained} au lieu de {expected}"


def spot(flat: int, shape: tuple[int, ...]) -> Cell:
    """The cell (y, x) of a flat index."""
    y, x = np.unravel_index(flat, shape)
    return int(y), int(x)


def at(cell: Cell) -> str:
    return f"({cell[0]}, {cell[1]})"


def support(belief: Floats) -> list[Cell]:
    """The cells (y, x) that hold something, in reading order."""
    return [(int(y), int(x)) for y, x in np.argwhere(np.abs(belief) > VISIBLE)]


def in_words(belief: Floats) -> str:
    """« 0,8 en (7, 4), 0,1 en (6, 4) et 0,1 en (8, 4) », the greatest first; only counted when spread out."""
    cells = sorted(support(belief), key=lambda cell: (-belief[cell], cell))
    if not cells:
        return "0 partout"
    if len(cells) > FEW:
        return f"une croyance étalée sur {len(cells)} cases"
    parts = [f"{render.number(float(belief[cell]), 4)} en {at(cell)}" for cell in cells]
    return " et ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else parts[0]


def one_hot(shape: tuple[int, ...], *cells: Cell) -> Floats:
    """The belief (H, W) shared evenly by the given cells."""
    return weighted(shape, dict.fromkeys(cells, 1.0 / len(cells)))


def weighted(shape: tuple[int, ...], weights: dict[Cell, float]) -> Floats:
    """The belief (H, W) with the given probabilities."""
    belief = np.zeros(shape)
    for cell, weight in weights.items():
        belief[cell] = weight
    return belief


def spread(rng: np.random.Generator, free: Grid) -> Floats:
    """A belief (H, W) drawn at random over all free cells, every one of them possible."""
    weights = free * rng.uniform(0.05, 1.0, free.shape)
    return np.asarray(weights / weights.sum())


def shrink_belief(value: Value) -> Iterator[Value]:
    """Certainty in one of the likeliest cells, then doubt between two, each with one half."""
    belief = np.asarray(value, dtype=np.float64)
    cells = sorted(support(belief), key=lambda cell: -belief[cell])[:LIKELIEST]
    if len(cells) > 1:
        for cell in cells[:FEW]:
            yield one_hot(belief.shape, cell)
    if len(cells) > 2 or (len(cells) == 2 and belief[cells[0]] != belief[cells[1]]):
        for i, cell in enumerate(cells):
            for other in cells[i + 1 :]:
                yield one_hot(belief.shape, cell, other)


def shrink_scan(value: Value) -> Iterator[Value]:
    """Distances brought to halves of a cell, as a noiseless lidar at a centre gives them."""
    scan = np.asarray(value, dtype=np.float64)
    halves = np.floor(scan) + 0.5
    if np.any(halves != scan):
        yield halves
