"""A map that has the right shape, and is only turned."""

from __future__ import annotations

import math

import numpy as np

from graders.core.compare import words as render
from graders.core.contract.values import Floats

#: Distance up to which two positions are the same, and angle from which a map is turned.
NEAR, LEAST_TURN = 1e-3, 1e-2


def turn_about_first(expected: Floats, got: Floats) -> float | None:
    """Return the angle in radians by which the positions `got` (n, 2) are those `expected`, turned about the first one.

    None where they are not, or hardly turned. It is the angle of the rotation that is best in least squares (Umeyama,
    1991, in the plane and about a fixed point).
    """
    a, b = expected - expected[0], got - got[0]
    turn = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    c, s = math.cos(turn), math.sin(turn)
    turned = a @ np.array([[c, s], [-s, c]])
    is_turned = len(a) > 2 and abs(turn) > LEAST_TURN and bool(np.abs(turned - b).max() < NEAR)
    return turn if is_turned else None


def tell_turn(expected: Floats, got: Floats) -> str:
    """Return a French sentence on a map that is only turned; empty where it is not."""
    turn = turn_about_first(expected, got)
    if turn is None:
        return ""
    size = render.number(abs(math.degrees(turn)), 3)
    return f" Les positions ont la bonne forme : elles sont toutes tournées de {size}° autour de la première pose."
