"""Pose graphs against finite differences, a dense solver and SciPy's least squares."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from reference.pose_graph import (
    DisconnectedGraphError,
    EdgeEndsError,
    InformationError,
    NonFiniteError,
    NormalEquations,
    PoseGraph,
    ShapeError,
    StopReason,
    chi2,
    edge_chi2,
    edge_residuals,
    gauss_newton,
    group_residuals,
    jacobians,
    residuals,
)
from reference.se2 import compose, relative, wrap_angle

from .loops import loop

EYE = np.eye(3)

coordinate = st.floats(-20, 20)
angles = st.floats(-math.pi, math.pi)
poses_of = st.tuples(coordinate, coordinate, angles).map(np.array)


def noisy_loop(seed: int) -> tuple[PoseGraph, np.ndarray]:
    content = loop(seed)
    return content.graph, content.poses


@given(poses_of, poses_of, poses_of)
def test_residuals_are_the_relative_pose_minus_the_measurement(a, b, z) -> None:
    e = residuals(a, b, z)
    seen = relative(a, b)
    np.testing.assert_allclose(e[:2], seen[:2] - z[:2], atol=1e-9)
    assert math.isclose(math.remainder(e[2] - (seen[2] - z[2]), math.tau), 0, abs_tol=1e-9)
    assert -math.pi < e[2] <= math.pi + 1e-12


@given(poses_of, poses_of, poses_of)
def test_group_residuals_are_the_pose_seen_from_the_measured_one(a, b, z) -> None:
    e, wanted = group_residuals(a, b, z), relative(z, relative(a, b))
    np.testing.assert_allclose(e[:2], wanted[:2], atol=1e-9)
    assert abs(math.remainder(e[2] - wanted[2], math.tau)) < 1e-9


@given(poses_of, poses_of)
def test_residuals_vanish_when_the_edge_is_consistent(a, z) -> None:
    b = compose(a, z)
    np.testing.assert_allclose(np.abs(residuals(a, b, z)), 0, atol=1e-9)


@given(poses_of, poses_of, poses_of, st.floats(0.1, 9), st.floats(0.1, 9))
def test_both_conventions_have_one_chi2_when_the_translation_is_isotropic(a, b, z, at, ar) -> None:
    omega = np.diag([at, at, ar])
    one, other = residuals(a, b, z), group_residuals(a, b, z)
    assert math.isclose(one @ omega @ one, other @ omega @ other, rel_tol=1e-9, abs_tol=1e-9)


@given(poses_of, poses_of)
def test_jacobians_are_those_of_finite_differences(a, b) -> None:
    z = relative(a, b)  # the angle of the error is far from the cut
    by_i, by_j = jacobians(a[None], b[None])
    h = 1e-6
    for k in range(3):
        d = h * EYE[k]
        numeric_i = (residuals(a + d, b, z) - residuals(a - d, b, z)) / (2 * h)
        numeric_j = (residuals(a, b + d, z) - residuals(a, b - d, z)) / (2 * h)
        np.testing.assert_allclose(by_i[0][:, k], numeric_i, atol=2e-8)
        np.testing.assert_allclose(by_j[0][:, k], numeric_j, atol=2e-8)


@pytest.mark.parametrize("seed", range(4))
def test_sparse_assembly_is_the_dense_product(seed: int) -> None:
    graph, start = noisy_loop(seed)
    m, n = len(graph.i), graph.n_poses
    J, W = np.zeros((3 * m, 3 * n)), np.zeros((3 * m, 3 * m))
    by_i, by_j = jacobians(start[graph.i], start[graph.j])
    for k in range(m):
        rows = slice(3 * k, 3 * k + 3)
        J[rows, 3 * graph.i[k] : 3 * graph.i[k] + 3] = by_i[k]
        J[rows, 3 * graph.j[k] : 3 * graph.j[k] + 3] = by_j[k]
        W[rows, rows] = graph.information[k]
    equations = NormalEquations(graph)
    system = equations.assemble(equations.join_state(start))
    upper = equations.pattern.upper_triangle(system.upper_entries).toarray()
    np.testing.assert_allclose(upper, np.triu((J.T @ W @ J)[3:, 3:]), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(system.b, (J.T @ W @ edge_residuals(graph, start).ravel())[3:], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_the_optimum_is_that_of_scipy(seed: int) -> None:
    graph, start = noisy_loop(seed)
    roots = np.linalg.cholesky(graph.information).transpose(0, 2, 1)

    def whitened(free: np.ndarray) -> np.ndarray:
        poses = np.vstack([start[:1], free.reshape(-1, 3)])
        return np.einsum("mij,mj->mi", roots, edge_residuals(graph, poses)).ravel()

    found = gauss_newton(graph, start)
    peer = least_squares(whitened, start[1:].ravel(), xtol=1e-14, ftol=1e-14, gtol=1e-12)
    assert found.converged
    assert found.chi2[-1] == pytest.approx(2 * peer.cost, rel=1e-9)
    difference = found.poses[1:] - peer.x.reshape(-1, 3)
    difference[:, 2] = wrap_angle(difference[:, 2])
    np.testing.assert_allclose(difference, 0, atol=1e-6)


def test_the_solution_says_how_it_came_about() -> None:
    graph, start = noisy_loop(1)
    found = gauss_newton(graph, start)
    assert found.iterations == len(found.chi2) - 1 > 1
    assert found.chi2[0] > found.chi2[-1]
    np.testing.assert_allclose(found.chi2[:: len(found.chi2) - 1], [chi2(graph, start), chi2(graph, found.poses)])
    assert edge_chi2(graph, found.poses).sum() == pytest.approx(found.chi2[-1])
    np.testing.assert_array_equal(found.poses[0], start[0])
    cut = gauss_newton(graph, start, max_iterations=1)
    assert not cut.converged
    assert cut.reason is StopReason.ITERATIONS
    assert cut.gauge.fixed == (0,)
    assert cut.gauge.rank == cut.gauge.unknowns == 21
    assert cut.iterations == 1


def test_the_start_is_left_alone() -> None:
    graph, start = noisy_loop(2)
    before = start.copy()
    gauss_newton(graph, start)
    np.testing.assert_array_equal(start, before)


def test_a_discrepancy_is_shared_equally_between_equal_edges() -> None:
    """Three edges on a line disagree by 3: each gives way by 1."""
    edges = [(0, 1, [2, 0, 0], EYE), (1, 2, [2, 0, 0], EYE), (0, 2, [7, 0, 0], EYE)]
    found = gauss_newton(PoseGraph.from_edges(3, edges), [[0, 0, 0], [2, 0, 0], [4, 0, 0]])
    np.testing.assert_allclose(found.poses, [[0, 0, 0], [3, 0, 0], [6, 0, 0]], atol=1e-12)
    assert found.chi2[-1] == pytest.approx(3)


@settings(max_examples=25)
@given(st.integers(0, 10_000), poses_of)
def test_moving_the_whole_graph_moves_the_optimum_with_it(seed: int, T_v_w: np.ndarray) -> None:
    graph, start = noisy_loop(seed)
    moved = np.array([compose(T_v_w, pose) for pose in start])
    one, other = gauss_newton(graph, start), gauss_newton(graph, moved)
    np.testing.assert_allclose(other.chi2[-1], one.chi2[-1], rtol=1e-6)
    back = np.array([relative(T_v_w, pose) for pose in other.poses]) - one.poses
    np.testing.assert_allclose(np.column_stack([back[:, :2], wrap_angle(back[:, 2])]), 0, atol=1e-6)


def test_one_pose_is_already_solved() -> None:
    found = gauss_newton(PoseGraph.from_edges(1, []), [[1, 2, 3]])
    assert found.converged
    np.testing.assert_array_equal(found.poses, [[1, 2, 3]])


def edge(i: int = 0, j: int = 1, z: tuple = (1, 0, 0), omega: np.ndarray = EYE) -> tuple:
    return i, j, np.array(z, dtype=float), omega


@pytest.mark.parametrize(
    ("n", "edges", "error", "argument"),
    [
        (3, [edge()], DisconnectedGraphError, "edges"),
        (2, [], DisconnectedGraphError, "edges"),
        (2, [edge(j=2)], EdgeEndsError, "j"),
        (2, [edge(i=-1)], EdgeEndsError, "i"),
        (2, [edge(), edge(i=1)], EdgeEndsError, "j"),
        (2, [edge(z=(1, math.nan, 0))], NonFiniteError, "z_i_j"),
        (2, [edge(omega=np.full((3, 3), math.inf))], NonFiniteError, "information"),
        (2, [edge(omega=EYE + np.eye(3, k=1))], InformationError, "information"),
        (2, [edge(omega=np.diag([1.0, 1.0, -1.0]))], InformationError, "information"),
        (0, [], ShapeError, "n_poses"),
    ],
)
def test_what_is_not_a_graph_is_refused_by_name(n, edges, error, argument) -> None:
    with pytest.raises(error) as caught:
        PoseGraph.from_edges(n, edges)
    assert caught.value.argument == argument


@pytest.mark.parametrize(
    ("poses", "error"), [(np.zeros((3, 3)), ShapeError), (np.full((2, 3), np.nan), NonFiniteError)]
)
def test_poses_that_do_not_fit_are_refused(poses, error) -> None:
    with pytest.raises(error) as caught:
        gauss_newton(PoseGraph.from_edges(2, [edge()]), poses)
    assert caught.value.argument == "poses"
