"""What `lancer_rayon` is asked by hand, and what its answers tell of the way in which it casts rays."""

from __future__ import annotations

import math
from collections.abc import Sequence

from graders.core.code.probes import (
    AnswerRule,
    ProbeAnswer,
    ProbeFault,
    ProbeResults,
    Probes,
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
)
OPEN = (6, 7, 8, 9, 10, 11)
RANGED = (4, 12, 13, 15)


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
        exact = [k for k in near if abs(ends[k] - lengths[k]) < 1e-6]
        if len(exact) >= 2 and 4 * len(near) >= 3 * len(wrong):
            return True
    return False


def only(name: str, among: tuple[int, ...]) -> AnswerRule:
    """All is right but some of these probes."""

    @measurement_rule
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
        rules=(long_strides, only("bord_mal_traite", OPEN), only("portee_mal_traitee", RANGED)),
    ),
)
