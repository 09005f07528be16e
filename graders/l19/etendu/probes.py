"""What both functions are asked by hand: beacons on all sides, never at the origin nor along an axis."""

from __future__ import annotations

from graders.core.code.probes import Probes
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments
from graders.l19.etendu.pictures import RANGE, STATE
from graders.l19.matrices import matrix, vector
from graders.l19.pairs import ReadPair, only

KIT = KitSettings("l19", {"seed": 0})

PLACES: tuple[Arguments, ...] = (
    (vector(1.3, -2.2), vector(3.1, 0.7)),
    (vector(-0.7, 3.1), vector(-2.4, 1.9)),
    (vector(2.6, 0.4), vector(0.9, 5.3)),
    (vector(-4.1, -1.2), vector(1.7, -3.6)),
)
READINGS: tuple[Arguments, ...] = (
    (vector(1.3, -2.2), matrix((2.1, 0.4), (0.4, 1.7)), 4.3, vector(3.1, 0.7), 0.6),
    (vector(-0.7, 3.1), matrix((1.4, -0.6), (-0.6, 3.2)), 1.2, vector(-2.4, 1.9), 1.7),
    (vector(2.6, 0.4), matrix((0.8, 0.3), (0.3, 0.5)), 5.9, vector(0.9, 5.3), 0.23),
    (vector(-4.1, -1.2), matrix((3.3, 1.1), (1.1, 2.4)), 5.4, vector(1.7, -3.6), 2.9),
)

PROBES = (
    Probes(
        function="distance_et_jacobien",
        calls=PLACES,
        kit=KIT,
        read=ReadPair(RANGE, loose=True),
        rules=(only(0, "distance_fausse"), only(1, "jacobienne_fausse")),
    ),
    Probes(
        function="corriger_distance",
        calls=READINGS,
        kit=KIT,
        read=ReadPair(STATE),
        rules=(only(0, "etat_faux"), only(1, "covariance_fausse")),
    ),
)
