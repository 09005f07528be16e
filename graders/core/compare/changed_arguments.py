"""Changes of one argument: what a program may wrongly read in its place, and what its answers must feel or ignore.

Each change has French words: « comme si » a replacement, « quand » a variation. A change that does not apply to an
argument, or leaves it as it is, gives None.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from graders.core.contract.values import Arguments, Floats, Value
from graders.typography import elided

#: Numbers of an argument that is changed: larger ones are maps and clouds of a closed loop.
MAX_SIZE = 400
#: Error up to which numbers are shares of 1.
SUM_ONE = 1e-9
Change = Callable[[Any], Any]


@dataclass(frozen=True)
class ArgumentChange:
    """A change of the arguments of a call, in words: « r valait 0 », « on ajoute 1 à r »."""

    words: str
    apply: Callable[[Arguments], Arguments | None]


def iter_argument_replacements(names: tuple[str, ...], call: Arguments) -> Iterator[ArgumentChange]:
    """Yield what may have been read in the place of an argument of calls like this one, said after « comme si »."""
    for index, (name, value) in enumerate(zip(names, call, strict=False)):
        if _is_number(value):
            yield from _changes_of_argument(index, value, _number_replacements(name))
        elif _is_array(value):
            yield from _changes_of_argument(index, value, _array_replacements(name, value))
    for first in range(len(call)):
        for second in range(first + 1, min(len(call), len(names))):
            if _kind_and_shape(call[first]) and _kind_and_shape(call[first]) == _kind_and_shape(call[second]):
                words = f"{names[first]} et {names[second]} étaient échangés"
                yield ArgumentChange(words, _ArgumentExchange(first, second))


def iter_argument_variations(names: tuple[str, ...], call: Arguments) -> Iterator[tuple[int, ArgumentChange]]:
    """Yield variations of each argument of calls like this one, with its index, said after « quand »."""
    for index, (name, value) in enumerate(zip(names, call, strict=False)):
        if _is_number(value):
            changes: list[tuple[str, Change]] = [(f"{name} change", lambda x: x * 1.25 + 0.1)]
            if isinstance(value, int):
                changes = [(f"{name} change", lambda x: x + 1)]
        elif _is_array(value) and are_probabilities(value):
            changes = [(f"{name} change", _change_shares)]
        elif _is_array(value):
            changes = [
                (f"{name} change", _perturb_numbers),
                (f"on ajoute un même nombre à tous ceux {elided('de', name)}", lambda x: x + 0.75),
                (f"on multiplie {name} par 2", lambda x: 2.0 * x),
            ]
            if value.ndim == 2:
                changes += [
                    (f"on ajoute un même vecteur à toutes les lignes {elided('de', name)}", _translate_rows),
                    (f"les lignes {elided('de', name)} viennent dans un autre ordre", lambda x: x[::-1]),
                ]
            elif value.size > 3:
                changes.append((f"les nombres {elided('de', name)} viennent dans un autre ordre", lambda x: x[::-1]))
        else:
            continue
        yield from ((index, change) for change in _changes_of_argument(index, value, iter(changes)))


def are_probabilities(value: Floats) -> bool:
    """Whether numbers are probabilities or weights of sum 1: they are given as such alone."""
    return value.size > 1 and bool(np.all(value >= 0.0)) and abs(float(value.sum()) - 1.0) < SUM_ONE


def _change_shares(value: Floats) -> Floats:
    """Other shares of 1, those that are zero still so."""
    other = value * (1.1 + 0.3 * np.cos(np.arange(value.size))).reshape(value.shape)
    return np.asarray(other / other.sum())


@dataclass(frozen=True)
class _ArgumentReplacement:
    """Replaces the argument at an index; None where nothing changes, or a number stands where an array was, or back."""

    index: int
    is_array: bool
    change: Change

    def __call__(self, call: Arguments) -> Arguments | None:
        if self.index >= len(call):
            return None
        old = call[self.index]
        if isinstance(old, np.ndarray) is not self.is_array:
            return None
        try:
            with np.errstate(all="ignore"):
                new = self.change(np.array(old, dtype=float) if self.is_array else old)
        except (ValueError, IndexError, ZeroDivisionError, TypeError, OverflowError):
            return None
        if not np.all(np.isfinite(np.asarray(new, dtype=float))) or _are_equal_values(old, new):
            return None
        return (*call[: self.index], new, *call[self.index + 1 :])


@dataclass(frozen=True)
class _ArgumentExchange:
    """Exchanges two arguments; None where they are equal."""

    first: int
    second: int

    def __call__(self, call: Arguments) -> Arguments | None:
        if self.second >= len(call) or _are_equal_values(call[self.first], call[self.second]):
            return None
        changed = list(call)
        changed[self.first], changed[self.second] = call[self.second], call[self.first]
        return tuple(changed)


def _are_equal_values(old: Value, new: Value) -> bool:
    return np.shape(old) == np.shape(new) and bool(np.array_equal(np.asarray(old), np.asarray(new)))


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float | np.floating | np.integer) and not isinstance(value, bool)


def _is_array(value: Value) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind in "fi" and value.ndim > 0 and 0 < value.size <= MAX_SIZE


def _kind_and_shape(value: Value) -> tuple[str, tuple[int, ...]] | None:
    if _is_number(value):
        return ("nombre", ())
    return ("tableau", value.shape) if _is_array(value) else None


def _changes_of_argument(index: int, value: Value, changes: Iterator[tuple[str, Change]]) -> Iterator[ArgumentChange]:
    is_array = isinstance(value, np.ndarray)
    return (ArgumentChange(words, _ArgumentReplacement(index, is_array, change)) for words, change in changes)


def _number_replacements(name: str) -> Iterator[tuple[str, Change]]:
    yield f"{name} valait 0", lambda x: 0 * x
    yield f"{name} valait 1", lambda x: 0 * x + 1
    yield f"{name} était changé de signe", lambda x: -x
    yield f"{name} était élevé au carré", lambda x: x * x
    yield f"{name} était remplacé par sa racine carrée", math.sqrt
    yield f"{name} était remplacé par son inverse", lambda x: 1.0 / x
    yield f"{name} était doublé", lambda x: 2 * x
    yield f"{name} était divisé par deux", lambda x: x / 2
    yield f"{name} était converti en degrés", math.degrees
    yield f"{name} était converti en radians", math.radians
    yield f"{name} était augmenté de 1", lambda x: x + 1
    yield f"{name} était diminué de 1", lambda x: x - 1
    yield f"{name} était tronqué à un entier", lambda x: int(x) if isinstance(x, int) else float(int(x))


def _array_replacements(name: str, value: Floats) -> Iterator[tuple[str, Change]]:
    each = f"chaque nombre {elided('de', name)}"
    yield f"{name} n’était fait que de 0", np.zeros_like
    yield f"{each} était changé de signe", np.negative
    yield f"{each} était élevé au carré", np.square
    yield f"{each} était remplacé par sa racine carrée", np.sqrt
    yield f"{each} était remplacé par son inverse", np.reciprocal
    yield f"{each} était doublé", lambda x: 2.0 * x
    yield f"{each} était divisé par deux", lambda x: x / 2.0
    yield f"{each} était tronqué à un entier", np.trunc
    yield f"tous les nombres {elided('de', name)} étaient égaux à leur moyenne", lambda x: np.full_like(x, x.mean())
    noun, last = ("ligne", "dernière ligne") if value.ndim == 2 else ("valeur", "dernière valeur")
    yield f"les {noun}s {elided('de', name)} venaient dans l’ordre inverse", lambda x: x[::-1]
    if value.shape[0] > 2 or value.ndim == 1:
        yield f"la première {noun} {elided('de', name)} n’y était pas", lambda x: x[1:]
        yield f"la {last} {elided('de', name)} n’y était pas", lambda x: x[:-1]
    if value.ndim == 2 and value.shape[0] == value.shape[1]:
        yield f"{name} était transposé", np.transpose
        yield f"{name} n’avait que sa diagonale", lambda x: np.diag(np.diag(x))
        yield f"{name} était l’identité", lambda x: np.eye(len(x))
        yield f"{name} était remplacé par son inverse", np.linalg.inv
    if value.ndim == 2 and value.shape[1] in (2, 3):
        yield f"les deux premières colonnes {elided('de', name)} étaient échangées", _exchange_first_columns
        yield f"{name} était centré", lambda x: x - x.mean(axis=0)
    if value.ndim == 1 and value.size <= 3:
        for k in range(value.size):
            yield f"{name}[{k}] était changé de signe", _ComponentScaling(k, -1.0)
            yield f"{name}[{k}] valait 0", _ComponentScaling(k, 0.0)
        yield f"{name}[0] et {name}[1] étaient échangés", lambda x: x[[1, 0, *range(2, len(x))]]


@dataclass(frozen=True)
class _ComponentScaling:
    """Multiplies one number of a row."""

    index: int
    factor: float

    def __call__(self, values: Floats) -> Floats:
        values[self.index] *= self.factor
        return values


def _exchange_first_columns(values: Floats) -> Floats:
    return values[:, [1, 0, *range(2, values.shape[1])]]


def _translate_rows(values: Floats) -> Floats:
    return np.asarray(values + 0.6 * np.arange(1, values.shape[1] + 1))


def _perturb_numbers(values: Floats) -> Floats:
    """Other numbers, positive where they were: a symmetric array remains so."""
    if values.ndim == 2 and values.shape[0] == values.shape[1]:
        return 1.25 * values
    return np.asarray(values * (1.1 + 0.3 * np.cos(np.arange(values.size))).reshape(values.shape))
