"""What `lancer_rayon` is asked by hand, and what its answers tell of the way in which it casts rays."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from graders.core.code.probes import (
    AnswerRule,
    ProbeAnswer,
    ProbeFault,
    ProbeResults,
    Probes,
    ProgramTrial,
    experiment_rule,
    measurement_rule,
    same_probe_answer,
)
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments, UnreadableError, Value, read_scalar
from graders.l20 import world
from graders.l20.lidar.cases import CORRIDOR, QUARTER, ROOM, TALL, WIDE, distance
from graders.l20.lidar.checks import ACCEPTED

WITHOUT = ("lidar", "lidar_lot")
KIT = KitSettings(world.MODULE, {"libres": None, "portee_max": world.RANGE, "seed": 0}, without=WITHOUT)
#: Steps that are looked for, in twentieths of a cell.
STRIDES = range(3, 31)
#: The longest range that is asked.
LONGEST = 12.0
#: Steps along one axis that are looked for, in cells.
AXIS_STRIDES = (0.001, 0.002, 0.005, 0.01, 0.02, 0.025, 0.03, 0.04, *(part / 20 for part in range(1, 21)))
#: Sines and cosines below this are taken as this, so that a step is finite.
FLAT = 1e-12
#: The step along a ray of cosine c and sine s, for a step of 1 in x, in y, or on the axis nearer to the ray.
AXES: tuple[Callable[[float, float], float], ...] = (
    lambda c, s: 1 / max(abs(c), FLAT),
    lambda c, s: 1 / max(abs(s), FLAT),
    lambda c, s: 1 / max(abs(c), abs(s)),
)
ROUNDING = 1e-6

CALLS: tuple[Arguments, ...] = (
    (ROOM, 6.3, 3.7, 2.2, 12.0),
    (ROOM, 2.3, 3.7, QUARTER, 12.0),
    (ROOM, 4.4, 3.3, -0.3, 12.0),
    (ROOM, 7.3, 1.6, 2.8, 12.0),
    (ROOM, 1.4, 5.5, 0.0, 4.0),
    (ROOM, 1.4, 5.5, 0.0, 9.0),
    (WIDE, 4.3, 3.6, math.pi, 12.0),
    (WIDE, 4.3, 3.6, -1.25, 12.0),
    (TALL, 1.6, 4.3, 0.35, 12.0),
    (TALL, 1.6, 4.3, 1.9, 12.0),
    (WIDE, 7.8, 1.3, -QUARTER, 12.0),
    (WIDE, 3.4, 5.3, -2.6, 12.0),
    (TALL, 4.3, 1.2, 1.3, 3.3),
    (CORRIDOR, 17.3, 1.6, 0.0, 9.5),
    (CORRIDOR, 27.3, 1.6, 0.0, 12.0),
    (ROOM, 1.4, 5.5, 0.0, 7.3),
    (ROOM, 4.4, 5.3, -1.5, 12.0),
    (ROOM, 8.6, 1.4, 1.54, 12.0),
    (ROOM, 1.4, 5.5, 0.03, 12.0),
    (ROOM, 8.6, 1.6, 3.1, 12.0),
    (ROOM, 1.5, 5.2, -0.8, 12.0),
    (ROOM, 8.6, 5.2, -2.3, 12.0),
)
OPEN = (6, 7, 8, 9, 10, 11)
RANGED = (4, 12, 13, 15)
#: The probes whose rays meet a wall.
MEETING = tuple(k for k, args in enumerate(CALLS) if distance(*args) < args[4])


def read(args: Arguments, value: Value) -> Value:
    """The distance; in words what is none."""
    try:
        return read_scalar(value)
    except UnreadableError as error:
        return str(error)


def same(one: ProbeAnswer, other: ProbeAnswer) -> bool:
    """Do two distances differ by an honest step at most? Whoever marches may make the mistake of whoever walks."""
    if isinstance(one, float) and isinstance(other, float) and math.isfinite(one) and math.isfinite(other):
        return abs(one - other) <= ACCEPTED
    return same_probe_answer(one, other)


def _lengths(shown: ProbeResults) -> list[float] | None:
    """What came back, when all are finite lengths."""
    rows = [one for one in shown.got if not isinstance(one, ProbeFault | str | None)]
    return rows if len(rows) == len(shown.got) and all(math.isfinite(one) for one in rows) else None


@measurement_rule
def long_strides(shown: ProbeResults) -> str | None:
    """The answers are those of a march whose step is longer than asked; a corner may have been jumped over."""
    lengths = _lengths(shown)
    marching = lengths is not None and any(_marched(shown, lengths, parts / 20) for parts in STRIDES)
    return "pas_trop_grand" if marching else None


def _marched(shown: ProbeResults, lengths: Sequence[float], stride: float) -> bool:
    """Does each wrong answer, but for a few, lie where steps of this length first meet the wall, or one step before?"""
    wrong = shown.wrong_indices()
    for back in (0.0, stride):
        ends = {k: math.ceil(distance(*shown.calls[k]) / stride) * stride - back for k in wrong}
        near = [k for k in wrong if abs(ends[k] - lengths[k]) <= ACCEPTED]
        exact = [k for k in near if k in MEETING and abs(ends[k] - lengths[k]) < 1e-6]
        if len(exact) >= 2 and 4 * len(near) >= 3 * len(wrong):
            return True
    return False


@measurement_rule
def axis_strides(shown: ProbeResults) -> str | None:
    """The answers are those of a march whose step is constant on one axis, so that its length depends on the angle; a
    corner may have been jumped over."""
    lengths = _lengths(shown)
    wrong = set(shown.wrong_indices()).intersection(MEETING)
    if lengths is None or not wrong:
        return None
    for axis in AXES:
        for advance in AXIS_STRIDES:
            strides = [advance * axis(*_direction(args)) for args in shown.calls]
            for part in (0.0, 0.5):
                exact = {k for k in MEETING if _ends_a_step(lengths[k] - part * strides[k], strides[k], shown.calls[k])}
                blamed = wrong.intersection(exact)
                if 4 * len(exact) >= 3 * len(MEETING) and 4 * len(blamed) >= 3 * len(wrong):
                    return "pas_sur_un_axe"
    return None


def _ends_a_step(length: float, stride: float, args: Arguments) -> bool:
    """Whether this is a whole number of steps, less than a step away from the wall, or the range before such a step."""
    is_near = abs(length - distance(*args)) < stride + ROUNDING
    return is_near and (abs(length - round(length / stride) * stride) < ROUNDING or abs(length - args[4]) < ROUNDING)


def _direction(args: Arguments) -> tuple[float, float]:
    return math.cos(args[3]), math.sin(args[3])


def _asked_farther(args: Arguments) -> Arguments:
    """The same ray with the longest range."""
    return (*args[:4], LONGEST)


def _walled(args: Arguments) -> Arguments:
    """The same ray in the same map, surrounded by walls."""
    libres, x, y, angle, portee_max = args
    return np.pad(libres, 1), x + 1.0, y + 1.0, angle, portee_max


#: Rays that meet a wall far from their start within the longest range, near to an axis and slanted.
FAR_RAYS: tuple[Arguments, ...] = tuple(
    (*ray, LONGEST)
    for ray in (
        (ROOM, 4.4, 5.3, -1.55), (ROOM, 4.6, 1.3, 1.6), (ROOM, 1.4, 1.6, 0.02), (ROOM, 8.6, 5.4, 3.12),
        (ROOM, 4.3, 1.4, 1.55), (ROOM, 4.4, 1.4, 0.7), (CORRIDOR, 20.3, 1.6, 0.02), (CORRIDOR, 10.6, 2.3, -3.1),
    )
)  # fmt: skip


def only(name: str, among: tuple[int, ...], but_for: Callable[[Arguments], Arguments]) -> AnswerRule:
    """All is right but some of these probes, which are right when they are asked without what is blamed.

    A probe that would have the same answer then says nothing, so that another one must be wrong. Long rays must be
    right too: what is wrong with those that meet a wall has another cause.
    """

    def is_right_otherwise(trial: ProgramTrial) -> bool:
        """Are these rays right without what is blamed, and long rays too?"""
        calls = [but_for(CALLS[k]) for k in trial.ask_probes().wrong_indices()]
        asked = [*(args for args in calls if distance(*args) < args[4]), *FAR_RAYS]
        answers = trial.ask(asked)
        return len(asked) > len(FAR_RAYS) and all(
            same(answer, distance(*args)) for args, answer in zip(asked, answers, strict=True)
        )

    @experiment_rule(is_right_otherwise)
    def rule(shown: ProbeResults) -> str | None:
        return name if set(shown.wrong_indices()) <= set(among) else None

    return rule


PROBES = (
    Probes(
        function="lancer_rayon",
        calls=CALLS,
        kit=KIT,
        read=read,
        same=same,
        rules=(
            long_strides,
            axis_strides,
            only("bord_mal_traite", OPEN, _walled),
            only("portee_mal_traitee", RANGED, _asked_farther),
        ),
    ),
)
