"""What both functions are asked by hand: no symmetric F, correlated P, unequal shapes, an H of each kind."""

from __future__ import annotations

from graders.core.code.probes import Probes
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments
from graders.l19.matrice.pictures import NAMES
from graders.l19.matrices import matrix, vector
from graders.l19.pairs import ReadPair, only

KIT = KitSettings("l19", {"seed": 0})

STEPS: tuple[Arguments, ...] = (
    (
        vector(1.3, -2.2),
        matrix((2.1, 0.4), (0.4, 1.7)),
        matrix((1.2, 0.7), (-0.3, 0.9)),
        matrix((0.6, 0.2), (0.2, 1.1)),
    ),
    (vector(-0.7, 3.1), matrix((1.4, -0.6), (-0.6, 3.2)), matrix((0.5, -1.6), (1.1, 0.3)), matrix((0, 0), (0, 0))),
    (
        vector(0.5, 1.4, -0.8),
        matrix((2.3, 0.5, -0.3), (0.5, 1.2, 0.25), (-0.3, 0.25, 3.4)),
        matrix((1, 0.5, 0.2), (-0.4, 1.3, 0.6), (0.7, 0, 0.8)),
        matrix((0.9, 0.1, 0), (0.1, 0.35, 0.15), (0, 0.15, 0.45)),
    ),
    (vector(2.6), matrix((1.9,)), matrix((-0.7,)), matrix((0.4,))),
)
READINGS: tuple[Arguments, ...] = (
    (vector(1.3, -2.2), matrix((2.1, 0.4), (0.4, 1.7)), vector(3.1), matrix((0.8, -0.5)), matrix((0.6,))),
    (
        vector(-0.7, 3.1),
        matrix((1.4, -0.6), (-0.6, 3.2)),
        vector(0.4, 1.9),
        matrix((0.5, -1.6), (1.1, 0.3)),
        matrix((0.7, 0.2), (0.2, 1.3)),
    ),
    (
        vector(0.5, 1.4, -0.8),
        matrix((2.3, 0.5, -0.3), (0.5, 1.2, 0.25), (-0.3, 0.25, 3.4)),
        vector(1.2, -0.9),
        matrix((1, 0.5, 0.2), (-0.4, 1.3, 0.6)),
        matrix((0.9, 0.1), (0.1, 0.35)),
    ),
    (vector(2.6), matrix((1.9,)), vector(1.1), matrix((-0.7,)), matrix((0.4,))),
)

PROBES = (
    Probes(
        function="predire",
        calls=STEPS,
        kit=KIT,
        read=ReadPair(NAMES),
        rules=(only(0, "etat_faux"), only(1, "covariance_fausse", range(3))),
    ),
    Probes(
        function="corriger",
        calls=READINGS,
        kit=KIT,
        read=ReadPair(NAMES),
        rules=(only(0, "etat_faux"), only(1, "covariance_fausse", range(3))),
    ),
)
