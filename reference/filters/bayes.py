"""The Bayes filter: one interface for every representation of a belief.

Theorem 1 of the course: when the state is Markov and measurements depend on the present state alone, then

    bel-(x_t) = integral of p(x_t | x_{t-1}, u_t) bel(x_{t-1}) dx_{t-1}              (prediction)              (1)
    bel(x_t)  = p(z_t | x_t) bel-(x_t) / p(z_t | z_1 … z_{t-1}, u_1 … u_t)           (correction)              (2)

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), table 2.1.
"""

from __future__ import annotations

import math
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.filters.log_weights import NormalisedWeights, normalise_log_weights

Floats = NDArray[np.float64]
Control_contra = TypeVar("Control_contra", contravariant=True)
Measurement_contra = TypeVar("Measurement_contra", contravariant=True)


class ImpossibleMeasurementError(InvalidArgumentError):
    """A measurement of probability zero wherever the belief is positive: (2) would divide by zero.

    The belief is left as it was before the correction.
    """

    def __init__(self) -> None:
        super().__init__("measurement", "has probability zero wherever the belief is positive")


class BayesFilter(Protocol[Control_contra, Measurement_contra]):
    """A belief over states of d components, moved by controls and sharpened by measurements."""

    @property
    def mean(self) -> Floats:
        """The mean (d,) of the belief; of the components that are angles, the circular mean."""

    @property
    def covariance(self) -> Floats:
        """The covariance (d, d) of the belief about its mean."""

    def predict(self, control: Control_contra) -> None:
        """Equation (1). Raises InvalidArgumentError."""

    def correct(self, measurement: Measurement_contra) -> float:
        """Equation (2); returns log p(z_t | z_1 … z_{t-1}, u_1 … u_t), the logarithm of its denominator.

        Raises InvalidArgumentError.
        """


def reweight(weights: Floats, log_likelihoods: Floats) -> NormalisedWeights:
    """Equation (2) for a belief held by n weights of sum one: times likelihoods (n,), normalised.

    `log_sum` is the log evidence. Raises ImpossibleMeasurementError when every product is zero, and
    InvalidArgumentError when a likelihood is no number.
    """
    with np.errstate(divide="ignore"):
        logs = np.log(weights) + log_likelihoods
    greatest = float(logs.max())
    if greatest == -np.inf:
        raise ImpossibleMeasurementError
    if not math.isfinite(greatest):
        raise InvalidArgumentError("measurement", "has a likelihood that is infinite or not a number")
    return normalise_log_weights(logs)
