"""The particle filter: a belief as weighted samples, for any model that can be drawn from and evaluated.

Sources: Gordon, Salmond, Smith, "Novel Approach to Nonlinear/Non-Gaussian Bayesian State Estimation" (1993);
Doucet, Godsill, Andrieu, "On Sequential Monte Carlo Sampling Methods" (2000) for resampling when N_eff is low.
"""

from __future__ import annotations

from typing import Generic, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.filters.bayes import Measurement_contra, reweight
from reference.filters.gaussian import check_vector
from reference.filters.moments import Flags, weighted_covariance, weighted_mean
from reference.filters.resampling import Scheme, effective_sample_size, systematic_resampling

Floats = NDArray[np.float64]


class SampledModel(Protocol[Measurement_contra]):
    """A problem as particles need it: GaussianModel says what each member means."""

    state_angles: Flags

    def sample_motion(self, states: Floats, control: Floats, rng: np.random.Generator, /) -> Floats: ...

    def log_likelihood(self, states: Floats, measurement: Measurement_contra, /) -> Floats: ...


class ParticleFilter(Generic[Measurement_contra]):
    """A BayesFilter over `states` (n, d) with weights (n,), equal at the start.

    After a correction that leaves N_eff < `threshold` n, particles are drawn again by `scheme`: 0 never draws, 1 always
    does. Raises InvalidArgumentError.
    """

    def __init__(
        self,
        model: SampledModel[Measurement_contra],
        states: ArrayLike,
        rng: np.random.Generator,
        *,
        threshold: float = 0.5,
        scheme: Scheme = systematic_resampling,
    ) -> None:
        start = np.array(states, dtype=np.float64)
        d = model.state_angles.size
        if start.ndim != 2 or start.shape[1] != d or len(start) == 0 or not np.all(np.isfinite(start)):
            raise InvalidArgumentError("states", f"of shape {start.shape} is not an array (n, {d}) of finite numbers")
        if not 0.0 <= threshold <= 1.0:
            raise InvalidArgumentError("threshold", f"{threshold} is not a share of the particles")
        self.model, self.states, self.rng, self.threshold, self.scheme = model, start, rng, threshold, scheme
        self.weights = np.full(len(start), 1.0 / len(start))

    @property
    def mean(self) -> Floats:
        return weighted_mean(self.states, self.weights, self.model.state_angles)

    @property
    def covariance(self) -> Floats:
        return weighted_covariance(self.states, self.weights, self.mean, self.model.state_angles)

    @property
    def effective_sample_size(self) -> float:
        """N_eff, between 1 and n."""
        return effective_sample_size(self.weights)

    def predict(self, control: ArrayLike) -> None:
        """Draw each particle's next state from p(x' | x, u)."""
        self.states = self.model.sample_motion(self.states, check_vector("control", control), self.rng)

    @property
    def is_degenerate(self) -> bool:
        """Is N_eff below the threshold?"""
        return self.effective_sample_size < self.threshold * len(self.states)

    def correct(self, measurement: Measurement_contra) -> float:
        """Weigh, then resample if need be. Raises ImpossibleMeasurementError."""
        evidence = self.weigh(measurement)
        if self.is_degenerate:
            self.resample()
        return evidence

    def weigh(self, measurement: Measurement_contra) -> float:
        """w_i <- p(z | x_i) w_i / evidence; returns the log evidence. Raises ImpossibleMeasurementError."""
        posterior = reweight(self.weights, self.model.log_likelihood(self.states, measurement))
        self.weights = posterior.weights
        return posterior.log_sum

    def resample(self) -> None:
        """Draw as many particles as there are, each in proportion to its weight; weights are equal afterwards."""
        self.states = self.states.take(self.scheme(self.weights, self.rng, None).ancestors, axis=0)
        self.weights = np.full(len(self.states), 1.0 / len(self.states))
