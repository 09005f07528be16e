"""Edges that say nothing along some direction: minimised as by dense least squares, or refused where no other helps.

The oracle is SciPy's least squares on the square roots of the same matrices.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import least_squares

from reference.pose_graph import (
    Certificate,
    DisconnectedGraphError,
    PoseGraph,
    SingularSystemError,
    certify,
    chi2,
    chordal_initial_guess,
    edge_residuals,
    gauss_newton,
    graduated_non_convexity,
    marginal_covariances,
)
from reference.se2 import compose, relative

Floats = NDArray[np.float64]
EYE = np.eye(3)
ALONG_X = np.diag([1.0, 0.0, 1.0])
seeds = st.integers(0, 2**32 - 1)


def partial(rng: np.random.Generator, rank: int) -> Floats:
    """A random information matrix (3, 3) of that rank, symmetric to the last digit."""
    root = rng.normal(size=(3, rank)) * 5.0
    return np.asarray(root @ root.T)


def journey(rng: np.random.Generator, n: int) -> tuple[PoseGraph, Floats]:
    """A chain of full edges, with as many partial ones across it, all slightly wrong; and the true poses (n, 3)."""
    truth = [np.zeros(3)]
    for _ in range(n - 1):
        truth.append(compose(truth[-1], rng.uniform([0.5, -0.2, -0.8], [1.5, 0.2, 0.8])))
    poses = np.array(truth)
    pairs = [(k, k + 1, 3) for k in range(n - 1)]
    for _ in range(n):
        i, j = rng.choice(n, 2, replace=False)
        pairs.append((int(i), int(j), int(rng.integers(0, 4))))
    edges = [
        (i, j, relative(poses[i], poses[j]) + rng.normal(0, 0.03, 3), partial(rng, rank) + (EYE if rank == 3 else 0.0))
        for i, j, rank in pairs
    ]
    return PoseGraph.from_edges(n, edges), poses


def dense_optimum(graph: PoseGraph, start: Floats) -> Floats:
    values, vectors = np.linalg.eigh(graph.information)
    roots = np.sqrt(np.maximum(values, 0.0))[:, :, None] * vectors.transpose(0, 2, 1)

    def gaps(free: Floats) -> Floats:
        e = edge_residuals(graph, np.vstack([start[:1], free.reshape(-1, 3)]))
        return np.asarray((roots @ e[:, :, None]).ravel())

    found = least_squares(gaps, start[1:].ravel(), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return np.vstack([start[:1], found.x.reshape(-1, 3)])


@settings(deadline=None, max_examples=25)
@given(seed=seeds, n=st.integers(2, 7))
def test_the_optimum_is_that_of_dense_least_squares(seed: int, n: int) -> None:
    graph, truth = journey(np.random.default_rng(seed), n)
    found = gauss_newton(graph, truth)
    dense = dense_optimum(graph, truth)
    assert found.converged
    assert chi2(graph, found.poses) == pytest.approx(chi2(graph, dense), rel=1e-6, abs=1e-9)
    np.testing.assert_allclose(relative(dense, found.poses), 0.0, atol=1e-5)


def test_a_corridor_keeps_its_good_direction(solver: str) -> None:
    """Odometry drifts sideways and along; matches across the corridor hold y and the heading, and leave x alone."""
    odometry = (1.1, 0.2, 0.05)
    across = np.diag([0.0, 1e4, 1e4])
    edges = [(k, k + 1, odometry, EYE) for k in range(4)] + [(k, k + 1, (0.0, 0.0, 0.0), across) for k in range(4)]
    found = gauss_newton(PoseGraph.from_edges(5, edges), np.zeros((5, 3))).poses
    np.testing.assert_allclose(found[:, 1:], 0.0, atol=1e-3)
    np.testing.assert_allclose(found[:, 0], 1.1 * np.arange(5), atol=1e-3)


def test_what_no_edge_tells_is_refused_and_not_invented(solver: str) -> None:
    graph = PoseGraph.from_edges(3, [(0, 1, (1, 0, 0), EYE), (1, 2, (1, 0, 0), ALONG_X)])
    assert not graph.is_fully_informed
    for solve in (
        lambda: gauss_newton(graph, np.zeros((3, 3))),
        lambda: graduated_non_convexity(graph, np.zeros((3, 3))),
        lambda: marginal_covariances(graph, np.zeros((3, 3))),
        lambda: chordal_initial_guess(graph),
    ):
        with pytest.raises(SingularSystemError):
            solve()


def test_orientations_that_no_edge_tells_have_no_chordal_start() -> None:
    graph = PoseGraph.from_edges(2, [(0, 1, (1, 0, 0), np.diag([1.0, 1.0, 0.0]))])
    with pytest.raises(DisconnectedGraphError, match="orientation"):
        chordal_initial_guess(graph)


def test_two_halves_make_a_whole(solver: str) -> None:
    """Two partial edges that complete each other determine what each alone leaves free, from the chordal start too."""
    z = np.array([1.0, 0.5, 0.3])
    graph = PoseGraph.from_edges(2, [(0, 1, z, ALONG_X), (0, 1, z, np.diag([0.0, 2.0, 0.0]))])
    start, _ = chordal_initial_guess(graph)
    for poses in (start, np.zeros((2, 3))):
        np.testing.assert_allclose(gauss_newton(graph, poses).poses[1], z, atol=1e-8)
    covariances, _ = marginal_covariances(graph, start)
    np.testing.assert_allclose(np.diag(covariances[1]), [1.0, 0.5, 1.0])


def test_of_partial_information_nothing_is_certified() -> None:
    graph, truth = journey(np.random.default_rng(4), 5)
    found = certify(graph, gauss_newton(graph, truth).poses)
    assert isinstance(found, Certificate)
    assert not found.is_global


@pytest.mark.parametrize("omega", [np.zeros((3, 3)), ALONG_X, np.ones((3, 3))])
def test_semidefinite_matrices_are_information(omega: Any) -> None:
    graph = PoseGraph.from_edges(2, [(0, 1, (1, 0, 0), EYE), (0, 1, (9, 9, 1), omega)])
    assert not graph.is_fully_informed
    assert PoseGraph.from_edges(2, [(0, 1, (1, 0, 0), EYE)]).is_fully_informed
