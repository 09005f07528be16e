"""Particle weights: the effective sample size, and systematic resampling.

Weights are an array (n,) of finite non-negative numbers, not all zero; they need not sum to one.

Sources: Kong, Liu, Wong, "Sequential Imputations and Bayesian Missing Data Problems" (1994) for N_eff; Kitagawa,
"Monte Carlo Filter and Smoother for Non-Gaussian Nonlinear State Space Models" (1996), appendix, for the comb.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class InvalidWeightsError(InvalidArgumentError):
    """Weights that are not an array (n,), n >= 1, of finite non-negative numbers with a positive, finite sum."""

    def __init__(self, reason: str) -> None:
        super().__init__("weights", reason)


class InvalidOffsetError(InvalidArgumentError):
    """An offset outside [0, 1[."""

    def __init__(self, offset: float) -> None:
        super().__init__("offset", f"{offset} is outside [0, 1[")


@dataclass(frozen=True)
class Resampling:
    """Which old particle each new one copies: `ancestors` (n,), increasing."""

    ancestors: Integers

    @property
    def copies(self) -> Integers:
        """How many times each old particle is copied, (n,), summing to n."""
        return np.bincount(self.ancestors, minlength=self.ancestors.size)


def effective_sample_size(weights: ArrayLike) -> float:
    """N_eff = (sum w)^2 / sum w^2, which is 1 / sum w^2 for normalised weights; between 1 and n.

    Raises InvalidWeightsError.
    """
    w = _valid(weights)
    shares = w / _positive_sum(float(np.sum(w)))
    return float(1.0 / (shares @ shares))


def systematic_resampling(weights: ArrayLike, rng: np.random.Generator) -> Resampling:
    """Resample with a single uniform draw: unbiased, and every particle has floor or ceil(n w) copies.

    Raises InvalidWeightsError.
    """
    return comb(weights, rng.random())


def comb(weights: ArrayLike, offset: float) -> Resampling:
    """Lay the teeth m + offset, m = 0 … n - 1, over the cumulative weights scaled to n.

    Tooth m falls on the first particle i with m + offset < n C_i, where C_i = w_0 + … + w_i. The teeth that lie below
    the end of particle i are in number

        K_i = ceil(n C_i - offset)                                                                             (1)

    so the ancestor of tooth m is the number of particles with K_i <= m: counting replaces searching. Raises
    InvalidWeightsError, and InvalidOffsetError unless 0 <= offset < 1.
    """
    if not 0.0 <= offset < 1.0:
        raise InvalidOffsetError(offset)
    teeth = np.cumsum(_valid(weights))
    n, total = teeth.size, _positive_sum(float(teeth[-1]))
    # Every tooth lies below the end of the last particle of positive weight, whatever rounding says.
    last = int(np.searchsorted(teeth, total))
    teeth /= total
    teeth *= n
    teeth -= offset
    # The counts of (1) take the place of the numbers they come from: at a million particles, memory is what costs.
    passed = teeth.view(np.int64)
    np.ceil(teeth, out=passed, casting="unsafe")
    passed[last:] = n
    return Resampling(np.cumsum(np.bincount(passed, minlength=n)[:n], out=passed))


def _valid(weights: ArrayLike) -> Floats:
    w = np.asarray(weights, dtype=np.float64)
    if w.ndim != 1 or w.size == 0:
        raise InvalidWeightsError(f"must have shape (n,) with n >= 1, not {w.shape}")
    if not w.min() >= 0.0:
        raise InvalidWeightsError("hold a negative number or NaN")
    return w


def _positive_sum(total: float) -> float:
    """A sum that can be divided by; zero also stands for likelihoods that all underflowed."""
    if total == 0.0:
        raise InvalidWeightsError("are all zero")
    if not np.isfinite(total):
        raise InvalidWeightsError("have no finite sum")
    return total
