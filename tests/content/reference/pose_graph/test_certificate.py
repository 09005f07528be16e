"""The certificate: its bound holds, it accepts global minima of small graphs and rejects local ones."""

from __future__ import annotations

import numpy as np
import pytest

from reference.pose_graph import ParameterError, PoseGraph, certify, chi2, chordal_initial_guess, gauss_newton
from reference.pose_graph.certificate import _assemble_hermitian, _edge_terms, _sighting_terms

from .loops import EYE, loop


@pytest.mark.parametrize("convention", ["difference", "g2o"])
@pytest.mark.parametrize("seed", range(5))
def test_the_quadratic_form_bounds_chi2_from_below(seed: int, convention: str) -> None:
    """(18) to (20), with information that couples everything: chi2(x) - chi2(x^) >= v' M v - v^' M v^, everywhere."""
    content = loop(seed, noise=0.03, n_landmarks=2, convention=convention)
    graph = content.graph
    found = gauss_newton(graph, content.poses, content.landmarks)
    terms = [*_edge_terms(graph, found.poses), *_sighting_terms(graph, found.poses, found.landmarks)]
    M = _assemble_hermitian(terms, 2 * 8 + 2)

    def form(poses: np.ndarray, landmarks: np.ndarray) -> float:
        turns = np.exp(1j * poses[:, 2])
        v = np.concatenate([poses[:, :2] @ [1, 1j], landmarks @ [1, 1j], turns])
        return float((v.conj() @ (M @ v)).real)

    base = chi2(graph, found.poses, found.landmarks) - form(found.poses, found.landmarks)
    rng = np.random.default_rng(seed)
    for size in (1e-3, 0.1, 1.0, 10.0):
        for _ in range(20):
            poses = found.poses + rng.normal(0, size, (8, 3))
            points = found.landmarks + rng.normal(0, size, (2, 2))
            gap = chi2(graph, poses, points) - form(poses, points) - base
            assert gap >= -1e-8 * (1 + chi2(graph, poses, points))


@pytest.mark.parametrize("seed", range(5))
def test_optima_of_small_graphs_are_certified(solver, seed: int) -> None:
    content = loop(seed, noise=0.05, n_landmarks=2 * (seed % 2))
    found = gauss_newton(content.graph, content.poses, content.landmarks)
    proof = certify(content.graph, found.poses, found.landmarks)
    assert proof.is_global
    assert proof.negative_pivots == 0
    assert proof.gradient < 1e-9


def test_a_ring_wound_once_too_often_is_a_local_minimum_that_is_rejected(solver) -> None:
    """A circle of 12 poses has local minima with other numbers of turns; none is ever certified."""
    n, turn = 12, 2 * np.pi / 12
    edges = [(k, (k + 1) % n, [1, 0, turn], EYE) for k in range(n)]
    graph = PoseGraph.from_edges(n, edges)
    wound = np.zeros((n, 3))
    wound[:, 2] = 2 * turn * np.arange(n)
    steps = np.column_stack([np.cos(wound[:, 2]), np.sin(wound[:, 2])])
    wound[1:, :2] = np.cumsum(steps, axis=0)[:-1]
    local, best = gauss_newton(graph, wound), gauss_newton(graph, chordal_initial_guess(graph)[0])
    assert local.converged
    assert local.chi2[-1] > 1
    assert best.chi2[-1] < 1e-9
    assert not certify(graph, local.poses).is_global
    assert certify(graph, best.poses).is_global


def test_what_is_not_stationary_is_not_certified() -> None:
    content = loop(0)
    proof = certify(content.graph, content.poses)
    assert proof.gradient > 1e-3
    assert not proof.is_global


def test_one_pose_is_certain_and_several_fixed_ones_are_refused() -> None:
    assert certify(PoseGraph.from_edges(1, []), [[1, 2, 3]]).is_global
    content = loop(0, fixed=(0, 1))
    with pytest.raises(ParameterError) as caught:
        certify(content.graph, content.poses)
    assert caught.value.argument == "graph"
