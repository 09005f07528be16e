"""Drawing where a robot may be after a move that its odometry reports: turn, advance, turn, each with noise.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), table 5.6, with one care of the practice: a move backward
is no half-turn, so that the noise of a first turn beyond 90 degrees is that of its supplement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]

# An advance below this, in metres, has no direction: the move is a turn on the spot.
_STILL = 1e-9


@dataclass(frozen=True)
class OdometryNoise:
    """Standard deviations: of a turn, radians a radian turned and radians a metre advanced; of an advance, metres a
    metre advanced and metres a radian turned. Raises InvalidArgumentError."""

    turn_by_turn: float = 0.1
    turn_by_advance: float = 0.05
    advance_by_advance: float = 0.1
    advance_by_turn: float = 0.02

    def __post_init__(self) -> None:
        for argument, value in vars(self).items():
            if not 0.0 <= value < np.inf:
                raise InvalidArgumentError(argument, f"{value} is not a standard deviation")

    def sigmas(self, first: float, advance: float, second: float) -> Floats:
        """The standard deviations (3,) of first turn, advance and second turn.

        sigma_turn^2    = (turn_by_turn turn)^2 + (turn_by_advance advance)^2
        sigma_advance^2 = (advance_by_advance advance)^2 + advance_by_turn^2 (first^2 + second^2)              (1)
        """
        before, after = (min(abs(turn), math.pi - abs(turn)) for turn in (first, second))
        return np.array(
            [
                math.hypot(self.turn_by_turn * before, self.turn_by_advance * advance),
                math.hypot(self.advance_by_advance * advance, self.advance_by_turn * math.hypot(before, after)),
                math.hypot(self.turn_by_turn * after, self.turn_by_advance * advance),
            ]
        )


def turn_advance_turn(T_before_after: ArrayLike) -> Floats:
    """A move (3,) as (first turn, advance, second turn); a turn on the spot is all in the second one.

    Raises InvalidArgumentError.
    """
    move = np.asarray(T_before_after, dtype=np.float64)
    if move.shape != (3,) or not all(map(math.isfinite, move.tolist())):
        raise InvalidArgumentError("T_before_after", f"of shape {move.shape} is not a pose (3,) of finite numbers")
    x, y, turn = move.tolist()
    advance = math.hypot(x, y)
    first = math.atan2(y, x) if advance > _STILL else 0.0
    return np.array([first, advance, wrap_angle(turn - first)])


def sample_odometry(
    poses: ArrayLike, T_before_after: ArrayLike, noise: OdometryNoise, rng: np.random.Generator
) -> Floats:
    """Poses (n, 3) after the move T_before_after (3,), each with noise of its own. Raises InvalidArgumentError."""
    before = np.asarray(poses, dtype=np.float64)
    if before.ndim != 2 or before.shape[1] != 3:
        raise InvalidArgumentError("poses", f"has shape {before.shape}, not (n, 3)")
    move = turn_advance_turn(T_before_after)
    sigmas = noise.sigmas(*move.tolist())
    drawn = rng.standard_normal((3, len(before)))
    drawn *= sigmas[:, None]
    drawn += move[:, None]
    first, advance, second = drawn
    after = np.empty_like(before)
    heading = np.add(before[:, 2], first, out=first)
    np.add(before[:, 0], advance * np.cos(heading), out=after[:, 0])
    np.add(before[:, 1], advance * np.sin(heading), out=after[:, 1])
    heading += second
    after[:, 2] = wrap_angle(heading)
    return after
