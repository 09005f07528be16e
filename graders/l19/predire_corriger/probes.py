"""What both functions are asked by hand: numbers whose sums, products, squares and roots all differ."""

from __future__ import annotations

from graders.core.code.probes import Probes
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments
from graders.l19.pairs import ReadPair, only

NAMES = ("moyenne", "variance")
KIT = KitSettings("l19", {"seed": 0})

MOVES: tuple[Arguments, ...] = (
    (1.3, 2.2, 0.7, 0.45),
    (-4.1, 0.35, 2.6, 3.1),
    (3.7, 5.3, -1.9, 0.15),
    (-0.6137, 0.8429, -2.3718, 1.7354),
    (2.9, 1.4, 0.0, 0.6),
)
READINGS: tuple[Arguments, ...] = (
    (1.3, 2.2, 3.1, 0.45),
    (-4.1, 0.35, -2.6, 3.1),
    (3.7, 5.3, 0.4, 2.15),
    (-0.6, 0.8, -2.3, 1.7),
    (2.9, 1.4, 5.5, 0.6),
    (2.4, 1.1, 2.4, 0.7),
)

PROBES = (
    Probes(
        function="predire",
        calls=MOVES,
        kit=KIT,
        read=ReadPair(NAMES),
        rules=(only(0, "moyenne_fausse", range(4)), only(1, "variance_fausse")),
    ),
    Probes(
        function="corriger",
        calls=READINGS,
        kit=KIT,
        read=ReadPair(NAMES),
        rules=(only(0, "moyenne_fausse", range(5)), only(1, "variance_fausse")),
    ),
)
