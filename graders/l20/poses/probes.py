"""What the functions on poses are asked by hand: any headings, pure rotations, sums beyond half a turn."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graders.core.code.probes import AnswerRule, ProbeAnswer, ProbeResults, Probes, measurement_rule, to_finite_array
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import world

A = np.array([1.3, -2.1, 0.6])
B = np.array([2.7, 0.4, -1.1])
PAIRS: tuple[tuple[Sequence[float], Sequence[float]], ...] = (
    ((1.3, -2.1, 0.6), (2.7, 0.4, -1.1)),
    ((-3.2, 1.4, -2.3), (1.1, 2.6, 0.8)),
    ((0.5, 0.7, 2.9), (-1.6, 2.2, 1.2)),
    ((4.1, -0.3, -2.8), (0.9, -1.7, -1.9)),
    ((2.2, 3.1, 2.6), (-1.4, -0.6, -2.7)),
    ((-1.7, 0.8, -1.5), (2.3, 3.6, 2.9)),
    ((-0.8, 1.9, -1.4), (2.2, -0.7, -1.0)),
    ((0.6, -1.2, 1.3), (-2.1, 0.9, -1.1)),
    ((0.0, 0.0, 0.0), (1.5, 2.5, 0.0)),
    ((1.0, 2.0, math.pi / 2), (1.0, 0.0, 0.0)),
)


def pairs() -> tuple[Arguments, ...]:
    return tuple((np.array(a), np.array(b)) for a, b in PAIRS)


def read(args: Arguments, value: Value) -> Value:
    """The pose (3,); in words what is none."""
    try:
        pose = read_array(value)
    except UnreadableError as error:
        return str(error)
    return pose if pose.shape == (3,) else f"forme {pose.shape}"


def position(args: Arguments, shown: ProbeAnswer) -> ProbeAnswer:
    return shown[:2] if isinstance(shown, np.ndarray) else shown


def angle(args: Arguments, shown: ProbeAnswer) -> ProbeAnswer:
    return shown[2:] if isinstance(shown, np.ndarray) else shown


def _poses(shown: ProbeResults) -> tuple[Floats, Floats] | None:
    """What came back and what is right, (n, 3) both, when all are poses."""
    rows = [to_finite_array(one, (3,)) for one in shown.got]
    if any(row is None for row in rows):
        return None
    return np.array(rows), np.array(shown.right)


def _same(a: Floats, b: Floats) -> bool:
    return bool(np.allclose(a, b, atol=1e-7))


@measurement_rule
def only_turns(shown: ProbeResults) -> str | None:
    """All is right up to whole turns."""
    both = _poses(shown)
    if both is None or not _same(both[0][:, :2], both[1][:, :2]):
        return None
    gap = (both[0][:, 2] - both[1][:, 2]) / math.tau
    return "angle_non_ramene" if _same(gap, np.round(gap)) else None


def only_angle(name: str) -> AnswerRule:
    """The position is right everywhere, the angle is not."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        both = _poses(shown)
        return name if both is not None and _same(both[0][:, :2], both[1][:, :2]) else None

    return rule


def only_position(name: str) -> AnswerRule:
    """The angle is right everywhere, up to whole turns; the position is wrong with most headings."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        both = _poses(shown)
        if both is None:
            return None
        gap = (both[0][:, 2] - both[1][:, 2]) / math.tau
        wrong = np.any(np.abs(both[0][:, :2] - both[1][:, :2]) > 1e-6, axis=1)
        return name if _same(gap, np.round(gap)) and np.sum(wrong) >= 4 else None

    return rule


def _probes(function: str, calls: tuple[Arguments, ...]) -> Probes:
    rules = (only_turns, only_angle(f"{function}_angle"), only_position(f"{function}_position"))
    return Probes(function=function, calls=calls, kit=world.STILL, read=read, rules=rules, facet=position)


PROBES = (
    _probes("composer", pairs()),
    _probes("inverse", tuple((a,) for a, _ in pairs())),
    _probes("relatif", pairs()),
)
