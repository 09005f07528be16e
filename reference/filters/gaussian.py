"""The Gaussian belief that the Kalman filter, the extended and the unscented one share.

Sources: Kalman, "A New Approach to Linear Filtering and Prediction Problems" (1960); Bucy and Joseph, "Filtering for
Stochastic Processes" (1968), for the form of the correction that keeps a covariance a covariance; Bar-Shalom, Li,
Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), section 5.4, for NEES and NIS.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.filters.models import GaussianModel, log_normal
from reference.filters.moments import Flags, subtract_vectors, wrap_angles

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Innovation:
    """What a measurement brought: its `difference` (m,) with what was expected, and the `covariance` S (m, m) of that.

    `nis` is the normalised innovation squared, on average m for a filter that is consistent.
    """

    difference: Floats
    covariance: Floats

    @property
    def nis(self) -> float:
        return float(self.difference @ np.linalg.solve(self.covariance, self.difference))

    @property
    def log_density(self) -> float:
        """log N(difference; 0, S): the logarithm of the evidence."""
        return float(log_normal(self.difference, self.covariance))


class GaussianBelief:
    """The belief N(mean, covariance): mean (d,), covariance (d, d).

    Raises InvalidArgumentError for a mean or a covariance of another shape, not finite, not symmetric or with a
    negative variance.
    """

    def __init__(self, model: GaussianModel, mean: ArrayLike, covariance: ArrayLike) -> None:
        start, spread = np.array(mean, dtype=np.float64), np.array(covariance, dtype=np.float64)
        d = model.state_angles.size
        if start.shape != (d,) or not np.all(np.isfinite(start)):
            raise InvalidArgumentError("mean", f"of shape {start.shape} is not an array ({d},) of finite numbers")
        if spread.shape != (d, d) or not np.allclose(spread, spread.T) or np.linalg.eigvalsh(spread)[0] < -1e-12:
            raise InvalidArgumentError("covariance", f"of shape {spread.shape} is not a covariance ({d}, {d})")
        self.innovation: Innovation | None = None
        self._mean, self._covariance, self._angles = start, spread, model.state_angles

    @property
    def mean(self) -> Floats:
        return self._mean.copy()

    @property
    def covariance(self) -> Floats:
        return self._covariance.copy()

    def nees(self, truth: ArrayLike) -> float:
        """The normalised estimation error squared e^T P^-1 e for the true state (d,): on average d if consistent."""
        error = subtract_vectors(np.asarray(truth, dtype=np.float64), self._mean, self._angles)
        return float(error @ np.linalg.solve(self._covariance, error))

    def _store_belief(self, mean: Floats, covariance: Floats) -> None:
        """Take the new belief, its angles wrapped and its covariance symmetric in spite of rounding."""
        self._mean, self._covariance = wrap_angles(mean, self._angles), 0.5 * (covariance + covariance.T)


def compute_gain(cross: Floats, innovation_covariance: Floats) -> Floats:
    """K = C S^-1, (d, m): from the covariance C (d, m) of state and measurement. Raises InvalidArgumentError."""
    try:
        return np.asarray(np.linalg.solve(innovation_covariance, cross.T).T)
    except np.linalg.LinAlgError:
        raise InvalidArgumentError("measurement_noise", "leaves a singular innovation covariance") from None


def joseph_update(covariance: Floats, K: Floats, H: Floats, R: Floats) -> Floats:
    """(I - K H) P (I - K H)^T + K R K^T, (d, d): right for any gain, and positive whatever rounding does.      (1)"""
    left = np.eye(len(covariance)) - K @ H
    return np.asarray(left @ covariance @ left.T + K @ R @ K.T)


def check_vector(argument: str, values: ArrayLike, size: int | None = None) -> Floats:
    """The array (size,) of finite numbers that a control or a measurement must be. Raises InvalidArgumentError."""
    vector = np.asarray(values, dtype=np.float64)
    if vector.ndim != 1 or (size is not None and vector.size != size) or not np.isfinite(vector).all():
        length = "n" if size is None else size
        raise InvalidArgumentError(argument, f"of shape {vector.shape} is not an array ({length},) of finite numbers")
    return vector


def make_innovation(measurement: ArrayLike, expected: Floats, covariance: Floats, angles: Flags) -> Innovation:
    """The innovation of a measurement (m,), its angles compared the short way round. Raises InvalidArgumentError."""
    return Innovation(
        subtract_vectors(check_vector("measurement", measurement, angles.size), expected, angles), covariance
    )
