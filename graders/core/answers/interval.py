"""An interval that says where a number is, without saying the number."""

from __future__ import annotations

import math

import numpy as np

NEAREST, FURTHEST = 1.3, 3.0  # how far the ends are, as factors


def around(value: float, rng: np.random.Generator) -> tuple[float, float]:
    """Two rounded ends on either side of `value`, on its side of zero, each at a distance of its own."""
    if value == 0.0:
        return -1.0, 1.0
    below, above = np.exp(rng.uniform(np.log(NEAREST), np.log(FURTHEST), 2))
    size = abs(value)
    low, high = _rounded(size / below, math.floor), _rounded(size * above, math.ceil)
    return (low, high) if value > 0 else (-high, -low)


def _rounded(size: float, towards: object) -> float:
    """One significant digit, away from the value."""
    assert callable(towards)
    exponent = math.floor(math.log10(size))
    return float(f"{towards(size / 10.0**exponent) * 10.0**exponent:.6g}")
