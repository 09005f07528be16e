"""What can be drawn of a program's answer."""

from __future__ import annotations

import numpy as np

from graders.core.contract.values import Floats, UnreadableError, Value, read_array


def drawable_as(expected: Value, got: Value) -> Floats | tuple[Floats, ...] | None:
    """`drawable` in the shape of what is expected; item by item for a tuple of arrays, of which every one must be."""
    if not isinstance(expected, tuple) or not any(isinstance(one, np.ndarray) for one in expected):
        return drawable(got, np.shape(expected))
    if not isinstance(got, tuple | list) or len(got) != len(expected):
        return None
    items = [drawable(value, np.shape(one)) for value, one in zip(got, expected, strict=True)]
    found = tuple(one for one in items if one is not None)
    return found if len(found) == len(items) else None


def drawable(value: Value, shape: tuple[int, ...]) -> Floats | None:
    """The value as an array when it has the shape that a drawing needs and only sane numbers, else None."""
    try:
        array = read_array(value)
    except UnreadableError:
        return None
    return array if array.shape == shape and bool(np.all(np.abs(array) < 1e9)) else None
