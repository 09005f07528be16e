"""The graphs and edges that l20/slam_graphe grades on: within the contract, well conditioned, judged as meant."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graders.l20.slam_graphe import asked, graphs, residual
from graders.l20.slam_graphe.graphs import Graph
from graders.l20.slam_graphe.optimum import fingerprint, judge, simpler_graphs
from reference import pose_graph
from reference.se2 import compose
from tests.support.quick import some

FAMILIES = (asked.chains, asked.loops, asked.weighted, asked.turning, asked.large)


def family_graphs(seeds: Sequence[int]) -> list[Graph]:
    return [graph for seed in seeds for family in FAMILIES for graph in family(np.random.default_rng(seed))]


def test_graphs_keep_to_the_contract() -> None:
    for graph in some(family_graphs(range(10))):
        assert np.all(np.abs(graph.poses[:, 2]) <= math.pi)
        for i, j, z, omega in some(graph.edges):
            assert type(i) is type(j) is int
            assert abs(z[2]) <= math.pi
            a, b = omega[0, 0], omega[2, 2]
            np.testing.assert_array_equal(omega, np.diag([a, a, b]))


def test_some_pairs_are_measured_twice_and_some_the_other_way() -> None:
    for family in (asked.loops, asked.weighted):
        for seed in range(3):
            drawn = family(np.random.default_rng(seed))
            assert any(len({tuple(sorted(edge[:2])) for edge in graph.edges}) < len(graph.edges) for graph in drawn)


def test_gauss_newton_settles_early_on_every_graph() -> None:
    for graph in some(family_graphs(range(10))):
        assert graph.solution.converged
        assert graph.solution.iterations <= graphs.SLOW_STEPS
        assert judge(graph, graph.optimum) is None


def test_the_same_seed_gives_the_same_graphs_without_solving_them_again() -> None:
    one, other = (asked.loops(np.random.default_rng(3)) for _ in range(2))
    assert one is other


def test_headings_pass_the_half_turn_where_they_should() -> None:
    for seed in range(10):
        first, second, *_ = asked.turning(np.random.default_rng(seed))
        assert abs(first.poses[1, 2] + (first.optimum[1, 2] - first.poses[1, 2]) % (2 * math.pi)) > math.pi
        i, j, z, _ = second.edges[0]
        assert abs(second.poses[j, 2] - second.poses[i, 2] - z[2]) > math.pi
        for graph in some(asked.loops(np.random.default_rng(seed))):
            for i, j, z, _ in some(graph.edges):
                assert abs(graph.poses[j, 2] - graph.poses[i, 2] - z[2]) < math.pi


def test_simpler_graphs_are_sound_and_smaller() -> None:
    graph = asked.weighted(np.random.default_rng(1))[-1]
    candidates = list(simpler_graphs(graph))
    assert any(len(candidate.poses) < len(graph.poses) for candidate in candidates)
    for candidate in candidates:
        assert candidate.solution.converged
        assert len(candidate.edges) <= len(graph.edges)


def test_judgement_of_angles_and_of_the_first_pose() -> None:
    graph = asked.turning(np.random.default_rng(0))[0]
    turned = graph.optimum + np.array([[0, 0, 0], [0, 0, 2 * math.pi]])
    assert judge(graph, turned).slip == "angle_non_ramene"  # type: ignore[union-attr]
    moved = np.array([compose([0.01, 0, 0], pose) for pose in graph.optimum])
    assert "première pose" in judge(graph, moved).message  # type: ignore[union-attr]
    assert fingerprint(graph, moved) == fingerprint(graph, np.full((2, 3), np.nan)) == "perdu"


def test_poses_that_ran_away_are_told_as_such() -> None:
    """chi2 overflows there; nothing warns, and no infinite sum is shown."""
    graph = asked.loops(np.random.default_rng(0))[0]
    for size in (1e200, 1e308):
        far = np.vstack([graph.poses[:1], graph.poses[1:] + np.array([size, -size, 0.0])])
        assert "envolées" in judge(graph, far).message  # type: ignore[union-attr]


def test_error_cases_wrap_only_where_they_should() -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed)
        *drawn, a, b, c, d = residual.random_edges(rng)
        assert all(map(residual.stays, [*residual.simple_edges(rng), *drawn]))
        assert all(map(residual.wraps, [a, b, c, d, *residual.wrapping_edges(rng)]))


def test_three_iterations_are_never_enough_for_the_slow_graph() -> None:
    """Nor is a program that does three whatever it is asked."""
    for seed in range(6):
        slow = next(iter(asked.large(np.random.default_rng(seed))))
        assert slow.n_iter == 15
        few = pose_graph.gauss_newton(slow.model, slow.poses, max_iterations=graphs.FEW).poses
        assert judge(slow, few) is not None
