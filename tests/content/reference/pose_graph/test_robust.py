"""False loop closures: what Huber cannot undo, what DCS, switchable constraints and graduated non-convexity can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import least_squares, minimize_scalar

from reference.pose_graph import (
    DCS,
    Huber,
    ParameterError,
    ShapeError,
    Switchable,
    add_false_closures,
    chordal_initial_guess,
    edge_chi2,
    edge_residuals,
    gauss_newton,
    graduated_non_convexity,
    robust_gauss_newton,
)

from .loops import loop, odometry

KERNELS = [Huber(1.3), DCS(2.0), Switchable(1.7)]


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_weight_is_the_slope_of_its_cost(kernel) -> None:
    for u in (0.01, 1.0, 1.9, 2.1, 30.0):
        area, _ = quad(lambda v: float(kernel.weight(np.array(v))), 0, u, points=[1.69, 2.0] if u > 2 else None)
        assert float(kernel.rho(np.array(u))) == pytest.approx(area, rel=1e-7)
    weights = kernel.weight(np.logspace(-3, 6, 50))
    assert np.all(np.diff(weights) <= 0)
    assert np.all((weights > 0) & (weights <= 1))


@pytest.mark.parametrize("u", [0.1, 1.0, 50.0])
def test_the_eliminated_switch_is_the_best_one(u: float) -> None:
    kernel = Switchable(1.7)
    best = minimize_scalar(lambda s: s * s * u + 1.7 * (1 - s) ** 2, bounds=(0, 1), method="bounded")
    assert float(kernel.switch(np.array(u))) == pytest.approx(best.x, abs=1e-5)
    assert float(kernel.rho(np.array(u))) == pytest.approx(best.fun, rel=1e-9)


def test_switches_searched_for_jointly_give_the_same_poses() -> None:
    """The 3n + m unknowns of Sünderhauf and Protzel by SciPy, against the m switches eliminated."""
    content = loop(2, noise=0.02)
    graph, _ = add_false_closures(content.graph, 1, np.random.default_rng(0))
    roots = np.linalg.cholesky(graph.information).transpose(0, 2, 1)
    doubted = np.flatnonzero(graph.is_closure_mask)
    found = robust_gauss_newton(graph, content.poses, Switchable(1.0), tolerance=1e-10, chi2_tolerance=0.0)

    def errors(x: np.ndarray) -> np.ndarray:
        poses = np.vstack([content.poses[:1], x[:21].reshape(-1, 3)])
        e = np.einsum("mij,mj->mi", roots, edge_residuals(graph, poses))
        e[doubted] *= x[21:, None]
        return np.concatenate([e.ravel(), 1.0 - x[21:]])

    begin = np.concatenate([found.poses[1:].ravel(), np.ones(len(doubted))])
    peer = least_squares(errors, begin, xtol=1e-15, ftol=1e-15, gtol=1e-14)
    np.testing.assert_allclose(peer.x[:21].reshape(-1, 3), found.poses[1:], atol=1e-5)
    np.testing.assert_allclose(peer.x[21:] ** 2, found.weights[doubted], atol=1e-4)
    assert 2 * peer.cost == pytest.approx(found.solution.chi2[-1], rel=1e-8)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_robust_minimum_has_no_slope(kernel) -> None:
    content = loop(4, noise=0.3)
    found = robust_gauss_newton(content.graph, content.poses, kernel, tolerance=1e-11, chi2_tolerance=0.0)
    doubted = content.graph.is_closure_mask

    def cost(poses: np.ndarray) -> float:
        u = edge_chi2(content.graph, poses)
        return float(np.where(doubted, kernel.rho(u), u).sum())

    assert found.solution.chi2[-1] == pytest.approx(cost(found.poses))
    for k in range(3, 24):
        step = np.zeros(24)
        step[k] = 1e-5
        step = step.reshape(8, 3)
        slope = (cost(found.poses + step) - cost(found.poses - step)) / 2e-5
        assert abs(slope) < 1e-4 * cost(found.poses)


def test_without_false_closures_nothing_is_rejected() -> None:
    content = loop(3, noise=0.01)
    plain = gauss_newton(content.graph, content.poses)
    for found in (
        robust_gauss_newton(content.graph, content.poses, DCS(20.0)),
        graduated_non_convexity(content.graph, content.poses),
    ):
        assert not found.rejected.any()
        np.testing.assert_allclose(found.poses, plain.poses, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_one_false_closure_bends_the_map_and_robust_costs_undo_it(seed: int) -> None:
    """Course, challenge 3."""
    content = loop(seed, n=30, noise=0.02)
    fitting = replace(content.graph, information=100 * content.graph.information)
    truth = gauss_newton(fitting, content.poses).poses
    graph, false = add_false_closures(fitting, 1, np.random.default_rng(seed))

    def away(poses: np.ndarray) -> float:
        return float(np.abs(poses - truth)[:, :2].max())

    plain = gauss_newton(graph, content.poses, max_iterations=100)
    switched = robust_gauss_newton(graph, content.poses, DCS(10.0))
    graded = graduated_non_convexity(graph, content.poses)
    assert away(plain.poses) > 0.3
    assert away(graded.poses) < 1e-6
    assert away(switched.poses) < away(plain.poses) / 10
    assert np.array_equal(graded.rejected, false)
    assert switched.rejected[false].all()


@pytest.mark.parametrize("count", [10, pytest.param(100, marks=pytest.mark.slow)])
def test_manhattan_among_false_closures(published, count: int) -> None:
    """From odometry DCS (phi = 1) and GNC find exactly the false ones, hence the published optimum; Huber does not."""
    content = published("M3500")
    graph, false = add_false_closures(content.graph, count, np.random.default_rng(1))
    start = odometry(graph, content.poses[0])
    optimum = gauss_newton(content.graph, content.poses).poses
    for found in (
        robust_gauss_newton(graph, start, DCS(1.0)),
        graduated_non_convexity(graph, start, bound=1.0),
    ):
        assert np.array_equal(found.rejected, false)
        again = gauss_newton(graph.keep_edges(~found.rejected), found.poses)
        assert again.chi2[-1] == pytest.approx(137.91295, rel=1e-6)
        assert np.abs(found.poses - optimum).max() < 0.05
    huber = robust_gauss_newton(graph, start, Huber(1.0), max_iterations=30)
    assert np.hypot(*(huber.poses - optimum)[:, :2].T).max() > 10


def test_a_scale_too_small_throws_out_true_edges(published) -> None:
    """On INTEL DCS with phi = 1 rejects 27 true closures; with phi = 10 the plain optimum stands."""
    content = published("INTEL")
    strict = robust_gauss_newton(content.graph, content.poses, DCS(1.0))
    right = robust_gauss_newton(content.graph, content.poses, DCS(10.0))
    assert np.count_nonzero(strict.rejected) == 27
    assert not right.rejected.any()
    assert right.solution.chi2[-1] == pytest.approx(215.83023, rel=1e-6)


def test_settings_out_of_range_are_refused() -> None:
    content = loop(0)
    graph, poses = content.graph, content.poses
    for make, argument in (
        (lambda: Huber(0.0), "delta"),
        (lambda: DCS(np.nan), "phi"),
        (lambda: Switchable(-1.0), "prior"),
        (lambda: graduated_non_convexity(graph, poses, bound=0.0), "bound"),
        (lambda: add_false_closures(graph, -1, np.random.default_rng(0)), "count"),
    ):
        with pytest.raises(ParameterError) as caught:
            make()
        assert caught.value.argument == argument
    with pytest.raises(ShapeError) as shaped:
        robust_gauss_newton(graph, poses, DCS(1.0), suspects=np.array([True]))
    assert shaped.value.argument == "suspects"


def test_the_chordal_start_serves_robust_searches_too() -> None:
    content = loop(1, n=30, noise=0.02)
    start, _ = chordal_initial_guess(content.graph, content.poses)
    found = robust_gauss_newton(content.graph, start, DCS(10.0))
    assert found.solution.converged
