"""Robust kernels: what a gap of d costs, when a few of the gaps are lies.

A kernel holds a cost rho(d) and a weight w(d) = d rho / d(d^2), for gaps d >= 0 in the unit of its scale. Every rho
here grows with d and is concave in d^2; so the weighted squares of w lie above rho and touch it where the weights were
taken, and minimising them can only lower the sum of rho. That is why iterative reweighting never climbs.

Sources: Huber, "Robust Estimation of a Location Parameter" (1964); Holland and Welsch, "Robust Regression Using
Iteratively Reweighted Least-Squares" (1977), for Cauchy; Beaton and Tukey, "The Fitting of Power Series" (1974).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]


class Kernel(Protocol):
    """A cost of gaps, and the weight that each gap has in the least squares that stand in for it."""

    def cost(self, gaps: Floats) -> Floats:
        """rho(d), elementwise."""

    def weight(self, gaps: Floats) -> Floats:
        """d rho / d(d^2), elementwise."""


@dataclass(frozen=True)
class LeastSquares:
    """rho = d^2: every gap counts."""

    def cost(self, gaps: Floats) -> Floats:
        """d^2, elementwise, without a factor of 1/2."""
        return np.square(gaps)

    def weight(self, gaps: Floats) -> Floats:
        return np.ones_like(gaps)


@dataclass(frozen=True)
class _ScaledKernel:
    """A kernel with a length, beyond which a gap is suspect."""

    scale: float

    def __post_init__(self) -> None:
        if not 0.0 < self.scale < np.inf:
            raise InvalidArgumentError("scale", f"{self.scale} is not a positive length")


@dataclass(frozen=True)
class Huber(_ScaledKernel):
    """rho = d^2 up to the scale s, 2 s d - s^2 beyond: a far point pulls with a constant force."""

    def cost(self, gaps: Floats) -> Floats:
        return np.where(gaps < self.scale, gaps**2, 2.0 * self.scale * gaps - self.scale**2)

    def weight(self, gaps: Floats) -> Floats:
        return self.scale / np.maximum(gaps, self.scale)


@dataclass(frozen=True)
class Cauchy(_ScaledKernel):
    """rho = s^2 log(1 + (d/s)^2): the farther, the weaker the pull."""

    def cost(self, gaps: Floats) -> Floats:
        return np.asarray(self.scale**2 * np.log1p((gaps / self.scale) ** 2))

    def weight(self, gaps: Floats) -> Floats:
        return np.asarray(1.0 / (1.0 + (gaps / self.scale) ** 2))


@dataclass(frozen=True)
class Tukey(_ScaledKernel):
    """rho = s^2/3 (1 - (1 - (d/s)^2)^3) up to the scale s, s^2/3 beyond: a far point does not pull at all."""

    def cost(self, gaps: Floats) -> Floats:
        return np.asarray(self.scale**2 / 3.0 * (1.0 - self._remaining_share(gaps) ** 3))

    def weight(self, gaps: Floats) -> Floats:
        return self._remaining_share(gaps) ** 2

    def _remaining_share(self, gaps: Floats) -> Floats:
        return np.asarray(1.0 - np.minimum(gaps / self.scale, 1.0) ** 2)
