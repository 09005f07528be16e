"""Wrong bearings of the rays of a scan, recognised by the cells that rise and fall, whatever a program does elsewhere.

Where two rays meet, programs differ: each ray may count, or a wall may win over the rays that cross it. Only cells that
all rays of a wrong scan cross, stop in or miss are looked at.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.occupation.cells import Mask
from graders.l20.occupation.judge import Integration

#: From the number of rays to the bearings (n,) from the heading, in radians.
Bearings = Callable[[int], Floats]

TURN = 2.0 * math.pi
#: The bearings that the usual mistakes give, by the id of the mistake.
WRONG_BEARINGS: tuple[tuple[str, Bearings], ...] = (
    ("rayons_mal_repartis", lambda n: np.linspace(0.0, TURN, n)),
    ("rayons_mal_repartis", lambda n: TURN * (np.arange(n) + 1) / n),
    ("rayons_mal_repartis", lambda n: TURN * (np.arange(n) + 0.5) / n),
    ("rayons_mal_repartis", lambda n: TURN * np.arange(n) / (n + 1)),
    ("rayons_mal_repartis", lambda n: TURN * np.arange(n) / n - math.pi),
    ("rayons_mal_repartis", lambda n: np.linspace(-math.pi, math.pi, n)),
    ("rayons_mal_repartis", lambda n: TURN * np.arange(n) / 36),
    ("rayons_mal_repartis", lambda n: np.arange(n) / n),
    ("rayons_mal_repartis", lambda n: np.arange(float(n))),
    ("rayons_mal_repartis", lambda n: 2.0 * TURN * np.arange(n) / n),
    ("sens_des_rayons", lambda n: -TURN * np.arange(n) / n),
    ("demi_tour_seulement", lambda n: math.pi * np.arange(n) / n),
)


def predicted_signs(case: Integration, bearings: Floats) -> tuple[Floats, Mask]:
    """Return the sign (H, W) of each cell's change under these bearings (n,), and whether it is certain (H, W)."""
    certain = np.ones(case.l.shape, dtype=bool)
    rises, falls = np.zeros_like(certain), np.zeros_like(certain)
    for distance, bearing in zip(case.scan, bearings, strict=True):
        pose = np.add(case.pose, (0.0, 0.0, bearing))
        seen = Integration(case.l, pose, np.array([distance]), case.portee_max).told
        certain &= seen.crossed | seen.stopped | seen.untouched
        rises |= seen.stopped
        falls |= seen.crossed
    return 1.0 * rises - 1.0 * falls, certain & ~(rises & falls)


def recognise_bearings(cases: Iterable[tuple[Integration, Floats]]) -> str | None:
    """Return the mistake whose bearings explain all signs of change, each (H, W), of empty grids.

    Cells that the right rays leave open have to be 0 in them. None where several mistakes explain them, or none does.
    """
    scans = list(cases)
    names = {name for name, bearings in WRONG_BEARINGS if _explain(scans, bearings)}
    return names.pop() if len(names) == 1 else None


def _explain(scans: Sequence[tuple[Integration, Floats]], bearings: Bearings) -> bool:
    """Whether these bearings explain every sign, and the right ones do not."""
    has_wrong = False
    for case, got in scans:
        signs, is_certain = predicted_signs(case, bearings(len(case.scan)))
        seen = case.told
        cells = is_certain & (seen.crossed | seen.stopped | seen.untouched)
        right = 1.0 * seen.stopped - 1.0 * seen.crossed
        if np.any(signs[cells] != got[cells]):
            return False
        has_wrong = has_wrong or bool(np.any(signs[cells] != right[cells]))
    return has_wrong
