"""The scans and the walks of the probes, made on purpose.

The walks of `candidats_boucle` hold the same few scans again and again: their distances are zero or far from it, in
every norm and for every signature that tells places apart.
"""

from __future__ import annotations

import numpy as np

from graders.core.contract.values import Arguments, Floats
from graders.l20.boucles.calibration import HUGE
from graders.l20.boucles.trials import BOWL, NARROW, RAMP, TIED_SHIFTS, TIES, WIDE

A, B, C = RAMP, BOWL + 0.37, 12.5 - RAMP[::-1] ** 0.9
TINY = 1e-7


def _walk(pattern: str) -> Floats:
    return np.array([{"A": A, "B": B, "C": C, "a": np.roll(A, 7)}[place] for place in pattern])


LONG = "ABCABBCAABCBACBBACABCABA"
LOOKED: tuple[Arguments, ...] = (
    (_walk(LONG), 23, TINY),
    (_walk(LONG), 23, HUGE),
    (_walk(LONG), 15, TINY),
    (_walk(LONG[:16]), 12, HUGE),
    (_walk(LONG), 10, TINY),
    (_walk("BACABBCAABCBB"), 11, TINY),
    (_walk(LONG[:14]), 9, HUGE),
    (_walk(LONG[:14]), 4, HUGE),
    (_walk(LONG[:14]), 0, HUGE),
    (_walk("C" + LONG[1:]), 23, TINY),
    (_walk("C" + LONG[1:]), 23, HUGE),
)
TURNED: tuple[Arguments, ...] = ((_walk("aBCaBBCAaBCBaCBBaCaBCAbA".replace("b", "B")), 23, TINY),)


def _same_norm() -> Floats:
    """A scan unlike A, of the same norm, and so are their spectra by Parseval, whole or half; nothing else is the same.

    For the half, the sum and the last harmonic are two numbers whose squares add up to the same.
    """
    alternate = (-1.0) ** np.arange(36)
    shape = np.random.default_rng(5).permutation(C)
    shape -= shape.mean()
    shape -= alternate * (shape @ alternate) / 36
    total, last = A.sum(), A @ alternate
    middle = (0.96 * total + alternate * np.sqrt(last**2 + (1.0 - 0.96**2) * total**2)) / 36
    return np.asarray(middle + np.sqrt((A @ A - middle @ middle) / (shape @ shape)) * shape)


RIPPLE = 0.05 * np.sin(np.arange(36))
LOWER = [0.4 * A + RIPPLE, 0.55 * A + 2.0 * RIPPLE, np.minimum(0.7 * A, 5.0)]
HIGHER = [1.2 * A + RIPPLE, 1.1 * A + 2.0 * RIPPLE, 1.15 * A + np.roll(RIPPLE, 9)]
#: Lower in sum alone, higher in sum alone, then as spread out as the last scan, and nearly the same.
NEITHER = [
    np.concatenate([0.7 * A[:30], np.full(6, 11.5)]),
    np.concatenate([1.1 * A[:30] + 2.0, np.full(6, 0.7)]),
    0.9 * A + 0.7,
    0.99 * A - 0.2 * (-1.0) ** np.arange(36),
]


def _akin(asked: Floats) -> Arguments:
    """From this scan, A at 0, and at 12 by another heading: places 1 to 3 are lower in all than A, 4 to 6 higher, 7 of
    the same norm, 8 to 11 none of these."""
    return np.array([A, *LOWER, *HIGHER, _same_norm(), *NEITHER, np.roll(A, 7), *[B] * 9, asked]), 22, TINY


AKIN: tuple[Arguments, ...] = (_akin(A), _akin(LOWER[0]), _akin(HIGHER[0]))

RAISED = RAMP.copy()
RAISED[17] += 0.6


def _with(ray: int, distance: float) -> Floats:
    """The ramp, one ray of which is another one."""
    return np.where(np.arange(36) == ray, distance, RAMP)


ENDS: dict[int, tuple[Floats, ...]] = {
    0: (_with(0, 0.5), _with(0, 5.3), _with(0, 20.0), np.concatenate([RAMP[:1], np.roll(RAMP[1:], 9)])),
    35: (_with(35, 0.5), _with(35, 5.3), _with(35, 20.0), np.concatenate([np.roll(RAMP[:-1], 9), RAMP[-1:]])),
}
"""By the ray at an end of the scan: scans that are the same to a signature that overlooks it, and forgets the order."""
SIGNED: tuple[Arguments, ...] = tuple(
    (scan,)
    for scan in (
        RAMP, np.roll(RAMP, 1), np.roll(RAMP, 9), BOWL, TIES, *(np.roll(TIES, k) for k in TIED_SHIFTS), RAISED,
        _with(17, 20.0), *ENDS[0], *ENDS[35], NARROW, WIDE,
    )
)  # fmt: skip
SAME, TIED, MIDDLE = (0, 1, 2), (4, 5, 6, 7), 9
AT_END = {0: range(10, 14), 35: range(14, 18)}
REPEATED = (18, 19)
