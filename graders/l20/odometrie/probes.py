"""What both functions are asked by hand: turns both ways, backwards, straight ahead, on the spot, round the back."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.probes import (
    AnswerRule,
    ProbeAnswer,
    ProbeResults,
    Probes,
    measurement_rule,
    read_number_or_reason,
    to_finite_array,
)
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.odometrie.cases import pose, turn

STEPS: tuple[Arguments, ...] = (
    (pose(1.3, -2.1, 0.6), 1.35, 3.15, 1.5),
    (pose(-3.2, 1.4, -2.3), 0.62, 0.23, 0.45),
    (pose(0.5, 0.7, 2.4), -0.31, -0.84, 1.3),
    (pose(4.1, -0.3, -1.8), -0.92, -0.57, 0.6),
    (pose(2.2, 3.1, 2.6), 0.15, 0.65, 0.5),
    (pose(-1.7, 0.8, -2.9), 0.73, 0.28, 0.4),
    (pose(0.4, -1.5, 0.9), 0.55, 0.55, 0.8),
    (pose(-0.6, 2.3, -1.1), -0.25, 0.25, 0.9),
    (pose(1.9, 0.2, 3.0), -0.65, -0.15, 0.3),
)
ROUND_THE_BACK = (4, 5, 8)
STRAIGHT, ON_THE_SPOT = 6, 7
BACKWARDS = (2, 3, 8)

SPREADS: tuple[Arguments, ...] = (
    (0.03, 0.08, 0.4),
    (0.5, 0.2, 1.7),
    (0.011, 0.043, 0.25),
    (0.21, 0.0, 0.6),
    (0.0, 0.37, 1.3),
    (0.09, 0.09, 0.8),
)


def read(args: Arguments, value: Value) -> Value:
    """The pose (3,); in words what is none."""
    try:
        found = read_array(value)
    except UnreadableError as error:
        return str(error)
    return found if found.shape == (3,) else f"forme {found.shape}"


def position(args: Arguments, shown: ProbeAnswer) -> ProbeAnswer:
    return shown[:2] if isinstance(shown, np.ndarray) else shown


def _poses(shown: ProbeResults) -> tuple[Floats, Floats] | None:
    """What came back and what is right, (n, 3) both, when all are poses."""
    rows = [to_finite_array(one, (3,)) for one in shown.got]
    if any(row is None for row in rows):
        return None
    return np.array(rows), np.array(shown.right)


def _same(one: Floats, other: Floats) -> bool:
    return bool(np.allclose(one, other, atol=1e-7))


def _whole_turns(both: tuple[Floats, Floats]) -> bool:
    turns = (both[0][:, 2] - both[1][:, 2]) / math.tau
    return _same(turns, np.round(turns))


@measurement_rule
def only_turns(shown: ProbeResults) -> str | None:
    """All is right up to whole turns."""
    both = _poses(shown)
    return "angle_non_ramene" if both and _same(both[0][:, :2], both[1][:, :2]) and _whole_turns(both) else None


@measurement_rule
def only_heading(shown: ProbeResults) -> str | None:
    """Every position is right, and no heading of a step that turns."""
    both = _poses(shown)
    if both is None or not _same(both[0][:, :2], both[1][:, :2]):
        return None
    turning = {k for k, args in enumerate(shown.calls) if turn(args)}
    return "cap_faux" if turning <= set(shown.wrong_indices()) else None


@measurement_rule
def only_position(shown: ProbeResults) -> str | None:
    """Every heading is right up to whole turns, and no position of a step that advances."""
    both = _poses(shown)
    if both is None or not _whole_turns(both):
        return None
    moved = [k for k in range(len(shown.calls)) if k not in (STRAIGHT, ON_THE_SPOT)]
    return "position_fausse" if np.all(np.abs(both[0] - both[1])[moved, :2].max(axis=1) > 1e-6) else None


def only(name: str, places: tuple[int, ...]) -> AnswerRule:
    """Wrong on these, all of them, and nowhere else."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        return name if set(shown.wrong_indices()) == set(places) else None

    return rule


@measurement_rule
def constant_factor(shown: ProbeResults) -> str | None:
    """One multiple of what is right, whatever the wheels and the track."""
    values = np.array([math.nan if (one := to_finite_array(seen, ())) is None else float(one) for seen in shown.got])
    with np.errstate(all="ignore"):
        factors = values / np.array(shown.right, dtype=float)
    return "facteur_constant" if np.all(factors > 0) and np.ptp(factors) < 1e-6 * factors[0] else None


PROBES = (
    Probes(
        function="odometrie",
        calls=STEPS,
        kit=world.STILL,
        read=read,
        rules=(
            only_turns,
            only_heading,
            only("marche_arriere", BACKWARDS),
            only_position,
        ),
        facet=position,
    ),
    Probes(
        function="sigma_dtheta", calls=SPREADS, kit=world.STILL, read=read_number_or_reason, rules=(constant_factor,)
    ),
)
