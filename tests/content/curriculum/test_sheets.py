"""The numbers that the course sheets state are those that `reference/` computes, written as the sheets write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import server
from reference import se2
from reference.filters.resampling import comb_resampling, effective_sample_size
from reference.metrics import absolute_trajectory_error
from reference.occupancy import log_odds, probability_of_log_odds
from reference.odometry import DifferentialDrive, LateralDrift
from reference.registration.icp import icp
from reference.registration.rigid import kabsch

SHEETS = Path(server.__file__).parents[1] / "curriculum" / "l20" / "fiches"


def states(sheet: str, value: float, digits: int) -> bool:
    """Does a sheet hold this number, with a decimal comma as TeX writes it?"""
    return f"{value:.{digits}f}".replace(".", "{,}") in (SHEETS / f"{sheet}.md").read_text(encoding="utf-8")


def test_a_number_that_is_not_there_is_not_found() -> None:
    assert not states("formules", 0.123456, 6)


def test_odometry_and_its_drift() -> None:
    drive = DifferentialDrive(track=0.3, sigma=1e-3)
    x, y, theta = drive.step((1, 2, 0), 0.10, 0.13)
    drift = LateralDrift(1000, 115.0, drive.turn_deviation(0.10, 0.13))
    for sheet in ("formules", "exercices-corriges"):
        assert states(sheet, x, 4)
        assert states(sheet, y, 4)
        assert states(sheet, theta, 1)
    assert states("exercices-corriges", drift.turn_deviation * 1000, 2)
    assert states("exercices-corriges", drift.heading_deviation, 3)
    assert states("exercices-corriges", float(np.degrees(drift.heading_deviation)), 1)
    assert states("exercices-corriges", drift.constant_error_deviation, 1)
    assert states("exercices-corriges", drift.lateral_deviation, 3)
    turned_first = 0.115 * drift.turn_deviation * np.sqrt(1000 * 1001 * 2001 / 6)
    assert states("exercices-corriges", float(turned_first), 3)


def test_composition() -> None:
    for value in se2.compose((1, 2, np.pi / 6), (2, 1, np.pi / 4)):
        assert states("formules", float(value), 3)


def test_log_odds() -> None:
    touch = float(log_odds(0.7))
    assert states("exercices-corriges", touch, 4)
    assert states("exercices-corriges", float(probability_of_log_odds(2 * touch)), 4)
    for count in (5, 6):
        assert states("exercices-corriges", float(probability_of_log_odds(count * touch)), 4)
    assert states("exercices-corriges", float(probability_of_log_odds(5.0)), 4)
    assert states("exercices-corriges", 5.0 / touch, 2)
    assert states("theoremes", float(probability_of_log_odds(4 * log_odds(0.2))), 4)


@pytest.mark.parametrize("range_read", [5.0, 2.0])
def test_the_beam_formula_of_the_course_which_truncates_nothing(range_read: float) -> None:
    expected, sigma, farthest, rate = 5.0, 0.2, 10.0, 0.5
    hit = np.exp(-0.5 * ((range_read - expected) / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    density = 0.7 * hit + 0.1 * rate * np.exp(-rate * range_read) + 0.1 / farthest
    assert states("formules", float(density), 3)


def test_resampling() -> None:
    weights = np.array([0.05, 0.40, 0.10, 0.30, 0.15])
    assert states("exercices-corriges", effective_sample_size(weights), 2)
    assert states("formules", effective_sample_size([0.7, 0.1, 0.1, 0.1]), 2)
    assert comb_resampling(weights, 0.12 * 5).ancestors.tolist() == [1, 1, 2, 3, 4]


def test_kabsch_by_hand() -> None:
    best = kabsch([(0, 0), (1, 0), (0, 1)], [(1, 1), (1, 2), (0, 1)])
    assert np.allclose(best.R_q_p, [[0, -1], [1, 0]])
    assert np.allclose(best.t_q_p, [1, 1])
    assert np.allclose(best.singular_values, [1, 1 / 3])
    assert best.unique


def test_a_mirrored_square_leaves_every_rotation_as_good() -> None:
    square = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    best = kabsch(square, square * [1, -1])
    assert not best.unique
    assert best.residual == pytest.approx(8.0)


def test_the_fence_stops_one_post_away() -> None:
    fence = np.column_stack([np.arange(10.0), np.zeros(10)])
    result = icp(fence + np.array([0.6, 0.0]), fence)
    assert result.errors[0] == pytest.approx(1.8)
    assert result.errors[-1] == pytest.approx(0.9)
    assert result.T_q_p == pytest.approx([0.3, 0.0, 0.0], abs=1e-9)


def test_a_tie_holds_icp_off_a_perfect_fit() -> None:
    gap = 0.4
    moving = np.array([(0.0, 0.0), (2.0, 0.0)])
    still = np.array([(gap, 0.0), (2.0 - gap, 0.0), (2.0 + gap, 0.0)])
    assert kabsch(moving, still[:2]).residual == pytest.approx(2 * gap**2)
    assert np.allclose(kabsch(moving, still[:2]).t_q_p, 0.0)
    assert kabsch(moving, still[[0, 2]]).residual == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("variances", "closure", "gap"), [([0.0025] * 100, 0.01, 1.0), ([0.01, 0.04, 0.01], 0.01, 0.7)]
)
def test_a_closure_spreads_as_the_formula_says(variances: list[float], closure: float, gap: float) -> None:
    chain = np.array(variances)
    count = len(chain)
    rows = np.eye(count) - np.eye(count, k=-1)
    J = np.vstack([rows, np.eye(count)[-1]])
    omega = np.diag(1.0 / np.append(chain, closure))
    covariance = np.linalg.inv(J.T @ omega @ J)
    poses = covariance @ J.T @ omega @ np.append(np.zeros(count), gap)
    total, partial = chain.sum(), np.cumsum(chain)
    assert np.diff(poses, prepend=0.0) == pytest.approx(chain / (total + closure) * gap)
    assert np.diag(covariance) == pytest.approx(partial * (total - partial + closure) / (total + closure))
    assert np.diag(covariance).max() <= (total + closure) / 4 + 1e-12


def test_one_false_turn_seen_by_the_absolute_error() -> None:
    turns = np.zeros(200)
    turns[99] = 0.1
    estimate, truth = [np.zeros(3)], [np.zeros(3)]
    for turn in turns:
        estimate.append(se2.compose(estimate[-1], (1.0, 0.0, turn)))
        truth.append(se2.compose(truth[-1], (1.0, 0.0, 0.0)))
    assert states("methodes", absolute_trajectory_error(np.array(truth), np.array(estimate)).rmse, 2)
