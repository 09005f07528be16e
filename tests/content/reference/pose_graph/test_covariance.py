"""Covariances against the dense inverse, and theorem 5 of the course in numbers."""

from __future__ import annotations

import numpy as np
import pytest

from reference.pose_graph import (
    NodeIndexError,
    NormalEquations,
    PoseGraph,
    Sightings,
    SingularSystemError,
    gauss_newton,
    joint_covariance,
    marginal_covariances,
    relative_covariance,
)
from reference.se2 import compose

from .loops import loop


def dense_covariance(graph: PoseGraph, poses: np.ndarray, landmarks: np.ndarray) -> np.ndarray:
    """The inverse of H, with zeros for the fixed poses."""
    equations = NormalEquations(graph)
    upper = equations.upper_triangle(equations.join_state(poses, landmarks)).toarray()
    whole = np.zeros((3 * graph.n_poses + 2 * graph.n_landmarks,) * 2)
    whole[np.ix_(equations.free, equations.free)] = np.linalg.inv(upper + np.triu(upper, 1).T)
    return whole


@pytest.mark.parametrize("settings", [{}, {"n_landmarks": 3}, {"n_landmarks": 2, "fixed": (3, 1)}])
def test_every_covariance_is_that_of_the_dense_inverse(solver, settings) -> None:
    content = loop(1, n=12, **settings)
    graph, poses, landmarks = content.graph, content.poses, content.landmarks
    dense = dense_covariance(graph, poses, landmarks)
    of_poses, of_landmarks = marginal_covariances(graph, poses, landmarks)
    for k in range(12):
        np.testing.assert_allclose(of_poses[k], dense[3 * k : 3 * k + 3, 3 * k : 3 * k + 3], atol=1e-12)
    for k in range(graph.n_landmarks):
        at = 36 + 2 * k
        np.testing.assert_allclose(of_landmarks[k], dense[at : at + 2, at : at + 2], atol=1e-12)
    nodes = [5, 0, *range(12, 12 + graph.n_landmarks)]
    rows = [15, 16, 17, 0, 1, 2, *range(36, 36 + 2 * graph.n_landmarks)]
    np.testing.assert_allclose(joint_covariance(graph, poses, nodes, landmarks), dense[np.ix_(rows, rows)], atol=1e-12)


def test_the_selected_inverse_of_a_published_graph(published, solver) -> None:
    content = published("ring")
    poses = gauss_newton(content.graph, content.poses).poses
    dense = dense_covariance(content.graph, poses, content.landmarks)
    found, _ = marginal_covariances(content.graph, poses)
    wanted = np.array([dense[k : k + 3, k : k + 3] for k in range(0, len(dense), 3)])
    np.testing.assert_allclose(found, wanted, atol=1e-7 * wanted.max())


def test_a_relative_covariance_does_not_depend_on_what_is_fixed() -> None:
    found = [
        relative_covariance(content.graph, content.poses, 2, 6, content.landmarks)
        for content in (loop(3, n_landmarks=2, fixed=(k,)) for k in (0, 2, 4))
    ]
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)
    np.testing.assert_allclose(found[2], found[0], atol=1e-12)


def chain(n: int, odometry: np.ndarray, closure: np.ndarray | None) -> tuple[PoseGraph, np.ndarray]:
    """A winding walk of n steps, consistent, each of information `odometry`; the last pose seen from the first."""
    rng = np.random.default_rng(n)
    steps = rng.normal([1.0, 0.0, 0.3], 0.2, (n, 3))
    poses = [np.zeros(3)]
    for step in steps:
        poses.append(compose(poses[-1], step))
    edges = [(k, k + 1, steps[k], odometry) for k in range(n)]
    if closure is not None:
        edges.append((0, n, poses[-1], closure))
    return PoseGraph.from_edges(n + 1, edges), np.array(poses)


@pytest.mark.parametrize("n", [2, 10, 100, 1000])
def test_theorem_5_a_closure_bounds_the_drift(solver, n: int) -> None:
    """Sigma_total = (Omega_odometry + Sigma_b^-1)^-1 <= Sigma_b however long the chain, which alone drifts away."""
    rng = np.random.default_rng(7)
    root = rng.normal(size=(3, 3)) + 3 * np.eye(3)
    sigma_b = root @ root.T / 1000
    odometry = np.diag([400.0, 400.0, 2500.0])
    open_graph, poses = chain(n, odometry, None)
    closed_graph, _ = chain(n, odometry, np.linalg.inv(sigma_b))
    drift = relative_covariance(open_graph, poses, 0, n)
    total = relative_covariance(closed_graph, poses, 0, n)
    np.testing.assert_allclose(
        np.linalg.inv(total), np.linalg.inv(drift) + np.linalg.inv(sigma_b), rtol=1e-6, atol=1e-4
    )
    assert np.linalg.eigvalsh(sigma_b - total)[0] >= -1e-12
    assert np.linalg.eigvalsh(drift - total)[0] >= -1e-12
    assert drift[2, 2] == pytest.approx(n / 2500.0)
    assert total[2, 2] <= sigma_b[2, 2]


def test_the_drift_along_the_chain_is_least_at_its_ends_once_closed() -> None:
    graph, poses = chain(60, np.eye(3) * 100, np.eye(3) * 1e4)
    angle = marginal_covariances(graph, poses)[0][:, 2, 2]
    assert angle[0] == 0
    assert 10 <= np.argmax(angle) <= 50
    assert angle[-1] < 1e-4


def test_what_has_no_covariance_is_refused() -> None:
    content = loop(0)
    with pytest.raises(NodeIndexError) as caught:
        joint_covariance(content.graph, content.poses, [8])
    assert caught.value.argument == "nodes"
    seen = Sightings.from_edges(1, [(0, 0, [1, 0], np.eye(2)), (1, 0, [0, 1], np.eye(2))])
    graph = PoseGraph.from_edges(2, [], sightings=seen)
    with pytest.raises(SingularSystemError):
        marginal_covariances(graph, np.zeros((2, 3)), np.ones((1, 2)))
