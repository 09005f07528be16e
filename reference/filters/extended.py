"""The extended Kalman filter: nonlinear models, replaced by their tangents at the mean.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), table 3.3, with the correction in the form of Joseph.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from reference.filters.gaussian import GaussianBelief, check_vector, compute_gain, joseph_update, make_innovation
from reference.filters.models import GaussianModel


class ExtendedKalmanFilter(GaussianBelief):
    """A BayesFilter over a GaussianModel that knows its Jacobians."""

    def __init__(self, model: GaussianModel, mean: ArrayLike, covariance: ArrayLike) -> None:
        super().__init__(model, mean, covariance)
        self.model = model

    def predict(self, control: ArrayLike) -> None:
        """mu <- f(mu, u, 0), P <- F P F^T + V M V^T, with F and V the derivatives of f by state and noise."""
        u = check_vector("control", control)
        F, V = self.model.move_jacobians(self._mean, u)
        M = self.model.motion_noise(u)
        moved = self.model.move(self._mean[None, :], u, np.zeros((1, len(M))))[0]
        self._store_belief(moved, F @ self._covariance @ F.T + V @ M @ V.T)

    def correct(self, measurement: ArrayLike) -> float:
        """As the Kalman filter, with H the derivative of h at the mean, and h(mu) as what was expected."""
        H, R, P = self.model.observe_jacobian(self._mean), self.model.measurement_noise, self._covariance
        expected = self.model.observe(self._mean[None, :])[0]
        brought = make_innovation(measurement, expected, H @ P @ H.T + R, self.model.measurement_angles)
        K = compute_gain(P @ H.T, brought.covariance)
        evidence = brought.log_density
        self._store_belief(self._mean + K @ brought.difference, joseph_update(P, K, H, R))
        self.innovation = brought
        return evidence
