"""The data of the figures of l19/matrice: a belief of two numbers before and after, as ellipses; nothing otherwise."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, UnreadableError, Value
from graders.l19.pairs import NotAPairError, read_pair

NAMES = ("état", "covariance")
MOVED, MEASURED = "predire", "corriger"
#: How large a number is still drawn.
LARGEST = 1e6


def belief_figure(kind: str, args: Arguments, expected: Value, got: Value) -> FigureData | None:
    """`got` is a pair of arrays in the shapes of `expected`, or None."""
    x, P = args[:2]
    if len(x) != 2:
        return None
    data: FigureData = {"kind": kind, "before": (x, P), "expected": expected, "got": got, "seen": None, "line": None}
    if kind == MEASURED:
        _, _, z, H, R = args
        if H.shape == (1, 2):
            data["line"] = (*H[0].tolist(), float(z[0]), float(np.sqrt(R[0, 0])))
        elif H.shape == (2, 2) and abs(np.linalg.det(H)) > 1e-6:
            back = np.linalg.inv(H)
            data["seen"] = (back @ z, back @ R @ back.T)
    return data


def drawn_pair(kind: str, args: Arguments, expected: Value, got: Value) -> FigureData | None:
    """The same of whatever came back."""
    try:
        pair = read_pair(got, NAMES)
    except (UnreadableError, NotAPairError):
        return belief_figure(kind, args, expected, None)
    fits = [one.shape for one in pair] == [np.shape(one) for one in expected]
    sane = fits and all(bool(np.all(np.abs(one) < LARGEST)) for one in pair)
    return belief_figure(kind, args, expected, tuple(pair) if sane else None)


moved_figure, measured_figure = partial(belief_figure, MOVED), partial(belief_figure, MEASURED)
