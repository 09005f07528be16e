"""Conversion of a program's answer to arrays that a figure can draw."""

from __future__ import annotations

import numpy as np

from graders.core.contract.values import Floats, UnreadableError, Value, read_array


def to_drawable_like(expected: Value, got: Value) -> Floats | tuple[Floats, ...] | None:
    """Return the value in the shape of the expected value, item by item for a tuple of arrays; None if one fails."""
    if not isinstance(expected, tuple) or not any(isinstance(part, np.ndarray) for part in expected):
        return to_drawable_array(got, np.shape(expected))
    if not isinstance(got, tuple | list) or len(got) != len(expected):
        return None
    items = [to_drawable_array(value, np.shape(part)) for value, part in zip(got, expected, strict=True)]
    arrays = tuple(part for part in items if part is not None)
    return arrays if len(arrays) == len(items) else None


def to_drawable_array(value: Value, shape: tuple[int, ...]) -> Floats | None:
    """Return the value as an array of this shape; None for another shape, or numbers beyond 1e9 or not finite."""
    try:
        array = read_array(value)
    except UnreadableError:
        return None
    return array if array.shape == shape and bool(np.all(np.abs(array) < 1e9)) else None
