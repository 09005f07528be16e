"""A random interval that gives the magnitude of a number without revealing it."""

from __future__ import annotations

import math

import numpy as np

NEAREST, FURTHEST = 1.3, 3.0  # how far the ends are, as factors


def rounded_bounds_around(magnitude: float, rng: np.random.Generator) -> tuple[float, float]:
    """Return two rounded bounds around a positive `magnitude`, at independent random distances."""
    below, above = np.exp(rng.uniform(np.log(NEAREST), np.log(FURTHEST), 2))
    return _round_away(magnitude / below, math.floor), _round_away(magnitude * above, math.ceil)


def _round_away(size: float, towards: object) -> float:
    """Round to one significant digit, away from the value."""
    assert callable(towards)
    exponent = math.floor(math.log10(size))
    return float(f"{towards(size / 10.0**exponent) * 10.0**exponent:.6g}")
