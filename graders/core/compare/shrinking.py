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


def keep(value: Value) -> Iterator[Value]:
    """Leave an argument as it is."""
    return iter(())


def shrink_number(value: float) -> Iterator[float]:
    """Propose 0, 1, then the same number with fewer digits."""
    return iter(_simpler_numbers(value))


@lru_cache(maxsize=4096)
def _simpler_numbers(value: float) -> Sequence[float]:
    numbers = (0.0, 1.0, float(round(value)), round(2.0 * value) / 2.0, round(value, 1))
    return [number for number in numbers if complexity(number) < complexity(value)]


def complexity(value: float) -> float:
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


def neighbours(shrinkers: Sequence[Shrinker], arguments: Arguments) -> Iterator[Arguments]:
    """Yield the arguments with one of them simplified."""
    for position, shrinker in enumerate(shrinkers):
        for candidate in shrinker(arguments[position]):
            yield (*arguments[:position], candidate, *arguments[position + 1 :])
