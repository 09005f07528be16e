"""The published sets: chi2 of every one in both conventions, local minima that are told from global ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reference.metrics import absolute_trajectory_error
from reference.pose_graph import StopReason, certify, chi2, chordal_initial_guess, gauss_newton, levenberg_marquardt
from reference.pose_graph.residuals import edge_chi2

from .loops import odometry

OPTIMA = [
    ("INTEL", "g2o", 215.83023),
    ("INTEL", "difference", 214.17086),
    ("MITb", "g2o", 41.163269),
    ("MITb", "difference", 39.601294),
    ("M3500", "g2o", 137.91295),
    ("M3500", "difference", 137.91295),
    ("city10000", "g2o", 511.98516),
    ("g2o_intel_943", "g2o", 546.46111),
    ("g2o_intel_943", "difference", 546.46111),
    ("ring", "g2o", 11.163101),
    ("ring", "difference", 11.163101),
]


@pytest.mark.parametrize(("name", "convention", "optimum"), OPTIMA)
def test_the_chordal_start_leads_to_the_published_optimum_which_is_certified(
    published, name, convention, optimum
) -> None:
    content = published(name, convention)
    start, _ = chordal_initial_guess(content.graph, content.poses)
    found = gauss_newton(content.graph, start)
    assert found.converged
    assert found.chi2[-1] == pytest.approx(optimum, rel=1e-6)
    assert certify(content.graph, found.poses).is_global


@pytest.mark.parametrize(("name", "steps", "optimum"), [("INTEL", 5, 215.83023), ("M3500", 5, 137.91295)])
def test_gauss_newton_needs_few_steps_from_the_given_start(published, solver, name, steps, optimum) -> None:
    content = published(name)
    found = gauss_newton(content.graph, content.poses, max_iterations=steps)
    assert found.chi2[-1] == pytest.approx(optimum, rel=1e-6)


def test_the_error_of_manhattan_at_its_optimum(published) -> None:
    """ATE 0.7226 m. The truth stands on a grid of metres and right angles: rounded edges all agree on it."""
    content = published("M3500")
    quarters = [1.0, 1.0, np.pi / 2]
    rounded = replace(content.graph, z_i_j=np.round(content.graph.z_i_j / quarters) * quarters)
    truth = odometry(rounded, np.zeros(3))
    assert edge_chi2(rounded, truth).max() < 1e-9
    found = gauss_newton(content.graph, content.poses)
    assert absolute_trajectory_error(truth, found.poses).rmse == pytest.approx(0.7226, abs=5e-5)


@pytest.mark.parametrize(
    ("name", "first", "optimum"),
    [("lsslam-pose-landmark", 3030.31, 474.09965), ("lsslam-pose-pose", 138862234.08, 8269.4228)],
)
def test_the_sets_of_the_course_of_freiburg(published, solver, name, first, optimum) -> None:
    content = published(name)
    found = gauss_newton(content.graph, content.poses, content.landmarks)
    assert found.chi2[0] == pytest.approx(first, abs=5e-3)
    assert found.chi2[-1] == pytest.approx(optimum, rel=1e-6)
    assert chi2(content.graph, found.poses, found.landmarks) == pytest.approx(found.chi2[-1])


def test_gauss_newton_from_odometry_stops_in_a_local_minimum_which_no_certificate_accepts(published) -> None:
    content = published("MITb")
    found = gauss_newton(content.graph, content.poses, max_iterations=60)
    assert found.converged
    assert found.chi2[-1] == pytest.approx(770.66, abs=0.01)
    proof = certify(content.graph, found.poses)
    assert proof.gradient < 1e-9
    assert not proof.is_global
    assert proof.negative_pivots > 0


def test_levenberg_marquardt_reaches_the_optimum_from_the_chordal_start(published) -> None:
    content = published("MITb")
    start, _ = chordal_initial_guess(content.graph, content.poses)
    found = levenberg_marquardt(content.graph, start)
    assert found.converged
    assert found.chi2[-1] == pytest.approx(41.163269, rel=1e-6)
    assert np.all(np.diff(found.chi2) <= 0)


@pytest.mark.parametrize(("name", "optimum"), [("ring", 11.163101), ("M3500", 137.91295), ("city10000", 511.98516)])
def test_levenberg_marquardt_from_odometry_is_damped_too_little_to_be_caught(published, name, optimum) -> None:
    """With a first damping of 1e-5, city10000 stops in a local minimum at 1484.69 after 77 steps."""
    content = published(name)
    found = levenberg_marquardt(content.graph, content.poses, max_iterations=20)
    assert found.converged
    assert found.chi2[-1] == pytest.approx(optimum, rel=1e-6)


def test_the_ring_has_its_published_cost_with_unit_information(published) -> None:
    """Half of chi2 with omega = I: 0.0222."""
    content = published("ring")
    graph = replace(content.graph, information=np.tile(np.eye(3), (459, 1, 1)))
    found = gauss_newton(graph, chordal_initial_guess(graph)[0])
    assert found.chi2[-1] / 2 == pytest.approx(0.0222, abs=5e-5)


def test_a_step_that_promises_nothing_ends_the_search(published) -> None:
    content = published("INTEL", "difference")
    found = gauss_newton(content.graph, content.poses)
    assert found.reason in (StopReason.SMALL_STEP, StopReason.SMALL_DECREASE)
    assert edge_chi2(content.graph, found.poses).sum() == pytest.approx(214.17086, rel=1e-6)
