"""Comparators: whether an obtained value agrees with the expected one, and how it differs.

A comparator is called with the expected and the obtained value and returns None, or a Mismatch that says in French
what differs. It never raises for a value that a student returned.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.relations import tell_relation
from graders.core.compare.slips import shape_slip, value_slip
from graders.core.compare.told_apart import got_instead_of_expected_text
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import (
    Floats,
    UnreadableError,
    Value,
    is_single_number_array,
    read_array,
    read_indices,
    read_scalar,
)

TOLERANCE = 1e-9


@dataclass(frozen=True)
class Mismatch:
    """A difference of two values: a French sentence, the slip that it resembles, the outcome that it causes.

    `words` is the sentence, or a function that makes it on first use: most mismatches are never shown.
    """

    words: str | Callable[[], str]
    slip: str | None = None
    cause: Outcome = Outcome.WRONG_ANSWER

    @cached_property
    def message(self) -> str:
        return self.words if isinstance(self.words, str) else self.words()


#: Returns None where the values agree, else why they do not: a mismatch, or a French sentence.
Comparator = Callable[[Value, Value], Mismatch | str | None]


def compare(comparator: Comparator, expected: Value, got: Value) -> Mismatch | None:
    """Return the mismatch that a comparator finds. Raises TypeError for one that returns something else."""
    found = comparator(expected, got)
    if isinstance(found, str):
        return Mismatch(found)
    if found is not None and not isinstance(found, Mismatch):
        raise TypeError(f"comparateur {comparator!r} : il renvoie {found!r}, ni None, ni une phrase, ni un Mismatch")
    return found


#: Multiples of the tolerance within which, and beyond which, a batch comparison decides, whatever the rounding.
WELL_WITHIN, WELL_BEYOND = 0.5, 2.0


class RowComparator(ABC):
    """A comparator of numbers that also compares many cases in a few array operations."""

    @abstractmethod
    def row_errors(self, expected: Floats, got: Floats) -> Floats | None:
        """Return the error of each row of two arrays (n, …), a case a row, in multiples of the tolerance: (n,).

        A row below WELL_WITHIN agrees when compared alone, one above WELL_BEYOND does not. None where each row must be
        compared alone.
        """


def row_errors(expected: Floats, got: Floats, tolerance: float) -> Floats:
    """Return the error of each row in multiples of the tolerance of `are_close`; inf where a number is NaN."""
    with np.errstate(invalid="ignore", over="ignore"):
        gaps = np.abs(got - expected) / (tolerance * np.maximum(1.0, np.abs(expected)))
    gaps[np.isnan(gaps)] = np.inf
    return np.asarray(gaps.reshape(len(gaps), -1).max(axis=1, initial=0.0))


def unreadable(error: UnreadableError) -> Mismatch:
    """Return the mismatch of a value that cannot be read: an invalid output."""
    reason = str(error)
    return Mismatch(reason[0].upper() + reason[1:] + ".", cause=Outcome.INVALID_OUTPUT)


def are_close(expected: Floats, got: Floats, tolerance: float = TOLERANCE) -> bool:
    """Whether arrays agree as the contract says: relative or absolute `tolerance` by element, never for NaN."""
    with np.errstate(invalid="ignore", over="ignore"):
        return bool((np.abs(got - expected) <= tolerance * np.maximum(1.0, np.abs(expected))).all())


@dataclass(frozen=True)
class CloseTo(RowComparator):
    """Arrays or numbers of the same shape and, within the tolerance, the same values."""

    tolerance: float = TOLERANCE

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            array = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        if not wanted.ndim and is_single_number_array(got):
            array = array.reshape(())
        if array.shape != wanted.shape:
            return shape_mismatch(wanted, array)
        if are_close(wanted, array, self.tolerance):
            return None
        return Mismatch(lambda: worst_difference(wanted, array), value_slip(wanted, array))

    def row_errors(self, expected: Floats, got: Floats) -> Floats | None:
        return row_errors(expected, got, self.tolerance)


@dataclass(frozen=True)
class ScalarCloseTo(RowComparator):
    """One number (a float, an int, a numpy scalar, a 0-d array) within the tolerance."""

    tolerance: float = TOLERANCE

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        try:
            value = read_scalar(got)
        except UnreadableError as error:
            return unreadable(error)
        return CloseTo(self.tolerance)(float(expected), value)

    def row_errors(self, expected: Floats, got: Floats) -> Floats | None:
        return row_errors(expected, got, self.tolerance) if got.ndim == 1 else None


@dataclass(frozen=True)
class SameIndices:
    """The same whole numbers in the same order."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        try:
            indices = read_indices(got)
        except UnreadableError as error:
            return unreadable(error)
        wanted = list(expected)
        if indices == wanted:
            return None
        if sorted(indices) == wanted:
            return Mismatch("Les bons indices y sont, mais pas dans l'ordre croissant.")
        missing, extra = sorted(set(wanted) - set(indices)), sorted(set(indices) - set(wanted))
        parts = [
            f"il manque {_indices_text(missing)}" if missing else "",
            f"{_indices_text(extra)} {_singular_or_plural_be(extra)} de trop" if extra else "",
        ]
        if not any(parts):
            return Mismatch("Un indice est répété.")
        return Mismatch("Parmi les indices, " + " et ".join(p for p in parts if p) + ".")


def _indices_text(indices: Sequence[int]) -> str:
    return ", ".join(str(i) for i in indices[:8]) + ("…" if len(indices) > 8 else "")


def _singular_or_plural_be(items: Sequence[int]) -> str:
    return "est" if len(items) == 1 else "sont"


def shape_mismatch(expected: Floats, got: Floats) -> Mismatch:
    """A mismatch of shapes, with the slip that explains it."""
    wanted, obtained = render.shape_text(expected.shape), render.shape_text(got.shape)
    return Mismatch(f"La forme du résultat est {obtained} au lieu de {wanted}.", shape_slip(expected, got))


def worst_difference(expected: Floats, got: Floats) -> str:
    """Say the largest gap between two arrays of the same shape, and what else is seen of them."""
    if np.any(np.isnan(got)):
        return "Le résultat contient « nan », qui n'est pas un nombre."
    with np.errstate(invalid="ignore", over="ignore"):
        gaps = np.nan_to_num(np.abs(got - expected), nan=np.inf)
    where = np.unravel_index(int(np.argmax(gaps)), gaps.shape) if gaps.ndim else ()
    position = f" à l'indice {', '.join(str(int(i)) for i in where)}" if where else ""
    relation = tell_relation(expected, got)
    values = got_instead_of_expected_text(float(expected[where]), float(got[where]))
    worst = f"L'écart le plus grand est{position} : {values}."
    return f"{worst} {relation}" if relation else worst
