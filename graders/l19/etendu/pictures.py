"""The data of the figures of l19/etendu: a robot, a beacon, how their distance varies; a belief before and after."""

from __future__ import annotations

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, UnreadableError, Value
from graders.l19.pairs import NotAPairError, read_pair

RANGE, STATE = ("distance", "jacobienne"), ("état", "covariance")
MEASURED, CORRECTED = "distance", "correction"
#: How large a number is still drawn.
LARGEST = 1e4


def range_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    """`got` is a pair in the shapes of `expected`, or None."""
    x, beacon = args
    return {
        "kind": MEASURED,
        "x": x,
        "beacon": beacon,
        "expected": expected,
        "got": got if got is not None and np.all(np.abs(got[1]) < LARGEST) else None,
    }


def reading_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    x, P, z, beacon, _ = args
    sane = got is not None and all(bool(np.all(np.abs(one) < LARGEST)) for one in got)
    return {
        "kind": CORRECTED,
        "before": (x, P),
        "z": z,
        "beacon": beacon,
        "expected": expected,
        "got": got if sane else None,
    }


def drawn_reading(args: Arguments, expected: Value, got: Value) -> FigureData:
    """The same of whatever came back."""
    try:
        pair = read_pair(got, STATE)
    except (UnreadableError, NotAPairError):
        return reading_figure(args, expected, None)
    fits = [one.shape for one in pair] == [np.shape(one) for one in expected]
    return reading_figure(args, expected, pair if fits else None)
