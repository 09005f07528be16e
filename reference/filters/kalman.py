"""The Kalman filter: exact when the models are linear and the noises Gaussian."""

from __future__ import annotations

from numpy.typing import ArrayLike

from reference.filters.gaussian import GaussianBelief, check_vector, compute_gain, joseph_update, make_innovation
from reference.filters.models import LinearGaussian


class KalmanFilter(GaussianBelief):
    """A BayesFilter over a LinearGaussian problem."""

    def __init__(self, model: LinearGaussian, mean: ArrayLike, covariance: ArrayLike) -> None:
        super().__init__(model, mean, covariance)
        self.model = model

    def predict(self, control: ArrayLike) -> None:
        """mu <- F mu + B u, P <- F P F^T + Q."""
        F, B = self.model.F, self.model.B
        u = check_vector("control", control, B.shape[1])
        self._store_belief(F @ self._mean + B @ u, F @ self._covariance @ F.T + self.model.Q)

    def correct(self, measurement: ArrayLike) -> float:
        """S = H P H^T + R, K = P H^T S^-1, mu <- mu + K (z - H mu - c), P by the form of Joseph."""
        H, R, P = self.model.H, self.model.measurement_noise, self._covariance
        expected = H @ self._mean + self.model.c
        brought = make_innovation(measurement, expected, H @ P @ H.T + R, self.model.measurement_angles)
        K = compute_gain(P @ H.T, brought.covariance)
        evidence = brought.log_density
        self._store_belief(self._mean + K @ brought.difference, joseph_update(P, K, H, R))
        self.innovation = brought
        return evidence
