"""Simpler maps and paths, where a counterexample is shown."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Value
from graders.l20.planifier.truth import FREE


def shrink_grid(value: Value) -> Iterator[Value]:
    """Without a row or a column at an end, then with one cell more that is free."""
    grid = np.asarray(value)
    for axis in (0, 1):
        if grid.shape[axis] > 1:
            yield from (np.delete(grid, end, axis) for end in (0, grid.shape[axis] - 1))
    for index in np.argwhere(grid != FREE):
        freed = grid.copy()
        freed[tuple(index)] = FREE
        yield freed


def shrink_path(value: Value) -> Iterator[Value]:
    """Without its last cell, or its first."""
    if len(value) > 1:
        yield value[:-1]
        yield value[1:]


def shrink_prices(value: Value) -> Iterator[Value]:
    """No costs, then whole ones."""
    costs = np.asarray(value)
    if np.any(costs):
        yield np.zeros(costs.shape)
        if np.any(costs != np.round(costs)):
            yield np.round(costs)
