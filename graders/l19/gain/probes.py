"""What the three functions are asked by hand: unequal variances, more than two measurements, an exact sensor."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import (
    AnswerRule,
    ProbeResults,
    Probes,
    measurement_rule,
    read_array_or_reason,
    read_number_or_reason,
    to_finite_array,
)
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments
from graders.l19.gain.cases import row
from graders.l19.pairs import ReadPair, only

NAMES = ("moyenne", "variance")
KIT = KitSettings("l19", {"seed": 0})

GAINS: tuple[Arguments, ...] = (
    (2.2, 0.45),
    (0.3517, 3.1),
    (5.3, 2.15),
    (1.7, 0.0),
    (0.0, 0.8),
    (1.3, 0.6),
)
OPINIONS: tuple[Arguments, ...] = (
    (row(1.3, 3.1, 2.2), row(2.2, 0.45, 1.7)),
    (row(-4.1, -2.6), row(0.3517, 3.1)),
    (row(3.7, 0.4, 1.9, 5.2), row(5.3, 2.15, 0.6, 3.4)),
    (row(7.1, 6.4, 9.3, 8.8, 7.7), row(0.9, 1.6, 0.2, 2.8, 1.1)),
)
CHAINS: tuple[Arguments, ...] = (
    (1.3, 2.2, row(3.1, 2.4, 0.7), row(0.45, 1.9, 0.8)),
    (-4.1, 0.3517, row(-2.6, -3.3), row(3.1, 0.6)),
    (3.7, 5.3, row(0.4, 2.9, 1.1, 4.6), row(2.15, 0.7, 3.3, 1.2)),
    (0.6, 1.4, row(1.9, 2.3, 5.0), row(0.5, 0.0, 2.1)),
    (2.1, 0.9, row(1.4, 3.2, 2.6), row(0.7, 1.3, 0.0)),
)


def only_column(which: int, name: str) -> AnswerRule:
    """The name for chains of which the other column is always right, and this one never from end to end."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        for seen, right in zip(shown.got, shown.right, strict=True):
            found = to_finite_array(seen, np.shape(right))
            if found is None:
                return None
            same = np.isclose(found, right, 1e-7, 1e-7).all(axis=0)
            if not same[1 - which] or same[which]:
                return None
        return name

    return rule


PROBES = (
    Probes(function="gain", calls=GAINS, kit=KIT, read=read_number_or_reason),
    Probes(
        function="fusionner",
        calls=OPINIONS,
        kit=KIT,
        read=ReadPair(NAMES),
        rules=(only(0, "moyenne_fausse"), only(1, "variance_fausse")),
    ),
    Probes(
        function="enchainer",
        calls=CHAINS,
        kit=KIT,
        read=read_array_or_reason,
        rules=(only_column(0, "moyenne_fausse"), only_column(1, "variance_fausse")),
    ),
)
