"""The Kalman filter of a single number, for many runs at once: means (n,), and the variance that they share.

    predict    m <- m + u,          v <- v + q                                                                 (1)
    correct    m <- m + K (z - m),  v <- (1 - K)^2 v + K^2 r                                                   (2)

(2) holds for any gain K; the variance is least for that of Kalman, K = v / (v + r), and is then (1 - K) v = K r.

Source: Kalman, "A New Approach to Linear Filtering and Prediction Problems" (1960); (2) is the form of Joseph.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ScalarBelief:
    """The beliefs N(mean_i, variance) of n runs. Raises InvalidArgumentError for a variance that is negative."""

    mean: Floats
    variance: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.variance < np.inf:
            raise InvalidArgumentError("variance", f"{self.variance} is no variance")

    @property
    def sigma(self) -> float:
        return float(np.sqrt(self.variance))

    def predict(self, control: float, noise: float) -> ScalarBelief:
        """(1): a move of `control`, whose noise has this variance."""
        return ScalarBelief(self.mean + control, self.variance + noise)

    def correct(self, measurement: ArrayLike, noise: float, gain: float | None = None) -> ScalarBelief:
        """(2): measurements (n,), whose noise has this variance; with Kalman's gain unless another is given."""
        K = kalman_gain(self.variance, noise) if gain is None else gain
        mean = self.mean + K * (np.asarray(measurement, dtype=np.float64) - self.mean)
        return ScalarBelief(mean, (1.0 - K) ** 2 * self.variance + K**2 * noise)

    def nees(self, truth: ArrayLike) -> Floats:
        """The normalised estimation errors squared (m - x)^2 / v of the runs, (n,): 1 on average if consistent."""
        return np.asarray((self.mean - np.asarray(truth, dtype=np.float64)) ** 2 / self.variance)


def kalman_gain(variance: float, noise: float) -> float:
    """v / (v + r). Raises InvalidArgumentError where both are zero: two certainties cannot be weighed."""
    if not variance + noise > 0.0:
        raise InvalidArgumentError("noise", "and the variance are both zero")
    return variance / (variance + noise)


def steady_state_variance(motion_noise: float, noise: float) -> float:
    """The variance after a correction to which a filter settles, when it predicts and corrects for ever.

    Before the correction p, after it p r / (p + r), and p = q + p r / (p + r):

        p^2 - q p - q r = 0                                                                                    (3)

    Raises InvalidArgumentError unless both are non-negative and the measurement's is positive.
    """
    if not (motion_noise >= 0.0 and noise > 0.0):
        raise InvalidArgumentError("noise", "is not positive, or that of the motion is negative")
    before = 0.5 * (motion_noise + np.sqrt(motion_noise**2 + 4.0 * motion_noise * noise))
    return float(before * noise / (before + noise))


def mean_nees_band(runs: int, dimension: int = 1, level: float = 0.95) -> tuple[float, float]:
    """Where the mean NEES of independent runs of a consistent filter lies, with probability `level`.

    runs x mean is a chi-square of runs x dimension degrees of freedom, twice a gamma of half of them; each side leaves
    out half of the rest. Source: Bar-Shalom, Li, Kirubarajan (2001), section 5.4.2. Raises InvalidArgumentError.
    """
    if runs < 1 or dimension < 1 or not 0.0 < level < 1.0:
        raise InvalidArgumentError("runs", f"{runs}, dimension {dimension} or level {level} is out of range")
    ends = (1.0 - level) / 2.0, (1.0 + level) / 2.0
    low, high = (2.0 * float(gammaincinv(0.5 * runs * dimension, end)) / runs for end in ends)
    return low, high
