"""What both functions are asked by hand: each cause of a reading in its turn, a long scan, a few maps."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import AnswerRule, ProbeResults, Probes, measurement_rule, undo_rule
from graders.core.contract.values import Arguments, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.modele_faisceau.cases import CORNER, FAR, KNIGHT, OPEN, ROOM, SQUARE, reading

ALPHA, BETA = (0.55, 0.22, 0.15, 0.08), (0.3, 0.1, 0.4, 0.2)
READINGS: tuple[Arguments, ...] = (
    reading([6.1, 4.3], [5.8, 4.0], 0.3, 10.0, ALPHA, 0.7),
    reading([2.0], [5.0], 0.3, 10.0, ALPHA, 0.7),
    reading([10.0], [5.0], 0.3, 10.0, ALPHA, 0.7),
    reading([4.5], [4.5], 0.3, 10.0, ALPHA, 0.7),
    reading([10.0], [10.0], 0.3, 10.0, ALPHA, 0.7),
    reading([6.5, 3.0, 1.5, 2.5, 8.0], [5.0, 3.5, 7.0, 2.5, 8.0], 1.4, 8.0, BETA, 0.3),
    reading(np.linspace(0.5, 8.5, 40), np.full(40, 4.3), 0.6, 9.0, BETA, 1.6),
    reading(np.full(400, 2.0), np.full(400, 9.0), 0.2, 11.0, ALPHA, 0.4),
)
SHORT, FULL = (1, 3, 4, 5, 6, 7), (2, 4, 5)
MAPS: tuple[Arguments, ...] = tuple((libres,) for libres in (CORNER, KNIGHT, FAR, ROOM, OPEN, SQUARE))


def read(args: Arguments, value: Value) -> Value:
    """The numbers; in words what holds none."""
    try:
        return read_array(value)
    except UnreadableError as error:
        return str(error)


def only(name: str, among: tuple[int, ...]) -> AnswerRule:
    """All is right but some of these probes."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        return name if set(shown.wrong_indices()) <= set(among) else None

    return rule


@undo_rule
def too_long_or_too_short(shown: ProbeResults) -> str | None:
    """Never nearer than right, sometimes further, and right along rows and columns: a search by steps."""
    fields = [one if isinstance(one, np.ndarray) and one.shape == right.shape else None
              for one, right in zip(shown.got, shown.right, strict=True)]  # fmt: skip
    for args, field, right in zip(shown.calls, fields, shown.right, strict=True):
        if field is None or not np.all(np.isfinite(field)) or np.any(field < right - 1e-9):
            return None
        if np.any(field > np.sqrt(2.0) * right + 1e-9) or np.any(field[~args[0]] != 0.0):
            return None
    return "distance_par_pas"


PROBES = (
    Probes(
        function="log_vraisemblance",
        calls=READINGS,
        kit=world.STILL,
        read=read,
        rules=(only("imprevu_mal_traite", SHORT), only("portee_mal_traitee", FULL)),
    ),
    Probes(function="champ_distance", calls=MAPS, kit=world.STILL, read=read, rules=(too_long_or_too_short,)),
)
