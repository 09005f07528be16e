"""What the three functions are asked by hand: correlated doubts, odd levels, means on either side of their bands."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes, read_number_or_reason
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments
from graders.l19.coherence.cases import drawn_runs
from graders.l19.matrices import matrix, vector
from graders.l19.pairs import ReadPair, only

ENDS, VERDICT = ("bas", "haut"), ("NEES moyen", "avis")
KIT = KitSettings("l19", {"seed": 0})
STEADY = np.random.default_rng(7)

ERRORS: tuple[Arguments, ...] = (
    (vector(1.3, -2.2), vector(0.4, -0.9), matrix((2.1, 0.4), (0.4, 1.7))),
    (vector(-0.7, 3.1), vector(0.6, 1.8), matrix((1.4, -0.6), (-0.6, 3.2))),
    (vector(0.5, 1.4, -0.8), vector(1.9, 0.7, 0.3), matrix((2.3, 0.5, -0.3), (0.5, 1.2, 0.25), (-0.3, 0.25, 3.4))),
    (vector(2.6), vector(1.1), matrix((1.9,))),
)
BANDS: tuple[Arguments, ...] = (
    (2, 7, 0.9),
    (3, 11, 0.7),
    (1, 30, 0.98),
    (2, 13),
    (4, 1, 0.8),
    (2, 7, 0.6),
    (7, 2, 0.9),
)
RUNS: tuple[Arguments, ...] = (
    drawn_runs(STEADY, 2, 7, 0.55),
    drawn_runs(STEADY, 3, 9, 1.6),
    drawn_runs(STEADY, 2, 12, -0.4),
    drawn_runs(STEADY, 1, 15, 0.93),
    drawn_runs(STEADY, 2, 14, 0.05),
    drawn_runs(STEADY, 2, 20, 1.05),
    drawn_runs(STEADY, 3, 16, -0.06),
    drawn_runs(STEADY, 2, 8, 4.5),  # above the band of a single run
)


PROBES = (
    Probes(function="nees", calls=ERRORS, kit=KIT, read=read_number_or_reason),
    Probes(function="bande", calls=BANDS, kit=KIT, read=ReadPair(ENDS)),
    Probes(
        function="coherence",
        calls=RUNS,
        kit=KIT,
        read=ReadPair(VERDICT),
        rules=(only(0, "moyenne_fausse"), only(1, "avis_faux", ())),
    ),
)
