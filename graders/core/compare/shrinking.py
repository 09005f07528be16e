"""Shrinking: from an input that fails to a simpler one that still fails.

A shrinker proposes simpler values of one argument, the simplest first. `shrink` walks greedily through these while the
failure lasts, within a bounded number of calls and a bounded time: a counterexample is read, not proved minimal.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from graders.core.contract.values import Arguments, Value

Shrinker = Callable[[Value], Iterator[Value]]
FailureT = TypeVar("FailureT")


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
    for candidate in (0.0, 1.0, float(round(value)), round(2.0 * value) / 2.0, round(value, 1)):
        if complexity(candidate) < complexity(value):
            yield candidate


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


def shrink(
    arguments: Arguments,
    shrinkers: Sequence[Shrinker],
    still_fails: Callable[[Arguments], bool],
    budget: Budget,
) -> Arguments:
    """The simplest arguments found for which `still_fails` holds; `arguments` themselves are known to fail."""
    deadline = budget.clock() + budget.seconds
    calls = 0
    improved = True
    while improved:
        improved = False
        for candidate in _neighbours(arguments, shrinkers):
            if calls >= budget.calls or budget.clock() > deadline:
                return arguments
            calls += 1
            if still_fails(candidate):
                arguments, improved = candidate, True
                break
    return arguments


def shrink_failure(
    failure: FailureT,
    arguments: Arguments,
    shrinkers: Sequence[Shrinker],
    again: Callable[[FailureT, Arguments], FailureT | None],
    budget: Budget,
) -> FailureT:
    """The failure on the simplest arguments found, where `failure` is the one on `arguments`.

    `again` gets the simplest failure so far and simpler arguments: the failure on these, None where they are no example
    of the same mistake or the program is not to be called any more.
    """
    simplest = failure

    def still_fails(candidate: Arguments) -> bool:
        nonlocal simplest
        simpler = again(simplest, candidate)
        simplest = simplest if simpler is None else simpler
        return simpler is not None

    shrink(arguments, shrinkers, still_fails, budget)
    return simplest


def _neighbours(arguments: Arguments, shrinkers: Sequence[Shrinker]) -> Iterator[Arguments]:
    for position, shrinker in enumerate(shrinkers):
        for candidate in shrinker(arguments[position]):
            yield (*arguments[:position], candidate, *arguments[position + 1 :])
