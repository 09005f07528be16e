"""A robot of the plane that measures range and bearing to known landmarks: nonlinear, with angles on both sides.

A state is a pose (3,) = (x, y, theta), a control (2,) = (advance in metres, turn in radians), a measurement
(2 l,) = (range_0, bearing_0, range_1, …), bearings in radians from the heading.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), tables 7.2 and 7.3; the motion is that of the course's
differential odometry, with the heading taken half-way through the turn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.filters.models import GaussianModel
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]


class RangeBearingModel(GaussianModel):
    """`landmarks` (l, 2) in the world, l >= 1; standard deviations of an advance, a turn, a range and a bearing.

    Raises InvalidArgumentError.
    """

    def __init__(
        self, landmarks: ArrayLike, *, advance_sigma: float, turn_sigma: float, range_sigma: float, bearing_sigma: float
    ) -> None:
        self.landmarks = np.array(landmarks, dtype=np.float64)
        if self.landmarks.ndim != 2 or self.landmarks.shape[1] != 2 or len(self.landmarks) == 0:
            raise InvalidArgumentError("landmarks", f"have shape {self.landmarks.shape}, not (l, 2) with l >= 1")
        for argument, sigma in (("range_sigma", range_sigma), ("bearing_sigma", bearing_sigma)):
            if not 0.0 < sigma < np.inf:
                raise InvalidArgumentError(argument, f"{sigma} is not a positive standard deviation")
        count = len(self.landmarks)
        self._M = np.diag([advance_sigma**2, turn_sigma**2])
        self.state_angles = np.array([False, False, True])
        self.measurement_angles = np.tile([False, True], count)
        self.measurement_noise = np.diag(np.tile([range_sigma**2, bearing_sigma**2], count))

    def motion_noise(self, control: Floats) -> Floats:
        return self._M

    def move(self, states: Floats, control: Floats, noise: Floats) -> Floats:
        """(x, y, t) -> (x + s cos(t + r / 2), y + s sin(t + r / 2), t + r), s and r the noisy advance and turn. (1)"""
        advance, turn = control[0] + noise[:, 0], control[1] + noise[:, 1]
        middle = states[:, 2] + 0.5 * turn
        return np.column_stack(
            [
                states[:, 0] + advance * np.cos(middle),
                states[:, 1] + advance * np.sin(middle),
                wrap_angle(states[:, 2] + turn),
            ]
        )

    def observe(self, states: Floats) -> Floats:
        """The range sqrt(dx^2 + dy^2) and the bearing atan2(dy, dx) - t of each landmark.                     (2)"""
        dx = self.landmarks[:, 0] - states[:, :1]
        dy = self.landmarks[:, 1] - states[:, 1:2]
        bearings = wrap_angle(np.arctan2(dy, dx) - states[:, 2:])
        return np.stack([np.hypot(dx, dy), bearings], axis=2).reshape(len(states), -1)

    def move_jacobians(self, state: Floats, control: Floats) -> tuple[Floats, Floats]:
        advance, turn = control
        middle = state[2] + 0.5 * turn
        c, s = np.cos(middle), np.sin(middle)
        by_state = np.array([[1.0, 0.0, -advance * s], [0.0, 1.0, advance * c], [0.0, 0.0, 1.0]])
        by_noise = np.array([[c, -0.5 * advance * s], [s, 0.5 * advance * c], [0.0, 1.0]])
        return by_state, by_noise

    def observe_jacobian(self, state: Floats) -> Floats:
        """Of (2). Raises InvalidArgumentError on a landmark, where the bearing is no function."""
        dx, dy = self.landmarks[:, 0] - state[0], self.landmarks[:, 1] - state[1]
        squares = dx**2 + dy**2
        if not squares.min() > 0.0:
            raise InvalidArgumentError("state", "stands on a landmark: its bearing has no derivative")
        ranges, none = np.sqrt(squares), np.zeros_like(dx)
        of_ranges = np.column_stack([-dx / ranges, -dy / ranges, none])
        of_bearings = np.column_stack([dy / squares, -dx / squares, none - 1.0])
        return np.stack([of_ranges, of_bearings], axis=1).reshape(-1, 3)


class RangeModel(RangeBearingModel):
    """The same robot, which measures ranges alone: a measurement is (l,)."""

    def __init__(self, landmarks: ArrayLike, *, advance_sigma: float, turn_sigma: float, range_sigma: float) -> None:
        super().__init__(
            landmarks, advance_sigma=advance_sigma, turn_sigma=turn_sigma, range_sigma=range_sigma, bearing_sigma=1.0
        )
        count = len(self.landmarks)
        self.measurement_angles = np.zeros(count, dtype=np.bool_)
        self.measurement_noise = range_sigma**2 * np.eye(count)

    def observe(self, states: Floats) -> Floats:
        return super().observe(states)[:, ::2]

    def observe_jacobian(self, state: Floats) -> Floats:
        return super().observe_jacobian(state)[::2]
