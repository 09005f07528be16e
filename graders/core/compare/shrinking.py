"""Shrinking: from an input that fails to a simpler one that still fails.

A shrinker proposes simpler values of one argument, the simplest first. A `Search` walks greedily through these while
the failure lasts, within a bounded number of calls and a bounded time: a counterexample is read, not proved minimal.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from graders.core.contract.values import Arguments, Value

Shrinker = Callable[[Value], Iterator[Value]]


@dataclass(frozen=True)
class Budget:
    """What one shrinking may cost: so many calls, so many `seconds` of `clock` (inf: as long as the calls take)."""

    calls: int = 80
    seconds: float = 0.25
    clock: Callable[[], float] = time.monotonic


def keep(value: Value) -> Iterator[Value]:
    """An argument that is not to be simplified."""
    return iter(())


def shrink_number(value: float) -> Iterator[float]:
    """0, 1, then the same number with fewer digits."""
    return iter(_simpler_numbers(value))


@lru_cache(maxsize=4096)
def _simpler_numbers(value: float) -> Sequence[float]:
    numbers = (0.0, 1.0, float(round(value)), round(2.0 * value) / 2.0, round(value, 1))
    return [number for number in numbers if complexity(number) < complexity(value)]


def complexity(value: float) -> float:
    """How much there is to read in a number: 0 < 1 < small integers < halves < one decimal < anything else."""
    if not math.isfinite(value):
        return 100.0
    rank = next((r for r, k in enumerate((1, 2, 10)) if (value * k) == round(value * k)), 5)
    return 10.0 * rank + (math.log1p(abs(value)) if value else -1.0) + (0.1 if value < 0 else 0.0)


def shrink_array(value: Value) -> Iterator[Value]:
    """All entries rounded at once, then one entry at a time."""
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
    """The arguments with one of them simpler."""
    for position, shrinker in enumerate(shrinkers):
        for candidate in shrinker(arguments[position]):
            yield (*arguments[:position], candidate, *arguments[position + 1 :])
