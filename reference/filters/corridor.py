"""The common problem: a robot in a corridor, on which every incarnation of the Bayes filter can be tried.

The state is the position x in metres along the corridor, the control a displacement. With a range finder that looks at
the end wall the problem is linear and Gaussian: Kalman is exact, and histogram and particles must converge to it. With
a detector of doors the belief has one bump for each door, which only histogram and particles can hold.

Source of the second problem: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), figure 1.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.filters.models import LinearGaussian
from reference.filters.moments import Flags

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Corridor:
    """A corridor from 0 to `length`, in metres, with doors of `door_width` centred at `doors`.

    `motion_sigma`, `range_sigma`: standard deviations of a move and of a range, in metres. `p_right`: how often the
    detector of doors is right. Raises InvalidArgumentError.
    """

    length: float = 20.0
    doors: tuple[float, ...] = (3.0, 7.0, 15.0)
    door_width: float = 1.0
    motion_sigma: float = 0.2
    range_sigma: float = 0.5
    p_right: float = 0.95

    def __post_init__(self) -> None:
        for argument in ("length", "door_width", "motion_sigma", "range_sigma"):
            if not 0.0 < getattr(self, argument) < np.inf:
                raise InvalidArgumentError(argument, "is not a positive length")
        if not 0.0 < self.p_right < 1.0:
            raise InvalidArgumentError("p_right", f"{self.p_right} is not a probability between 0 and 1")

    def range_model(self) -> LinearGaussian:
        """x' = x + u + w, z = length - x + v; controls and measurements are arrays (1,)."""
        return LinearGaussian(
            F=[[1.0]],
            B=[[1.0]],
            Q=[[self.motion_sigma**2]],
            H=[[-1.0]],
            c=[self.length],
            R=[[self.range_sigma**2]],
        )

    def door_model(self) -> DoorModel:
        """The same motion; a measurement is True when the detector sees a door."""
        return DoorModel(self)

    def are_at_door(self, positions: Floats) -> NDArray[np.bool_]:
        """Which positions (n,) lie in front of a door."""
        away = np.abs(positions[:, None] - np.array(self.doors)[None, :])
        return np.asarray(np.any(away <= 0.5 * self.door_width, axis=1))


class DoorModel:
    """p(z | x) = p_right where the detector should say z, 1 - p_right elsewhere."""

    def __init__(self, corridor: Corridor) -> None:
        self.corridor, self.motion = corridor, corridor.range_model()
        self.state_angles: Flags = self.motion.state_angles

    def sample_motion(self, states: Floats, control: Floats, rng: np.random.Generator) -> Floats:
        return self.motion.sample_motion(states, control, rng)

    def transition(self, states: Floats, control: Floats, edges: Floats) -> Floats:
        return self.motion.transition(states, control, edges)

    def log_likelihood(self, states: Floats, measurement: bool) -> Floats:
        right = self.corridor.are_at_door(states[:, 0]) == measurement
        return np.log(np.where(right, self.corridor.p_right, 1.0 - self.corridor.p_right))
