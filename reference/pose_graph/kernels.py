"""Robust kernels: what an edge of chi2 u counts for in the cost, rho(u), and in the normal equations, rho'(u).

Each leaves small residuals alone, rho(u) ~ u, and bounds the pull of large ones, so that a false loop closure cannot
bend the map. A minimum of sum rho(u) is a fixed point of weighted least squares with the weights rho'(u).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from reference.pose_graph.errors import ParameterError
from reference.pose_graph.graph import Floats


class Kernel(Protocol):
    """A cost rho of chi2 (m,), increasing and concave, and its derivative in ]0, 1]."""

    def rho(self, u: Floats) -> Floats: ...

    def weight(self, u: Floats) -> Floats: ...


@dataclass(frozen=True)
class Huber:
    """Squares up to a length `delta` of the whitened error, straight lines beyond: a convex kernel.

    rho = u if u <= delta^2, else 2 delta sqrt(u) - delta^2;  rho' = min(1, delta / sqrt(u))                 (12)
    """

    delta: float = 1.0

    def __post_init__(self) -> None:
        _check_positive("delta", self.delta)

    def rho(self, u: Floats) -> Floats:
        return np.where(u <= self.delta**2, u, 2.0 * self.delta * np.sqrt(u) - self.delta**2)

    def weight(self, u: Floats) -> Floats:
        return self.delta / np.sqrt(np.maximum(u, self.delta**2))


@dataclass(frozen=True)
class Switchable:
    """Switchable constraints: each edge has a switch s in [0, 1], pulled to 1 with the information `prior`.

    Given u the best switch is known, s = prior / (prior + u), so that no switch need be searched for:
    rho = min over s of s^2 u + prior (1 - s)^2 = prior u / (prior + u),  rho' = s^2                         (13)

    Source: Sünderhauf, Protzel, "Switchable Constraints for Robust Pose Graph SLAM" (IROS 2012).
    """

    prior: float = 1.0

    def __post_init__(self) -> None:
        _check_positive("prior", self.prior)

    def switch(self, u: Floats) -> Floats:
        """The best switches (m,)."""
        return self.prior / (self.prior + u)

    def rho(self, u: Floats) -> Floats:
        return self.switch(u) * u

    def weight(self, u: Floats) -> Floats:
        return self.switch(u) ** 2


@dataclass(frozen=True)
class DCS:
    """Dynamic covariance scaling: edges of chi2 up to `phi` count in full, others are scaled down.

    s = min(1, 2 phi / (phi + u)),  rho' = s^2,  rho = u if u <= phi, else phi (3u - phi) / (u + phi)        (14)

    Source: Agarwal, Tipaldi, Spinello, Stachniss, Burgard, "Robust Map Optimization using Dynamic Covariance Scaling"
    (ICRA 2013); rho is the integral of its weight.
    """

    phi: float = 1.0

    def __post_init__(self) -> None:
        _check_positive("phi", self.phi)

    def switch(self, u: Floats) -> Floats:
        """The scales s (m,)."""
        return np.minimum(1.0, 2.0 * self.phi / (self.phi + u))

    def rho(self, u: Floats) -> Floats:
        return np.where(u <= self.phi, u, self.phi * (3.0 * u - self.phi) / (u + self.phi))

    def weight(self, u: Floats) -> Floats:
        return self.switch(u) ** 2


def _check_positive(name: str, value: float) -> None:
    if not 0.0 < value < np.inf:
        raise ParameterError(name, f"{value} is not a positive number")
