"""Landmarks, the gauge, fixed poses, Levenberg-Marquardt and the factors, against dense algebra and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from reference.pose_graph import (
    DisconnectedGraphError,
    EdgeEndsError,
    NormalEquations,
    ParameterError,
    PoseGraph,
    ShapeError,
    Sightings,
    SingularSystemError,
    StopReason,
    chi2,
    chordal_initial_guess,
    edge_residuals,
    gauge_null_vectors,
    gauss_newton,
    landmark_jacobians,
    landmark_residuals,
    levenberg_marquardt,
)
from reference.pose_graph.factor import factorise
from reference.se2 import wrap_angle

from .loops import EYE, loop


def whitened(graph: PoseGraph, poses: np.ndarray, landmarks: np.ndarray) -> np.ndarray:
    """The residuals of all edges, each turned so that its information is I."""
    seen = graph.sightings
    parts = (
        (graph.information, edge_residuals(graph, poses)),
        (seen.information, landmark_residuals(poses[seen.i], landmarks[seen.landmark], seen.p_i_l)),
    )
    roots = [(np.linalg.cholesky(omega).transpose(0, 2, 1), e) for omega, e in parts]
    return np.concatenate([np.einsum("mij,mj->mi", root, e).ravel() for root, e in roots])


def dense_jacobian(graph: PoseGraph, poses: np.ndarray, landmarks: np.ndarray) -> np.ndarray:
    """Of `whitened`, by central differences, all nodes free."""
    state, h = np.concatenate([poses.ravel(), landmarks.ravel()]), 1e-6
    cut = poses.size

    def at(x: np.ndarray) -> np.ndarray:
        return whitened(graph, x[:cut].reshape(-1, 3), x[cut:].reshape(-1, 2))

    return np.column_stack([(at(state + h * u) - at(state - h * u)) / (2 * h) for u in np.eye(len(state))])


def test_landmark_jacobians_are_those_of_finite_differences() -> None:
    rng = np.random.default_rng(0)
    poses, points, h = rng.normal(size=(20, 3)), rng.normal(size=(20, 2)), 1e-6
    z = np.zeros((20, 2))
    by_i, by_l = landmark_jacobians(poses, points)
    for k in range(3):
        d = h * EYE[k]
        slope = (landmark_residuals(poses + d, points, z) - landmark_residuals(poses - d, points, z)) / (2 * h)
        np.testing.assert_allclose(by_i[..., k], slope, atol=1e-8)
    for k in range(2):
        d = h * EYE[k, :2]
        slope = (landmark_residuals(poses, points + d, z) - landmark_residuals(poses, points - d, z)) / (2 * h)
        np.testing.assert_allclose(by_l[..., k], slope, atol=1e-8)


@pytest.mark.parametrize("convention", ["difference", "g2o"])
@pytest.mark.parametrize("n_landmarks", [0, 3])
def test_the_normal_equations_are_those_of_the_dense_jacobian(convention: str, n_landmarks: int) -> None:
    content = loop(3, n_landmarks=n_landmarks, convention=convention)
    graph, poses, landmarks = content.graph, content.poses, content.landmarks
    J, e = dense_jacobian(graph, poses, landmarks), whitened(graph, poses, landmarks)
    equations = NormalEquations(graph, free_gauge=True)
    system = equations.assemble(equations.join_state(poses, landmarks))
    np.testing.assert_allclose(
        equations.pattern.upper_triangle(system.upper_entries).toarray(), np.triu(J.T @ J), atol=2e-6
    )
    np.testing.assert_allclose(system.b, J.T @ e, atol=2e-6)
    assert system.chi2 == pytest.approx(e @ e) == pytest.approx(chi2(graph, poses, landmarks))


@pytest.mark.parametrize("seed", range(6))
def test_any_graph_has_its_entries_where_they_belong(seed: int) -> None:
    """Edges that are repeated or run backwards, several poses fixed, landmarks seen from fixed and from free poses."""
    rng, n, n_landmarks = np.random.default_rng(seed), 7, 2
    pairs = [(k, k + 1) for k in range(n - 1)] + [rng.permutation(n)[:2].tolist() for _ in range(9)]
    edges = [(i, j, rng.normal(size=3), some_information(rng, 3)) for i, j in [*pairs, pairs[-1], pairs[-1][::-1]]]
    seen = [(i, k, rng.normal(size=2), some_information(rng, 2)) for k in range(n_landmarks) for i in (0, 3, 3, 6)]
    fixed = tuple(rng.permutation(n)[: 1 + seed % 3].tolist())
    sightings = Sightings.from_edges(n_landmarks, seen)
    graph = PoseGraph.from_edges(n, edges, sightings=sightings, fixed=fixed, convention="g2o")
    poses, landmarks = rng.normal(size=(n, 3)), rng.normal(size=(n_landmarks, 2))
    whole, held = NormalEquations(graph, free_gauge=True), NormalEquations(graph)
    J, e = dense_jacobian(graph, poses, landmarks), whitened(graph, poses, landmarks)
    for equations, kept in ((whole, slice(None)), (held, held.free)):
        system = equations.assemble(equations.join_state(poses, landmarks))
        H = (J.T @ J)[kept][:, kept]
        np.testing.assert_allclose(
            equations.pattern.upper_triangle(system.upper_entries).toarray(), np.triu(H), atol=5e-6
        )
        np.testing.assert_allclose(system.b, (J.T @ e)[kept], atol=5e-6)


def some_information(rng: np.random.Generator, size: int) -> np.ndarray:
    root = rng.normal(size=(size, size)) + 2 * np.eye(size)
    return root @ root.T


@pytest.mark.parametrize("n_landmarks", [0, 3])
def test_without_a_fixed_pose_three_directions_are_free_and_no_other(n_landmarks: int) -> None:
    """Course, challenge 3: H has a null space of dimension 3, spanned by two translations and a rotation."""
    content = loop(5, n_landmarks=n_landmarks)
    equations = NormalEquations(content.graph, free_gauge=True)
    upper = equations.upper_triangle(equations.join_state(content.poses, content.landmarks)).toarray()
    H = upper + np.triu(upper, 1).T
    V = gauge_null_vectors(content.poses, content.landmarks)
    np.testing.assert_allclose(H @ V, 0, atol=1e-10)
    assert np.linalg.matrix_rank(V) == 3
    values = np.linalg.eigvalsh(H)
    assert np.all(np.abs(values[:3]) < 1e-10)
    assert values[3] > 1e-2
    assert np.linalg.matrix_rank(H) == len(H) - 3


@pytest.mark.parametrize("method", [gauss_newton, levenberg_marquardt])
@pytest.mark.parametrize("convention", ["difference", "g2o"])
def test_the_optimum_with_landmarks_is_that_of_scipy(solver, method, convention) -> None:
    content = loop(1, n_landmarks=4, convention=convention, fixed=(2,))
    graph = content.graph
    free = np.setdiff1d(np.arange(24), [6, 7, 8])

    def split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        poses = content.poses.copy().ravel()
        poses[free] = x[: len(free)]
        return poses.reshape(-1, 3), x[len(free) :].reshape(-1, 2)

    begin = np.concatenate([content.poses.ravel()[free], content.landmarks.ravel()])
    peer = least_squares(lambda x: whitened(graph, *split(x)), begin, xtol=1e-14, ftol=1e-14, gtol=1e-12)
    found = method(graph, content.poses, content.landmarks)
    assert found.converged
    assert found.chi2[-1] == pytest.approx(2 * peer.cost, rel=1e-9)
    poses, landmarks = split(peer.x)
    difference = found.poses - poses
    np.testing.assert_allclose(np.column_stack([difference[:, :2], wrap_angle(difference[:, 2])]), 0, atol=1e-6)
    np.testing.assert_allclose(found.landmarks, landmarks, atol=1e-6)
    assert found.gauge.fixed == (2,)
    assert found.gauge.rank == 3 * 7 + 2 * 4


def test_several_fixed_poses_stay_where_they_are() -> None:
    content = loop(4, fixed=(0, 5))
    held = content.poses.copy()
    held[5] += 0.1
    found = gauss_newton(content.graph, held)
    assert found.converged
    np.testing.assert_allclose(found.poses[[0, 5]], held[[0, 5]], atol=1e-15)
    every = loop(4, fixed=tuple(range(8)))
    assert gauss_newton(every.graph, every.poses).reason is StopReason.NOTHING_FREE


def test_damped_steps_never_increase_chi2_where_plain_ones_do() -> None:
    content = loop(8, n=40, noise=0.5)
    far = content.poses + np.random.default_rng(0).normal(0, 3, content.poses.shape)
    far[0] = content.poses[0]
    damped, plain = levenberg_marquardt(content.graph, far), gauss_newton(content.graph, far)
    assert np.any(np.diff(plain.chi2) > 0)
    assert np.all(np.diff(damped.chi2) <= 0)
    assert damped.converged
    assert len(damped.damping) == damped.iterations


@pytest.mark.parametrize("seed", range(3))
def test_the_chordal_start_is_exact_without_noise(solver, seed: int) -> None:
    content = loop(seed, noise=0.0, n_landmarks=3)
    poses, landmarks = chordal_initial_guess(content.graph, content.poses)
    difference = poses - content.poses
    np.testing.assert_allclose(np.column_stack([difference[:, :2], wrap_angle(difference[:, 2])]), 0, atol=1e-9)
    np.testing.assert_allclose(landmarks, content.landmarks, atol=1e-9)


def test_the_chordal_start_solves_its_least_squares() -> None:
    content = loop(6, noise=0.3)
    graph = content.graph
    poses, _ = chordal_initial_guess(graph, content.poses)
    rows, right = [], []
    for i, j, z, omega in zip(graph.i, graph.j, graph.z_i_j, graph.information, strict=True):
        row = np.zeros(8, dtype=complex)
        row[j], row[i] = 1, -np.exp(1j * z[2])
        rows.append(np.sqrt(omega[2, 2]) * row)
    A, held = np.array(rows), np.exp(1j * content.poses[0, 2])
    right = -A[:, 0] * held
    r = np.linalg.lstsq(A[:, 1:], right, rcond=None)[0]
    np.testing.assert_allclose(poses[1:, 2], np.angle(r), atol=1e-9)


def test_the_two_solvers_agree(monkeypatch) -> None:
    content = loop(2, n=30, n_landmarks=5)
    equations = NormalEquations(content.graph)
    system = equations.assemble(equations.join_state(content.poses, content.landmarks))
    found = {}
    for name in ("as installed", "without qdldl"):
        factor = factorise(equations.pattern.upper_triangle(system.upper_entries))
        factor.update(2 * system.upper_entries)
        lower = factor.lower()
        L, D = lower.L.toarray(), np.diag(lower.pivots)
        upper = equations.pattern.upper_triangle(2 * system.upper_entries).toarray()
        H = upper + np.triu(upper, 1).T
        np.testing.assert_allclose(L @ D @ L.T, H[np.ix_(lower.p, lower.p)], atol=1e-9)
        found[name] = factor.solve(system.b)
        np.testing.assert_allclose(H @ found[name], system.b, atol=1e-9)
        monkeypatch.setattr("reference.pose_graph.factor.qdldl", None)
    np.testing.assert_allclose(*found.values(), atol=1e-12)


def line(seen: list, n_landmarks: int = 1, **settings) -> PoseGraph:
    edges = [(0, 1, [1, 0, 0], EYE)]
    return PoseGraph.from_edges(2, edges, sightings=Sightings.from_edges(n_landmarks, seen), **settings)


@pytest.mark.parametrize(
    ("make", "error", "argument"),
    [
        (lambda: line([]), DisconnectedGraphError, "edges"),
        (lambda: line([(0, 1, [1, 1], np.eye(2))]), EdgeEndsError, "sightings.landmark"),
        (lambda: line([(2, 0, [1, 1], np.eye(2))]), EdgeEndsError, "sightings.i"),
        (lambda: line([(0, 0, [1, np.nan], np.eye(2))]), ValueError, "sightings.p_i_l"),
        (lambda: line([(0, 0, [1, 1], -np.eye(2))]), ValueError, "sightings.information"),
        (lambda: line([], 0, fixed=()), ParameterError, "fixed"),
        (lambda: line([], 0, fixed=(2,)), ParameterError, "fixed"),
        (lambda: line([], 0, convention="other"), ParameterError, "convention"),
        (lambda: gauss_newton(line([(0, 0, [1, 1], np.eye(2))]), np.zeros((2, 3))), ShapeError, "landmarks"),
        (lambda: gauss_newton(line([], 0), np.zeros((2, 3)), max_iterations=-1), ParameterError, "max_iterations"),
        (lambda: gauss_newton(line([], 0), np.zeros((2, 3)), tolerance=np.nan), ParameterError, "tolerance"),
        (lambda: chordal_initial_guess(line([], 0, fixed=(0, 1))), ParameterError, "poses"),
        (lambda: line([], 0).keep_edges(np.array([False])), DisconnectedGraphError, "edges"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(make, error, argument) -> None:
    with pytest.raises(error) as caught:
        make()
    assert caught.value.argument == argument


def test_a_pose_that_one_landmark_alone_ties_is_not_determined(solver) -> None:
    seen = Sightings.from_edges(1, [(0, 0, [1, 0], np.eye(2)), (1, 0, [0, 1], np.eye(2))])
    graph = PoseGraph.from_edges(2, [], sightings=seen)
    with pytest.raises(SingularSystemError):
        gauss_newton(graph, [[0, 0, 0], [1, -1, 0]], [[1, 0]])
    with pytest.raises(DisconnectedGraphError):
        chordal_initial_guess(graph)


def test_measurements_that_cancel_out_leave_no_orientation() -> None:
    graph = PoseGraph.from_edges(2, [(0, 1, [1, 0, 0], EYE), (0, 1, [1, 0, np.pi], EYE)])
    with pytest.raises(ParameterError, match="orientation"):
        chordal_initial_guess(graph)
