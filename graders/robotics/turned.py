"""A map that has the right shape, and is only turned, or moved as a whole."""

from __future__ import annotations

import math

import numpy as np

from graders.core.compare import words as render
from graders.core.contract.values import Floats
from reference.se2 import wrap_angle

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


def rigid_motion_between(expected: Floats, got: Floats) -> float | None:
    """Return the angle in radians of the rigid motion that leads the positions `expected` (n, 2) to `got`.

    None where they have not the same shape (Umeyama, 1991, in the plane).
    """
    a, b = expected - expected.mean(axis=0), got - got.mean(axis=0)
    turn = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    c, s = math.cos(turn), math.sin(turn)
    return turn if np.abs(a @ np.array([[c, s], [-s, c]]) - b).max() < NEAR else None


def is_detached_from_first(expected: Floats, got: Floats, landmarks: tuple[Floats, Floats] | None = None) -> bool:
    """Whether the poses `got` (n, 3) are those `expected`, moved as a whole, but for the first one, which stands right.

    Either the positions turn about the first pose while all headings stay right, or every other pose makes one rigid
    motion. `landmarks`, expected and obtained, each (m, 2), move with the poses. False below four poses.
    """
    if len(expected) < 4 or np.abs(_gaps(expected[:1], got[:1])).max() > NEAR:
        return False
    more = landmarks or (np.empty((0, 2)), np.empty((0, 2)))
    all_expected, all_got = np.vstack([expected[:, :2], more[0]]), np.vstack([got[:, :2], more[1]])
    turned = _gaps(expected, got)[1:, 2]
    if turn_about_first(all_expected, all_got) is not None and np.abs(turned).max() < NEAR:
        return True
    turn = rigid_motion_between(all_expected[1:], all_got[1:])
    moved = float(np.abs(all_expected - all_got).max()) > LEAST_TURN
    return turn is not None and moved and float(np.abs(wrap_angle(turned - turn)).max()) < NEAR


def _gaps(expected: Floats, got: Floats) -> Floats:
    """Differences (n, 3) between poses, angles modulo 2 pi."""
    return np.column_stack([(got - expected)[:, :2], wrap_angle((got - expected)[:, 2])])
