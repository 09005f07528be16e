"""Shrinking: from an input that fails to a simpler one that still fails.

A shrinker proposes simpler values of one argument, the simplest first. A `ShrinkSearch` walks greedily through these
while the failure lasts, within bounded calls and time: a counterexample must be readable, not minimal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from graders.core.contract.values import Arguments, Value

Shrinker = Callable[[Value], Iterator[Value]]


@dataclass(frozen=True)
class Budget:
    """Bounds of one shrinking: number of calls, and `seconds` of the search's clock (inf: no bound)."""

    calls: int = 80
    seconds: float = 0.25


def keep_unchanged(value: Value) -> Iterator[Value]:
    """Leave an argument as it is."""
    return iter(())


def shrink_number(value: float) -> Iterator[float]:
    """Propose 0, 1, then the same number with fewer digits."""
    return iter(_simpler_numbers(value))


@lru_cache(maxsize=4096)
def _simpler_numbers(value: float) -> Sequence[float]:
    numbers = (0.0, 1.0, float(round(value)), round(2.0 * value) / 2.0, round(value, 1))
    return [number for number in numbers if reading_cost(number) < reading_cost(value)]


def reading_cost(value: float) -> float:
    """Return the reading cost of a number: 0 < 1 < small integers < halves < one decimal < anything else."""
    if not math.isfinite(value):
        return 100.0
    rank = next((r for r, k in enumerate((1, 2, 10)) if (value * k) == round(value * k)), 5)
    return 10.0 * rank + (math.log1p(abs(value)) if value else -1.0) + (0.1 if value < 0 else 0.0)


def shrink_array(value: Value) -> Iterator[Value]:
    """Propose all entries rounded, then one entry simplified at a time."""
    array = np.asarray(value, dtype=np.float64)
    rounded = np.round(array)
    if np.any(rounded != array):
        yield rounded
    for index in np.ndindex(array.shape):
        for candidate in shrink_number(float(array[index])):
            simpler = array.copy()
            simpler[index] = candidate
            yield simpler


def iter_simpler_arguments(shrinkers: Sequence[Shrinker], arguments: Arguments) -> Iterator[Arguments]:
    """Yield the arguments with one of them simplified."""
    for position, shrinker in enumerate(shrinkers):
        for candidate in shrinker(arguments[position]):
            yield (*arguments[:position], candidate, *arguments[position + 1 :])


def shrink_text(value: str) -> Iterator[str]:
    """Propose the empty text, each half, the text without one of its characters, then with simpler ones."""
    yield from _iter_shorter_sequences(value)
    for at, character in enumerate(value):
        for simpler in "a ":
            if character not in (simpler, " ") and character != simpler:
                yield value[:at] + simpler + value[at + 1 :]


def shrink_list(item: Shrinker = keep_unchanged) -> Callable[[Value], Iterator[Value]]:
    """Return the shrinker of lists and tuples whose items `item` shrinks: fewer items, then simpler ones."""

    def shrink(value: Value) -> Iterator[Value]:
        kind = type(value)
        yield from _iter_shorter_sequences(value)
        for at, member in enumerate(value):
            for simpler in item(member):
                yield kind((*value[:at], simpler, *value[at + 1 :]))

    return shrink


def shrink_dict(item: Shrinker = keep_unchanged) -> Callable[[Value], Iterator[Value]]:
    """Return the shrinker of dictionaries whose values `item` shrinks: fewer keys, then simpler values."""

    def shrink(value: Value) -> Iterator[Value]:
        for left_out in value:
            yield {key: member for key, member in value.items() if key != left_out}
        for changed in value:
            for simpler in item(value[changed]):
                yield {key: simpler if key == changed else member for key, member in value.items()}

    return shrink


def shrink_plain_value(value: Value) -> Iterator[Value]:
    """Propose simpler values of the same type, whatever it is."""
    if isinstance(value, bool):
        yield from (False,) if value else ()
    elif isinstance(value, int):
        yield from (int(number) for number in _simpler_numbers(value) if number == int(number))
    elif isinstance(value, float):
        yield from shrink_number(value) if math.isfinite(value) else ()
    elif isinstance(value, str):
        yield from shrink_text(value)
    elif isinstance(value, list | tuple):
        yield from shrink_list(shrink_plain_value)(value)
    elif isinstance(value, set):
        yield from (value - {member} for member in sorted(value, key=repr))
    elif isinstance(value, dict):
        yield from shrink_dict(shrink_plain_value)(value)
    elif isinstance(value, np.ndarray) and value.dtype.kind == "f":
        yield from shrink_array(value)


def _iter_shorter_sequences(value: Value) -> Iterator[Value]:
    """Yield a sequence's empty beginning, its halves, and itself without one item."""
    half = len(value) // 2
    if value:
        yield value[:0]
    if half:
        yield value[:half]
        yield value[half:]
    if len(value) > 1:
        for left_out in range(len(value)):
            yield value[:left_out] + value[left_out + 1 :]
