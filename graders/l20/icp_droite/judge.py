"""Normals up to their signs, and directions up to the choice of a basis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch, are_close, shape_mismatch, unreadable
from graders.core.contract.values import Floats, UnreadableError, Value, read_array

LOOSE = 1e-6


@dataclass(frozen=True)
class SameNormals:
    """Rows (n, 2) within the tolerance, each up to its sign."""

    tolerance: float = 1e-9

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            found = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        if found.shape != wanted.shape:
            return shape_mismatch(wanted, found)
        if not np.all(np.isfinite(found)):
            return Mismatch("Une des coordonnées n'est pas un nombre fini.", "nan")
        gaps = np.minimum(np.abs(found - wanted).max(axis=1), np.abs(found + wanted).max(axis=1))
        if np.all(gaps <= self.tolerance):
            return None
        k = int(np.argmax(gaps > self.tolerance))
        length = float(np.hypot(*found[k]))
        if abs(length - 1.0) > 1e-6:
            return Mismatch(f"Au point d'indice {k}, la normale est de longueur {render.number(length, 4)}, et non 1.")
        chord = abs(float(wanted[k, 0] * found[k, 1] - wanted[k, 1] * found[k, 0]))
        degrees = render.number(float(np.degrees(np.arcsin(min(1.0, chord)))), 3)
        return Mismatch(f"Au point d'indice {k}, la normale s'écarte de {degrees}° de celle qui est attendue.")


@dataclass(frozen=True)
class SameSpan:
    """Rows (k, 3) of length 1 that span the same space; empty where there is none, (3,) where there is one."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            found = read_rows(got)
        except UnreadableError as error:
            return unreadable(error)
        if found.ndim != 2 or found.shape[1] != 3:
            return shape_mismatch(wanted, found)
        if len(found) != len(wanted):
            return Mismatch(f"{_counted(len(found))}, au lieu de {len(wanted)}.")
        if not np.all(np.isfinite(found)):
            return Mismatch("Une des coordonnées n'est pas un nombre fini.", "nan")
        with np.errstate(over="ignore", invalid="ignore"):  # directions may be immense
            told = _basis_fault(found) or _span_fault(wanted, found)
        return Mismatch(told) if told else None


def _basis_fault(found: Floats) -> str | None:
    if not are_close(np.ones(len(found)), np.linalg.norm(found, axis=1), LOOSE):
        return "Une des directions n'est pas de longueur 1."
    return "Deux des directions sont la même." if np.linalg.matrix_rank(found, tol=LOOSE) < len(found) else None


def _span_fault(wanted: Floats, found: Floats) -> str | None:
    left = wanted - wanted @ np.linalg.pinv(found) @ found
    if are_close(np.zeros_like(left), left, 10 * LOOSE):
        return None
    return f"Ce n'est pas {'la direction' if len(found) == 1 else 'le plan'} que A ne tient pas."


def read_rows(value: Value) -> Floats:
    """Directions as rows. Raises UnreadableError."""
    found = read_array(value)
    if found.size == 0:
        return np.zeros((0, 3))
    return found.reshape(1, 3) if found.shape == (3,) else found


def _counted(count: int) -> str:
    return f"{count} directions libres" if count > 1 else f"{count or 'aucune'} direction libre".capitalize()
