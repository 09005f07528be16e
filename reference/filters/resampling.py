"""Particle weights: the effective sample size, and four ways to resample.

Weights are an array (n,) of finite non-negative numbers, not all zero; they need not sum to one. All four schemes are
unbiased: particle i has on average count w_i / (sum of w) copies. They differ in the spread about it, least with
systematic resampling, greatest with multinomial.

Sources: Kong, Liu, Wong, "Sequential Imputations and Bayesian Missing Data Problems" (1994) for N_eff; Kitagawa,
"Monte Carlo Filter and Smoother for Non-Gaussian Nonlinear State Space Models" (1996), appendix, for the comb; Douc,
Cappé, Moulines, "Comparison of Resampling Schemes for Particle Filtering" (2005) for the others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# The comb is laid over this many particles at a time, so that what is computed on the way stays in the processor's
# cache: at a million particles, memory is what costs.
_BLOCK = 65536
# Over a whole block, so many running sums are taken side by side: in a single one, each addition waits for the last.
_GROUP = 4
# A sum above this may be divided into any number of particles that fits in memory.
_SMALL = 1e-290


class InvalidWeightsError(InvalidArgumentError):
    """Weights that are not an array (n,), n >= 1, of finite non-negative numbers with a positive, finite sum."""

    def __init__(self, reason: str) -> None:
        super().__init__("weights", reason)


class InvalidOffsetError(InvalidArgumentError):
    """An offset outside [0, 1[."""

    def __init__(self, offset: float) -> None:
        super().__init__("offset", f"{offset} is outside [0, 1[")


@dataclass(frozen=True, eq=False)
class Resampling:
    """Which of the `particles` old ones each new one copies: `ancestors` (count,), increasing."""

    ancestors: Integers
    particles: int

    @property
    def copies(self) -> Integers:
        """How many times each old particle is copied, (particles,), summing to the count of new ones."""
        return np.bincount(self.ancestors, minlength=self.particles)


Scheme = Callable[[ArrayLike, np.random.Generator, "int | None"], Resampling]


def effective_sample_size(weights: ArrayLike) -> float:
    """N_eff = (sum w)^2 / sum w^2, which is 1 / sum w^2 for normalised weights; between 1 and n.

    Raises InvalidWeightsError.
    """
    w = _check_nonnegative_weights(weights)
    shares = w / _check_positive_sum(w)
    return float(1.0 / (shares @ shares))


def systematic_resampling(weights: ArrayLike, rng: np.random.Generator, count: int | None = None) -> Resampling:
    """Resample with a single uniform draw: every particle has floor or ceil(count w) copies.

    `count` new particles are drawn, by default as many as there are. Raises InvalidWeightsError.
    """
    return comb_resampling(weights, rng.random(), count)


def comb_resampling(weights: ArrayLike, offset: float, count: int | None = None) -> Resampling:
    """Lay the teeth m + offset, m = 0 … count - 1, over the cumulative weights scaled to `count`, by default n.

    Tooth m falls on the first particle i with m + offset < count C_i, where C_i = w_0 + … + w_i. The teeth that lie
    below the end of particle i are in number

        K_i = ceil(count C_i - offset)                                                                         (1)

    so the ancestor of tooth m is the number of particles with K_i <= m: counting replaces searching. Raises
    InvalidWeightsError, InvalidOffsetError unless 0 <= offset < 1, and InvalidArgumentError unless count >= 1.
    """
    if not 0.0 <= offset < 1.0:
        raise InvalidOffsetError(offset)
    w = _check_shape(weights)
    teeth, total = _check_count(count, w.size), _check_positive_sum(w)
    ancestors = np.empty(teeth, dtype=np.int64)
    end = _last_positive_index(w) + 1
    if end < w.size:
        _check_not_negative(w[end:])
    if total <= _SMALL:
        w, total = w / total, 1.0
    buffer = np.empty(min(_BLOCK, end))
    placed, start = 0, -offset
    for first in range(0, end, _BLOCK):
        ends = _running_sums(_check_not_negative(w[first : min(first + _BLOCK, end)]), teeth / total, start, buffer)
        reached = float(ends[-1])
        # The counts of (1), less those already placed, take the place of the numbers they come from.
        below = ends.view(np.int64)
        np.ceil(ends, out=below, casting="unsafe")
        # Every tooth lies below the end of the last particle of positive weight, whatever rounding says.
        if first + _BLOCK >= end:
            below[-1] = teeth - placed
        if below[-1] > teeth - placed or first + _BLOCK >= end:
            np.minimum(below, teeth - placed, out=below)
        start = reached - int(below[-1])
        placed = _write_ancestors(ancestors, placed, below, first)
    return Resampling(ancestors, w.size)


def _running_sums(w: Floats, scale: float, start: float, buffer: Floats) -> Floats:
    """start + scale (w_0 + … + w_i) for each i, in `buffer`: the last one last, others in any order."""
    sums = buffer[: w.size]
    if w.size < _BLOCK:
        np.multiply(w, scale, out=sums)
        sums[0] += start
        return np.add.accumulate(sums, out=sums)
    groups = sums.reshape(_GROUP, -1)
    np.multiply(w.reshape(-1, _GROUP).T, scale, out=groups)
    for before, row in pairwise(groups):
        np.add(before, row, out=row)
    starts = np.empty(groups.shape[1])
    starts[0], starts[1:] = start, groups[-1, :-1]
    groups += np.add.accumulate(starts, out=starts)
    return sums


def _write_ancestors(ancestors: Integers, placed: int, below: Integers, first: int) -> int:
    """Write the ancestors of the teeth from number `placed` on: `below` (k,) of them lie below the ends of particles
    `first`, …, in any order but for the last one's. Returns how many teeth have theirs."""
    passed, more = np.bincount(below), int(below[-1])
    passed[0] += first
    np.add.accumulate(passed[:more], out=ancestors[placed : placed + more])
    return placed + more


def stratified_resampling(weights: ArrayLike, rng: np.random.Generator, count: int | None = None) -> Resampling:
    """Resample with one uniform draw for each tooth m + u_m: less regular than the comb, and its teeth independent.

    The teeth below s = count C_i are the floor(s) whole ones, and the next one when its u is less than the rest:

        K_i = floor(s) + [u_floor(s) < s - floor(s)]                                                           (2)

    Raises InvalidWeightsError, and InvalidArgumentError unless count >= 1.
    """
    w = _check_nonnegative_weights(weights)
    teeth = _check_count(count, w.size)
    ends = np.minimum(np.cumsum(w / _check_positive_sum(w)) * teeth, teeth)
    ends[_last_positive_index(w) :] = teeth
    whole = ends.astype(np.int64)
    offsets = np.append(rng.random(teeth), 1.0)
    below = whole + (offsets[whole] < ends - whole)
    return Resampling(np.cumsum(np.bincount(below, minlength=teeth)[:teeth]), w.size)


def multinomial_resampling(weights: ArrayLike, rng: np.random.Generator, count: int | None = None) -> Resampling:
    """Resample by independent draws: the plainest scheme, and the one with the greatest spread.

    Raises InvalidWeightsError, and InvalidArgumentError unless count >= 1.
    """
    w = _check_nonnegative_weights(weights)
    drawn = _draw_multinomial_counts(w / _check_positive_sum(w), _check_count(count, w.size), rng)
    return Resampling(np.repeat(np.arange(w.size), drawn), w.size)


def residual_resampling(weights: ArrayLike, rng: np.random.Generator, count: int | None = None) -> Resampling:
    """Keep floor(count w_i) copies of each particle for sure, and draw the rest independently from what is left.

    Raises InvalidWeightsError, and InvalidArgumentError unless count >= 1.
    """
    w = _check_nonnegative_weights(weights)
    total, teeth = _check_positive_sum(w), _check_count(count, w.size)
    shares = w / total * teeth
    # A share that rounding has put just below a whole number is that number.
    copies = np.floor(shares * (1.0 + 4.0 * np.finfo(np.float64).eps)).astype(np.int64)
    left = np.maximum(shares - copies, 0.0)
    missing = teeth - int(copies.sum())
    if missing > 0:
        copies += _draw_multinomial_counts(left / left.sum(), missing, rng)
    return Resampling(np.repeat(np.arange(w.size), copies), w.size)


def _draw_multinomial_counts(shares: Floats, draws: int, rng: np.random.Generator) -> Integers:
    """How often each particle is drawn. The generator gives what rounding leaves to its last category: make it one
    that may be drawn, the greatest."""
    last = int(np.argmax(shares))
    order = np.append(np.delete(np.arange(shares.size), last), last)
    copies = np.empty(shares.size, dtype=np.int64)
    copies[order] = rng.multinomial(draws, shares[order])
    return copies


def _check_nonnegative_weights(weights: ArrayLike) -> Floats:
    return _check_not_negative(_check_shape(weights))


def _check_shape(weights: ArrayLike) -> Floats:
    w = np.asarray(weights, dtype=np.float64)
    if w.ndim != 1 or w.size == 0:
        raise InvalidWeightsError(f"must have shape (n,) with n >= 1, not {w.shape}")
    return w


def _check_not_negative(w: Floats) -> Floats:
    if not w.min() >= 0.0:
        raise InvalidWeightsError("hold a negative number or NaN")
    return w


def _check_count(count: int | None, particles: int) -> int:
    if count is None:
        return particles
    if count < 1:
        raise InvalidArgumentError("count", f"{count} particles cannot carry a belief")
    return count


def _check_positive_sum(w: Floats) -> float:
    """A sum that can be divided by; zero also stands for likelihoods that all underflowed."""
    total = float(w.sum())
    if total == 0.0:
        raise InvalidWeightsError("are all zero")
    if not 0.0 < total < np.inf:
        raise InvalidWeightsError("have no finite sum, or a negative one")
    return total


def _last_positive_index(w: Floats) -> int:
    """The index of the last particle of positive weight."""
    return w.size - 1 if w[-1] > 0.0 else w.size - 1 - int(np.argmax(w[::-1] > 0.0))
