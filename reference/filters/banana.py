"""One advance in a direction that is doubted, then one measurement: what is believed exactly, by quadrature.

A robot at the origin advances by r ~ N(advance, advance_sigma^2) in the direction phi ~ N(0, heading_sigma^2), without
turning: its pose is (r cos phi, r sin phi, phi), and fills a crescent. On it, approximate filters are compared.

    p(r, phi | z) = p(z | r, phi) p(r) p(phi) / p(z)                                                           (1)

Sums over equally spaced nodes far into both tails: for such smooth laws, their error falls faster than any power of the
spacing. Source: Trefethen, Weideman, "The Exponentially Convergent Trapezoidal Rule" (2014).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from reference.errors import InvalidArgumentError
from reference.filters.log_weights import normalise_log_weights
from reference.filters.models import GaussianModel
from reference.filters.moments import weighted_covariance

Floats = NDArray[np.float64]

# How many standard deviations the nodes go, and how many of them there are along r and phi.
FAR, ALONG, ACROSS = 6.0, 81, 601
PLANE = np.zeros(2, dtype=np.bool_)


@dataclass(frozen=True)
class Banana:
    """Lengths in metres, angles in radians; all positive, and the origin out of reach. Raises InvalidArgumentError."""

    advance: float
    advance_sigma: float
    heading_sigma: float

    def __post_init__(self) -> None:
        for argument in ("advance", "advance_sigma", "heading_sigma"):
            if not 0.0 < getattr(self, argument) < np.inf:
                raise InvalidArgumentError(argument, f"{getattr(self, argument)} is not a positive number")
        if self.advance <= FAR * self.advance_sigma:
            raise InvalidArgumentError("advance_sigma", "may bring the robot back to where it came from")

    def sample(self, count: int, rng: np.random.Generator) -> Floats:
        """Poses (count, 3) drawn from what is believed before the measurement."""
        r = rng.normal(self.advance, self.advance_sigma, count)
        return self._polar_to_poses(r, rng.normal(0.0, self.heading_sigma, count))

    def belief(self, model: GaussianModel | None = None, measurement: Floats | None = None) -> BananaBelief:
        """What is believed after a measurement of the model, (1); without one, before it.

        Raises InvalidArgumentError.
        """
        offsets = np.linspace(-FAR, FAR, ALONG), np.linspace(-FAR, FAR, ACROSS)
        along, across = np.meshgrid(*offsets, indexing="ij")
        poses = self._polar_to_poses(
            self.advance + self.advance_sigma * along.ravel(), self.heading_sigma * across.ravel()
        )
        logs = -0.5 * (along.ravel() ** 2 + across.ravel() ** 2)
        if model is not None and measurement is not None:
            logs = logs + model.log_likelihood(poses, measurement)
        return BananaBelief(poses, normalise_log_weights(logs).weights)

    def density(self, places: Floats) -> Floats:
        """Of the places (n, 2) of the plane before the measurement, per square metre; headings within half a turn."""
        r, phi = np.hypot(*places.T), np.arctan2(places[:, 1], places[:, 0])
        along = norm.pdf(r, self.advance, self.advance_sigma)
        return np.asarray(along * norm.pdf(phi, 0.0, self.heading_sigma) / np.maximum(r, 1e-9))

    @staticmethod
    def _polar_to_poses(r: Floats, phi: Floats) -> Floats:
        return np.column_stack([r * np.cos(phi), r * np.sin(phi), phi])


@dataclass(frozen=True, eq=False)
class BananaBelief:
    """Poses (n, 3) and their weights (n,), of sum one: exact but for the spacing of the nodes."""

    poses: Floats
    weights: Floats

    @property
    def mean(self) -> Floats:
        """Of the places, (2,)."""
        return np.asarray(self.weights @ self.poses[:, :2])

    @property
    def covariance(self) -> Floats:
        """Of the places, (2, 2)."""
        return weighted_covariance(self.poses[:, :2], self.weights, self.mean, PLANE)
