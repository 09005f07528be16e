"""Where a sequence of ICP poses is heading: Anderson's extrapolation of the last few.

ICP is the search for a fixed point of G, "pair, then fit". When it creeps, its steps F = G(T) - T shrink along much the
same path; the combination of the last poses whose steps best cancel out is a better guess of the end:

    T+ = G_k - sum_j g_j (G_j+1 - G_j),    g minimising |F_k - sum_j g_j (F_j+1 - F_j)|                     (1)

Nothing guarantees that T+ is lower: the caller must compare, and fall back on G_k, which is (Theorem 4).

Source: Pavlov, Ovchinnikov, Derbyshev, Tsetserukou, Oseledets, "AA-ICP: Iterative Closest Point with Anderson
Acceleration" (2018).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.se2 import Pose

Floats = NDArray[np.float64]

DEPTH = 2
RIDGE = 1e-12
TINY = float(np.finfo(np.float64).tiny)


class AndersonExtrapolation:
    """The last poses and steps of a sequence; turns are weighed by `spread`, the size of the cloud."""

    def __init__(self, spread: float) -> None:
        self._units = np.array([1.0, 1.0, spread])
        self._ends: list[Pose] = []
        self._steps: list[Floats] = []

    def __call__(self, T_from: Pose, T_to: Pose) -> Pose:
        """The pose (1), after a step of the sequence from one pose to the next; the latter while memory is short."""
        self._ends = [*self._ends[-DEPTH:], T_to]
        self._steps = [*self._steps[-DEPTH:], (T_to - T_from) * self._units]
        if len(self._ends) <= DEPTH:
            return T_to
        ends, steps = np.array(self._ends), np.array(self._steps)
        changes = steps[1:] - steps[:-1]
        gram = changes @ changes.T
        gram.flat[:: len(gram) + 1] += RIDGE * gram.trace() + TINY
        return np.asarray(T_to - np.linalg.solve(gram, changes @ steps[-1]) @ (ends[1:] - ends[:-1]))

    def forget_older_poses(self) -> None:
        """Start again from the last step: the poses before it led astray."""
        self._ends, self._steps = self._ends[-1:], self._steps[-1:]
