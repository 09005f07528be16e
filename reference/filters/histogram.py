"""The histogram filter: a belief over the cells of a line, exact in the limit of small cells.

In two dimensions, with walls, see `reference.localisation.grid_filter`. Source: Thrun, Burgard, Fox, "Probabilistic
Robotics" (2005), table 4.1.
"""

from __future__ import annotations

from typing import Generic, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.filters.bayes import Measurement_contra, reweight
from reference.filters.gaussian import check_vector

Floats = NDArray[np.float64]


class OneDimensionalModel(Protocol[Measurement_contra]):
    """A problem on a line, as a histogram needs it: GaussianModel says what both functions mean."""

    def transition(self, states: Floats, control: Floats, edges: Floats, /) -> Floats: ...

    def log_likelihood(self, states: Floats, measurement: Measurement_contra, /) -> Floats: ...


class HistogramFilter(Generic[Measurement_contra]):
    """A BayesFilter over the cells between `edges` (m + 1,), increasing; its belief is uniform unless given, (m,).

    The first and the last cell also hold what lies beyond them: no probability is lost. Raises InvalidArgumentError.
    """

    def __init__(
        self, model: OneDimensionalModel[Measurement_contra], edges: ArrayLike, belief: ArrayLike | None = None
    ) -> None:
        lines = check_vector("edges", edges)
        if lines.size < 2 or not np.all(np.diff(lines) > 0.0):
            raise InvalidArgumentError("edges", "are not at least two increasing numbers")
        self.model, self.edges = model, lines
        self.centres = 0.5 * (lines[:-1] + lines[1:])
        self.belief = np.diff(lines) / (lines[-1] - lines[0]) if belief is None else self._check_and_normalise(belief)

    @property
    def mean(self) -> Floats:
        return np.array([self.belief @ self.centres])

    @property
    def covariance(self) -> Floats:
        return np.array([[self.belief @ (self.centres - self.mean) ** 2]])

    def predict(self, control: ArrayLike) -> None:
        """bel-(j) = sum over i of p(cell j | centre of i, u) bel(i)."""
        outer = self.edges.copy()
        outer[0], outer[-1] = -np.inf, np.inf
        u = check_vector("control", control)
        self.belief = self.belief @ self.model.transition(self.centres[:, None], u, outer)

    def correct(self, measurement: Measurement_contra) -> float:
        """bel(j) = p(z | centre of j) bel-(j) / evidence. Raises ImpossibleMeasurementError."""
        posterior = reweight(self.belief, self.model.log_likelihood(self.centres[:, None], measurement))
        self.belief = posterior.weights
        return posterior.log_sum

    def _check_and_normalise(self, belief: ArrayLike) -> Floats:
        masses = check_vector("belief", belief, self.centres.size)
        if masses.min() < 0.0 or masses.sum() <= 0.0:
            raise InvalidArgumentError("belief", "is negative somewhere, or zero everywhere")
        return np.asarray(masses / masses.sum())
