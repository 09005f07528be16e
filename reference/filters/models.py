"""What a problem tells a filter: how states move and what they show, with Gaussian noise.

    x' = f(x, u, w), w ~ N(0, M(u))                                                                            (1)
    z  = h(x) + v,   v ~ N(0, R)                                                                               (2)

Arrays of states are (n, d), so that a thousand particles move in one call.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from reference.errors import InvalidArgumentError
from reference.filters.moments import Flags, subtract_vectors

Floats = NDArray[np.float64]


class GaussianModel(ABC):
    """A state of d components, k components of motion noise, a measurement of m components.

    `state_angles` (d,), `measurement_angles` (m,): which components are angles. `measurement_noise`: R (m, m).
    """

    state_angles: Flags
    measurement_angles: Flags
    measurement_noise: Floats

    @abstractmethod
    def move(self, states: Floats, control: Floats, noise: Floats) -> Floats:
        """f of (1): the states (n, d) after the control, for noises (n, k)."""

    @abstractmethod
    def motion_noise(self, control: Floats) -> Floats:
        """M of (1), (k, k)."""

    @abstractmethod
    def observe(self, states: Floats) -> Floats:
        """h of (2): what would be measured without noise from each state, (n, m)."""

    @abstractmethod
    def move_jacobians(self, state: Floats, control: Floats) -> tuple[Floats, Floats]:
        """The derivatives of f by x, (d, d), and by w, (d, k), at the state (d,) and w = 0."""

    @abstractmethod
    def observe_jacobian(self, state: Floats) -> Floats:
        """The derivative of h by x, (m, d), at the state (d,)."""

    def sample_motion(self, states: Floats, control: Floats, rng: np.random.Generator) -> Floats:
        """One draw from p(x' | x, u) for each state (n, d)."""
        noise = self.motion_noise(control)
        return self.move(states, control, rng.multivariate_normal(np.zeros(len(noise)), noise, size=len(states)))

    def transition(self, states: Floats, control: Floats, edges: Floats) -> Floats:
        """For states (n, 1) of a line: the probability (n, m) to land between edges (m + 1,) j and j + 1.

        Exact where f is affine in the noise.
        """
        noise = np.zeros((len(states), len(self.motion_noise(control))))
        landing = self.move(states, control, noise)
        spread = np.array(
            [self._motion_standard_deviation(state, control) for state in self._states_of_different_spread(states)]
        )
        return np.diff(ndtr((edges[None, :] - landing) / spread[:, None]), axis=1)

    def _states_of_different_spread(self, states: Floats) -> Floats:
        """The states whose spread of motion differs: all of them, unless a model knows better."""
        return states

    def _motion_standard_deviation(self, state: Floats, control: Floats) -> float:
        _, by_noise = self.move_jacobians(state, control)
        variance = float((by_noise @ self.motion_noise(control) @ by_noise.T).item())
        if variance <= 0.0:
            raise InvalidArgumentError("control", "moves without noise: a histogram cannot follow it")
        return float(np.sqrt(variance))

    def log_likelihood(self, states: Floats, measurement: Floats) -> Floats:
        """log p(z | x), (n,), for each state (n, d)."""
        residuals = subtract_vectors(measurement, self.observe(states), self.measurement_angles)
        return log_normal(residuals, self.measurement_noise)


class LinearGaussian(GaussianModel):
    """x' = F x + B u + w, z = H x + c + v, with w ~ N(0, Q) and v ~ N(0, R); no component is an angle.

    F (d, d), B (d, p), Q (d, d), H (m, d), R (m, m), c (m,). Raises InvalidArgumentError for shapes that do not fit.
    """

    def __init__(
        self, F: ArrayLike, B: ArrayLike, Q: ArrayLike, H: ArrayLike, R: ArrayLike, c: ArrayLike | None = None
    ) -> None:
        self.F, self.B, self.Q, self.H = (np.atleast_2d(np.asarray(a, dtype=np.float64)) for a in (F, B, Q, H))
        self.measurement_noise = np.atleast_2d(np.asarray(R, dtype=np.float64))
        d, m = self.F.shape[0], self.H.shape[0]
        self.c = np.zeros(m) if c is None else np.asarray(c, dtype=np.float64)
        self.state_angles, self.measurement_angles = np.zeros(d, dtype=np.bool_), np.zeros(m, dtype=np.bool_)
        shapes = {
            "F": (self.F, (d, d)),
            "B": (self.B, (d, self.B.shape[1])),
            "Q": (self.Q, (d, d)),
            "H": (self.H, (m, d)),
            "R": (self.measurement_noise, (m, m)),
            "c": (self.c, (m,)),
        }
        for argument, (values, shape) in shapes.items():
            if values.shape != shape or not np.all(np.isfinite(values)):
                raise InvalidArgumentError(argument, f"has shape {values.shape}, not {shape}, or is not finite")

    def move(self, states: Floats, control: Floats, noise: Floats) -> Floats:
        return np.asarray(states @ self.F.T + control @ self.B.T + noise)

    def motion_noise(self, control: Floats) -> Floats:
        return self.Q

    def observe(self, states: Floats) -> Floats:
        return np.asarray(states @ self.H.T + self.c)

    def move_jacobians(self, state: Floats, control: Floats) -> tuple[Floats, Floats]:
        return self.F, np.eye(len(self.F))

    def observe_jacobian(self, state: Floats) -> Floats:
        return self.H

    def _states_of_different_spread(self, states: Floats) -> Floats:
        return states[:1]


def log_normal(residuals: Floats, covariance: Floats) -> Floats:
    """log N(r; 0, covariance), (…,), of residuals (…, m). Raises InvalidArgumentError for a singular covariance."""
    try:
        factor = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise InvalidArgumentError("covariance", "is not positive definite: there is no density") from None
    white = np.linalg.solve(factor, np.moveaxis(residuals, -1, 0).reshape(len(factor), -1))
    squares = np.sum(white**2, axis=0).reshape(residuals.shape[:-1])
    volume = 2.0 * np.sum(np.log(np.diag(factor))) + len(factor) * np.log(2.0 * np.pi)
    return np.asarray(-0.5 * (squares + volume))
