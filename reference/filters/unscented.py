"""The unscented Kalman filter: the models are applied to a few points that carry mean and covariance exactly.

Sources: Julier and Uhlmann, "Unscented Filtering and Nonlinear Estimation" (2004); Wan and van der Merwe, "The
Unscented Kalman Filter for Nonlinear Estimation" (2000) for the scaled weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.filters.gaussian import GaussianBelief, check_vector, compute_gain, make_innovation
from reference.filters.models import GaussianModel
from reference.filters.moments import subtract_vectors, weighted_covariance, weighted_mean

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class UnscentedParameters:
    """How far the sigma points lie (`alpha`, `kappa`), and what is known beyond the covariance (`beta`, 2: Gaussian).

    Raises InvalidArgumentError unless alpha > 0.
    """

    alpha: float = 1.0
    beta: float = 2.0
    kappa: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.alpha < np.inf:
            raise InvalidArgumentError("alpha", f"{self.alpha} is not a positive number")


@dataclass(frozen=True, eq=False)
class SigmaPoints:
    """Points (2 d + 1, d) and their weights (2 d + 1,), for means and for covariances."""

    points: Floats
    mean_weights: Floats
    covariance_weights: Floats

    @classmethod
    def from_gaussian(cls, mean: Floats, covariance: Floats, spread: UnscentedParameters) -> SigmaPoints:
        """mu and mu +- the columns of sqrt((d + lambda) P), with lambda = alpha^2 (d + kappa) - d              (1)

        Weights: lambda / (d + lambda) in the middle, 1 / (2 (d + lambda)) elsewhere; for covariances the middle one
        has 1 - alpha^2 + beta more. Raises InvalidArgumentError unless d + kappa > 0.
        """
        d = mean.size
        scale = spread.alpha**2 * (d + spread.kappa)
        if scale <= 0.0:
            raise InvalidArgumentError("kappa", f"{spread.kappa} leaves no spread in dimension {d}")
        arms = _square_root(scale * covariance).T
        for_mean = np.full(2 * d + 1, 0.5 / scale)
        for_mean[0] = 1.0 - d / scale
        for_covariance = for_mean.copy()
        for_covariance[0] += 1.0 - spread.alpha**2 + spread.beta
        return cls(np.vstack([mean, mean + arms, mean - arms]), for_mean, for_covariance)


class UnscentedKalmanFilter(GaussianBelief):
    """A BayesFilter over a GaussianModel whose Jacobians are never asked for."""

    def __init__(
        self, model: GaussianModel, mean: ArrayLike, covariance: ArrayLike, spread: UnscentedParameters | None = None
    ) -> None:
        super().__init__(model, mean, covariance)
        self.model, self.spread = model, spread or UnscentedParameters()

    def predict(self, control: ArrayLike) -> None:
        """Move sigma points of state and noise together; take their mean and covariance."""
        u = check_vector("control", control)
        M, d = self.model.motion_noise(u), self._mean.size
        joint = np.zeros((d + len(M), d + len(M)))
        joint[:d, :d], joint[d:, d:] = self._covariance, M
        sigma = SigmaPoints.from_gaussian(np.concatenate([self._mean, np.zeros(len(M))]), joint, self.spread)
        moved = self.model.move(sigma.points[:, :d], u, sigma.points[:, d:])
        mean = weighted_mean(moved, sigma.mean_weights, self._angles)
        self._store_belief(mean, weighted_covariance(moved, sigma.covariance_weights, mean, self._angles))

    def correct(self, measurement: ArrayLike) -> float:
        """S and C from what sigma points would measure, K = C S^-1, mu <- mu + K (z - mean), P <- P - K S K^T."""
        angles = self.model.measurement_angles
        sigma = SigmaPoints.from_gaussian(self._mean, self._covariance, self.spread)
        seen = self.model.observe(sigma.points)
        expected = weighted_mean(seen, sigma.mean_weights, angles)
        S = weighted_covariance(seen, sigma.covariance_weights, expected, angles) + self.model.measurement_noise
        away = sigma.points - self._mean
        C = away.T @ (sigma.covariance_weights[:, None] * subtract_vectors(seen, expected, angles))
        brought = make_innovation(measurement, expected, S, angles)
        K = compute_gain(C, S)
        evidence = brought.log_density
        self._store_belief(self._mean + K @ brought.difference, self._covariance - K @ S @ K.T)
        self.innovation = brought
        return evidence


def _square_root(covariance: Floats) -> Floats:
    """A square root A, A A^T = covariance, that also exists where a variance is zero."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
