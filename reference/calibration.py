"""Calibration of odometry: the constants of a robot from its own journeys, by least squares, and by UMBmark's squares.

A robot errs in two ways. Its constants are wrong: each wheel's size, and the distance between the wheels. These errors
come back in every step, add up in proportion to the way, and can be removed. Slip is drawn anew in each step and can
only be allowed for. What is fitted here are three constants, from steps whose motion is also known from elsewhere:
a tape on the floor, or scans matched one on the other.

Sources: Censi, Marchionni, Oriolo, "Simultaneous Maximum-Likelihood Calibration of Odometry and Sensor Parameters"
(2008) and "Simultaneous Calibration of Odometry and Sensor Parameters for Mobile Robots" (2013), section V: headings
are linear in two constants, then the way is linear in the third; Borenstein, Feng, "Measurement and Correction of
Systematic Odometry Errors in Mobile Robots" (1996), for the squares driven both ways round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.odometry import DifferentialDrive
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]

# Columns less independent than this make a constant a matter of rounding.
LEAST_PIVOT = 1e-9


class CalibrationError(InvalidArgumentError):
    """Journeys that do not determine the constants; `argument` names what is at fault."""


@dataclass(frozen=True)
class WheelCalibration:
    """What one unit of each encoder is worth, `left_scale` and `right_scale` in metres, and the `track` in metres.

    `heading_residual` (rad) and `distance_residual` (m): root mean squares of what the constants leave of a step.
    """

    left_scale: float
    right_scale: float
    track: float
    heading_residual: float
    distance_residual: float

    @property
    def to_drive(self) -> DifferentialDrive:
        return DifferentialDrive(self.track)

    def wheel_paths(self, wheels: ArrayLike) -> Floats:
        """The paths (n, 2) of the wheels in metres, from what the encoders count."""
        return _check_rows("wheels", wheels, 2) * [self.left_scale, self.right_scale]


def calibrate_wheels(wheels: ArrayLike, steps: ArrayLike) -> WheelCalibration:
    """The three constants of a robot from counts `wheels` (n, 2) = (left, right), and the motions `steps` (n, 3) made.

    With s_l, s_r the scales and b the track, the turn and the way of a step are, for counts l and r,

        dtheta = c_l l + c_r r,   c_l = -s_l / b,  c_r = s_r / b                                                (1)
        ds = b (-c_l l + c_r r) / 2,  along the chord that halves the turn                                      (2)

    (1) gives c_l and c_r, and (2) then b, each by linear least squares: no first guess, no iteration. A turn is read
    modulo 2 pi, so steps must turn by less than half. Raises CalibrationError where the robot only drove straight, or
    only turned on the spot, or a wheel stood still.
    """
    counts, motions = _check_measurements_and_steps("wheels", wheels, 2, steps)
    turns = wrap_angle(motions[:, 2])
    c_left, c_right = _solve_least_squares("wheels", counts, turns)
    if not c_left < 0.0 < c_right:
        raise CalibrationError("wheels", "turn the robot the wrong way: left and right may be exchanged")
    ways = _signed_chord_lengths(motions, turns)
    half = (counts @ [-c_left, c_right]) / 2.0
    track = float(_solve_least_squares("wheels", half[:, None], ways)[0])
    if not track > 0.0:
        raise CalibrationError("steps", "go backwards where the wheels go ahead")
    left_turn, left_way = turns - counts @ [c_left, c_right], ways - track * half
    return WheelCalibration(
        -c_left * track, c_right * track, track, _root_mean_square(wrap_angle(left_turn)), _root_mean_square(left_way)
    )


@dataclass(frozen=True)
class StepCalibration:
    """Corrections of odometry that comes as poses: its ways are to be multiplied by `stretch`, its turns by `turn`.

    `pull` (rad/m) is what the robot turns for each metre while it believes that it drives straight: unequal wheels.
    `heading_residual` (rad) and `distance_residual` (m): root mean squares of what is left of a step.
    """

    stretch: float
    turn: float
    pull: float
    heading_residual: float
    distance_residual: float

    def correct(self, odometry_steps: ArrayLike) -> Floats:
        """The steps (n, 3) as they should have been. A step turns evenly: its chord turns by half of what is added."""
        steps = _check_rows("odometry_steps", odometry_steps, 3)
        turns = wrap_angle(steps[:, 2])
        corrected = self.turn * turns + self.pull * _signed_chord_lengths(steps, turns)
        half = (corrected - turns) / 2.0
        c, s = np.cos(half), np.sin(half)
        x, y = self.stretch * steps[:, 0], self.stretch * steps[:, 1]
        return np.column_stack([c * x - s * y, s * x + c * y, wrap_angle(corrected)])


def calibrate_steps(odometry_steps: ArrayLike, steps: ArrayLike, *, worst_share: float = 0.0) -> StepCalibration:
    """The three constants of `StepCalibration` from steps (n, 3) by odometry and the motions (n, 3) really made.

        dtheta = turn dtheta_o + pull ds_o,   ds = stretch ds_o                                                 (3)

    This is (1) and (2) for a robot whose odometry was computed with a nominal track and equal wheels. `worst_share`:
    that of the steps, the worst in heading, that are left out before a second fit, for motions that come from matches
    of scans, some of which are wrong (Censi et al., section V.E). Raises CalibrationError.
    """
    if not 0.0 <= worst_share < 1.0:
        raise CalibrationError("worst_share", f"{worst_share} is not a share of the steps")
    measured, motions = _check_measurements_and_steps("odometry_steps", odometry_steps, 3, steps)
    found = _fit_step_corrections(measured, motions)
    if worst_share == 0.0:
        return found
    missed = np.abs(wrap_angle(found.correct(measured)[:, 2] - motions[:, 2]))
    kept = np.sort(np.argsort(missed, kind="stable")[: max(3, round((1.0 - worst_share) * len(missed)))])
    return _fit_step_corrections(measured[kept], motions[kept])


def _fit_step_corrections(measured: Floats, motions: Floats) -> StepCalibration:
    turns, true_turns = wrap_angle(measured[:, 2]), wrap_angle(motions[:, 2])
    ways, true_ways = _signed_chord_lengths(measured, turns), _signed_chord_lengths(motions, true_turns)
    turn, pull = _solve_least_squares("odometry_steps", np.column_stack([turns, ways]), true_turns)
    stretch = float(_solve_least_squares("odometry_steps", ways[:, None], true_ways)[0])
    left = true_turns - turn * turns - pull * ways
    return StepCalibration(
        stretch, turn, pull, _root_mean_square(wrap_angle(left)), _root_mean_square(true_ways - stretch * ways)
    )


@dataclass(frozen=True)
class Umbmark:
    """What the squares say. Lengths in metres.

    `wheel_ratio`: diameter of the right wheel over that of the left; `track_ratio`: the real track over the one that
    odometry believed in. Paths of the wheels are to be multiplied by `left_factor` and `right_factor`, of mean one, and
    the track by `track_ratio`. `worst`: the systematic error of this robot, the farther of the two mean ends.
    """

    wheel_ratio: float
    track_ratio: float
    left_factor: float
    right_factor: float
    worst: float


def umbmark(clockwise: ArrayLike, counterclockwise: ArrayLike, side: float, track: float) -> Umbmark:
    """Constants from squares of `side` metres, driven by odometry, the robot setting out along x.

    `clockwise` and `counterclockwise`, (n, 2) and (m, 2): where the robot really stood at the end, less where its
    odometry believed it, run by run; `track`: the one that odometry used. With the mean abscissas x_cw and x_ccw,

        alpha = -(x_cw + x_ccw) / (4 L)   the turn missed in each corner                                        (4)
        beta  = -(x_cw - x_ccw) / (4 L)   the turn made along each side                                         (5)
        R = (L / 2) / sin(beta / 2),  E_d = (R + b / 2) / (R - b / 2),  E_b = (pi / 2) / (pi / 2 - alpha)       (6)

    All is of first order in the errors. Raises CalibrationError.
    """
    if not (0.0 < track < np.inf and 0.0 < side < np.inf):
        raise CalibrationError("track" if 0.0 < side < np.inf else "side", "is not a positive length")
    ends = [
        _check_rows(name, value, 2)
        for name, value in (("clockwise", clockwise), ("counterclockwise", counterclockwise))
    ]
    cw, ccw = ends[0].mean(axis=0), ends[1].mean(axis=0)
    alpha, beta = -(cw[0] + ccw[0]) / (4.0 * side), -(cw[0] - ccw[0]) / (4.0 * side)
    if max(abs(alpha), abs(beta)) > np.pi / 4.0:
        raise CalibrationError("clockwise", "ends so far away that the robot drove no square")
    bend = 2.0 * np.sin(beta / 2.0) / side  # the curvature 1 / R of a side, 0 where it is straight
    wheel_ratio = float((1.0 + bend * track / 2.0) / (1.0 - bend * track / 2.0))
    track_ratio = float((np.pi / 2.0) / (np.pi / 2.0 - alpha))
    left, right = 2.0 / (wheel_ratio + 1.0), 2.0 / (1.0 / wheel_ratio + 1.0)
    return Umbmark(wheel_ratio, track_ratio, left, right, float(max(np.hypot(*cw), np.hypot(*ccw))))


def _signed_chord_lengths(steps: Floats, turns: Floats) -> Floats:
    """The way (n,) of each step along the chord that halves its turn, ahead or back."""
    return np.asarray(steps[:, 0] * np.cos(turns / 2.0) + steps[:, 1] * np.sin(turns / 2.0))


def _solve_least_squares(argument: str, A: Floats, right: Floats) -> Floats:
    """The least squares solution, of columns that must be independent."""
    size = np.linalg.norm(A, axis=0)
    if not np.all(size > 0.0) or np.linalg.svd(A / size, compute_uv=False)[-1] < LEAST_PIVOT:
        raise CalibrationError(argument, "do not tell the constants apart: the journey must have ways and turns")
    return np.asarray(np.linalg.lstsq(A, right, rcond=None)[0])


def _root_mean_square(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _check_measurements_and_steps(
    argument: str, first: ArrayLike, width: int, steps: ArrayLike
) -> tuple[Floats, Floats]:
    rows, motions = _check_rows(argument, first, width), _check_rows("steps", steps, 3)
    if len(rows) != len(motions):
        raise CalibrationError("steps", f"are {len(motions)}, for {len(rows)} rows of {argument}")
    if len(rows) < 3:
        raise CalibrationError(argument, f"{len(rows)} steps do not determine three constants")
    return rows, motions


def _check_rows(argument: str, values: ArrayLike, width: int) -> Floats:
    rows = np.asarray(values, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != width or not len(rows) or not np.all(np.isfinite(rows)):
        raise CalibrationError(argument, f"of shape {rows.shape} are not finite numbers (n, {width}), n >= 1")
    return rows
