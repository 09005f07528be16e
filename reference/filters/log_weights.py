"""Weights kept as logarithms: products of thousands of small likelihoods that never underflow.

A log weight of -inf is a weight of zero. Source: the identity log sum exp(l) = m + log sum exp(l - m), m = max l.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.filters.resampling import InvalidWeightsError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NormalisedWeights:
    """`weights` (n,) of sum 1, and `log_sum`, the logarithm of what they summed to before."""

    weights: Floats
    log_sum: float


def normalise_log_weights(log_weights: ArrayLike) -> NormalisedWeights:
    """Weights exp(l_i) / sum of exp(l_j) from log weights (n,), whatever their size.

    Raises InvalidWeightsError when all are -inf, or when one is NaN or +inf.
    """
    logs = np.asarray(log_weights, dtype=np.float64)
    if logs.ndim != 1 or logs.size == 0:
        raise InvalidWeightsError(f"must have shape (n,) with n >= 1, not {logs.shape}")
    greatest = float(logs.max())
    if math.isnan(greatest) or greatest == np.inf:
        raise InvalidWeightsError("have a logarithm that is NaN or +inf")
    if greatest == -np.inf:
        raise InvalidWeightsError("are all zero")
    weights = np.exp(logs - greatest)
    total = float(weights.sum())
    weights /= total
    return NormalisedWeights(weights, greatest + math.log(total))
