"""What a figure of a declared exercise shows: the expected and the obtained numbers, as a curve, points or a grid.

Which one, the value itself says: a list or an array of numbers is a curve, one of pairs is points, any other matrix is
a grid. Two lists of the same length, as `plt.plot(x, y)` takes them, are a curve too.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Floats, UnreadableError, Value, read_array

CURVE, POINTS, GRID = KINDS = ("declared_curve", "declared_points", "declared_grid")
#: Numbers of a value of which no figure is made, as its message says it all, and of one that is too large for one.
FEWEST, MOST = 4, 2000
LARGEST = 1e9


def describe_figure(title: str, expected: Value, got: Value) -> FigureData | None:
    """Return the data of a figure of two answers, in plain JSON; None where there is nothing to draw.

    `got` is drawn where it has the form of `expected`, and numbers that are finite.
    """
    drawn = _read_drawing(expected)
    if drawn is None:
        return None
    kind, right = drawn
    other = _read_drawing(got)
    obtained = None if other is None or not _are_drawable_together(kind, right, other[1]) else other[1]
    return {
        "kind": kind,
        "title": title,
        "expected": [part.tolist() for part in right],
        "got": None if obtained is None else [part.tolist() for part in obtained],
    }


def _are_drawable_together(kind: str, right: tuple[Floats, ...], other: tuple[Floats, ...]) -> bool:
    if len(right) != len(other):
        return False
    if kind == GRID:
        return all(a.shape == b.shape for a, b in zip(right, other, strict=True))
    return all(a.ndim == b.ndim and a.shape[1:] == b.shape[1:] for a, b in zip(right, other, strict=True))


def _read_drawing(value: Value) -> tuple[str, tuple[Floats, ...]] | None:
    """Return what draws a value, and the arrays that it draws."""
    if isinstance(value, tuple) and len(value) == 2:
        both = [_read_finite_array(part) for part in value]
        first, second = both
        if first is not None and second is not None and first.ndim == second.ndim == 1 and first.size == second.size:
            return CURVE, (first, second)
    array = _read_finite_array(value)
    if array is None:
        return None
    if array.ndim == 1:
        return CURVE, (np.arange(array.size, dtype=np.float64), array)
    if array.ndim == 2 and array.shape[1] == 2 and array.shape[0] > 2:
        rises = all(after > before for before, after in pairwise(array[:, 0]))
        return (CURVE, (array[:, 0], array[:, 1])) if rises else (POINTS, (array,))
    return (GRID, (array,)) if array.ndim == 2 and min(array.shape) > 1 else None


def _read_finite_array(value: Value) -> Floats | None:
    """Return a value as an array of finite numbers, not too few and not too many; None for any other value."""
    if not isinstance(value, list | tuple | np.ndarray):
        return None
    try:
        array = read_array(value)
    except UnreadableError:
        return None
    return array if FEWEST <= array.size <= MOST and bool(np.all(np.abs(array) < LARGEST)) else None
