"""Deep copies of the plain values that programs exchange and may modify."""

from __future__ import annotations

import copy

import numpy as np

from graders.core.contract.values import Value

#: Immutable types.
STEADY = frozenset({type(None), bool, int, float, complex, str, bytes})


def copy_value(value: Value) -> Value:
    """Return a deep copy, several times faster than `copy.deepcopy` for plain values.

    A shared object becomes two, as on the way to a student's program. A list that contains itself is left to
    `copy.deepcopy`.
    """
    try:
        return _copy_without_sharing(value)
    except RecursionError:
        return copy.deepcopy(value)


def _copy_without_sharing(value: Value) -> Value:
    kind = type(value)
    if kind in STEADY:
        return value
    if kind is np.ndarray and not value.dtype.hasobject:
        return value.copy(order="K")
    if kind is list:
        return [_copy_without_sharing(item) for item in value]
    if kind is tuple:
        return tuple([_copy_without_sharing(item) for item in value])
    if kind is dict:
        return {_copy_without_sharing(key): _copy_without_sharing(item) for key, item in value.items()}
    return copy.deepcopy(value)
