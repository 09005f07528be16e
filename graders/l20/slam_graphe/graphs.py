"""Graphs that `gauss_newton` may be given, each with its optimum: their parts, and how they are drawn.

All are small and well conditioned. Plain Gauss-Newton settles on each of them to 1e-9 within `MAX_STEPS` iterations, to
1e-5 within five, whereas the functions have ten or more. One graph takes it a little longer, and fifteen are allowed:
there, three iterations are never enough. Information matrices are diag(a, a, b).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graders.core.contract.values import Floats, Value
from reference import pose_graph
from reference.pose_graph import PoseGraph
from reference.se2 import compose, relative, wrap_angle

QUARTER = math.pi / 2
EIGHTH = math.pi / 4
MAX_STEPS = 9

# The slow graph: three iterations leave a pose this far, and chi2 this much above the least: ten times what passes.
SLOW_STEPS = 11
FEW = 3
FAR_POSE = 1e-3
FAR_CHI2 = 2e-5
SLOW_DRAWS = 60

Edge = tuple[int, int, Floats, Floats]
Ends = Sequence[tuple[int, int]]
Pair = tuple[float, float]
Weights = Callable[[int], Pair]


@dataclass(frozen=True)
class Graph:
    """What `gauss_newton` is called with. `n_iter` None: it is left to its default.

    A graph that is not `judged` is only looked at, for a diagnosis.
    """

    poses: Floats
    edges: tuple[Edge, ...]
    n_iter: int | None = 10
    judged: bool = True

    @cached_property
    def inputs(self) -> dict[str, Value]:
        named = {"poses": self.poses, "aretes": list(self.edges)}
        return named if self.n_iter is None else {**named, "n_iter": self.n_iter}

    @cached_property
    def model(self) -> PoseGraph:
        return PoseGraph.from_edges(len(self.poses), self.edges)

    @cached_property
    def solution(self) -> pose_graph.Solution:
        """The optimum, the first pose held fixed."""
        return pose_graph.gauss_newton(self.model, self.poses, max_iterations=30)

    @property
    def optimum(self) -> Floats:
        return self.solution.poses

    def chi2(self, poses: Floats) -> float:
        return pose_graph.chi2(self.model, poses)

    def shares(self, poses: Floats) -> Floats:
        """The share (m,) of each edge in chi2."""
        return pose_graph.edge_chi2(self.model, poses)


def settles(graph: Graph) -> bool:
    """Does plain Gauss-Newton reach the optimum from the start, well before its last iteration?"""
    return graph.solution.converged and graph.solution.iterations <= MAX_STEPS


def edge(i: int, j: int, z: Sequence[float] | Floats, a: float = 1.0, b: float | None = None) -> Edge:
    """An edge with the information diag(a, a, b); b is a unless given."""
    return i, j, np.array(z, dtype=np.float64), np.diag([a, a, a if b is None else b])


def rows(*poses: Sequence[float]) -> Floats:
    return np.array(poses, dtype=np.float64)


def draw_settling(draw: Callable[[], Graph]) -> Graph:
    """The first graph drawn on which Gauss-Newton settles at ease."""
    return next(graph for graph in iter(draw, None) if settles(graph))


def slowness(graph: Graph) -> float:
    """How far from the optimum the first iterations leave the poses: at 1, farther than FAR_POSE and FAR_CHI2."""
    history = graph.solution.chi2
    if not graph.solution.converged or not FEW < graph.solution.iterations <= SLOW_STEPS:
        return 0.0
    excess = (history[FEW] / history[-1] - 1.0) / FAR_CHI2
    if excess < 1.0:
        return float(excess)
    poses = pose_graph.gauss_newton(graph.model, graph.poses, max_iterations=FEW).poses
    gap = poses - graph.optimum
    away = max(np.abs(gap[:, :2]).max(), np.abs(wrap_angle(gap[:, 2])).max())
    return float(min(excess, away / FAR_POSE))


def draw_slow(draw: Callable[[], Graph]) -> Graph:
    """The first graph drawn that is slow enough, about one in six; failing that, the slowest of many."""
    slowest, most = None, 0.0
    for _ in range(SLOW_DRAWS):
        graph = draw()
        score = slowness(graph)
        if score >= 1.0:
            return graph
        if score > most:
            slowest, most = graph, score
    return slowest or draw_settling(draw)


def along(n: int) -> list[tuple[int, int]]:
    """The ends of the edges of odometry."""
    return [(k, k + 1) for k in range(n - 1)]


def measure(
    rng: np.random.Generator,
    truth: Floats,
    ends: Ends,
    noise: tuple[float, float],
    weights: Sequence[tuple[float, float]],
) -> tuple[Edge, ...]:
    """Relative poses with a noise of (length, angle), in two decimals, each with a weight (a, b)."""
    sigma = np.array([noise[0], noise[0], noise[1]])
    edges = []
    for (i, j), (a, b) in zip(ends, weights, strict=True):
        z = np.round(relative(truth[i], truth[j]) + sigma * rng.normal(size=3).clip(-2, 2), 2)
        edges.append(edge(i, j, [z[0], z[1], wrap_angle(z[2])], a, b))
    return tuple(edges)


def odometry(first: Floats, edges: Sequence[Edge], n: int) -> Floats:
    """The poses that edges 0-1, 1-2, ... lead to, in two decimals but for the first."""
    poses = [first]
    for k in range(n - 1):
        poses.append(np.round(compose(poses[-1], edges[k][2]), 2))
    return np.array(poses)


def noisy(
    rng: np.random.Generator,
    truth: Floats,
    closures: Ends,
    *,
    noise: Pair = (0.2, 0.12),
    weights: Weights = lambda k: (1.0, 1.0),
    n_iter: int | None = 10,
    choose: Callable[[Callable[[], Graph]], Graph] = draw_settling,
) -> Graph:
    """A trajectory measured with noise and closed by `closures`, started from its odometry; edges in any order."""

    def draw() -> Graph:
        ends = [*along(len(truth)), *closures]
        edges = measure(rng, truth, ends, noise, [weights(k) for k in range(len(ends))])
        order = rng.permutation(len(edges))
        return Graph(odometry(truth[0], edges, len(truth)), tuple(edges[k] for k in order), n_iter)

    return choose(draw)


def facing_one_way(rng: np.random.Generator, n: int) -> Floats:
    """Poses (n, 3) about a polygon with any headings within 1.1 radian of the x axis: no angle wraps."""
    turn = math.tau * np.arange(n) / n
    centres = np.column_stack([1.5 * np.cos(turn), 1.5 * np.sin(turn)]) * n / 4
    poses = np.column_stack([centres + rng.uniform(-0.5, 0.5, (n, 2)), rng.uniform(-1.1, 1.1, n)])
    return np.asarray(np.round(poses, 1), dtype=np.float64)


def going_round(rng: np.random.Generator, n: int) -> Floats:
    """Poses (n, 3) of a robot that goes round once, facing where it goes, from any heading."""
    turn = math.tau * np.arange(n) / n + rng.uniform(-math.pi, math.pi)
    radius = 0.35 * n
    poses = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), wrap_angle(turn + QUARTER)])
    return np.asarray(np.round(poses, 1), dtype=np.float64)


def various(rng: np.random.Generator) -> Weights:
    """Weights (a, b), unlike from one edge to another."""
    return lambda k: (float(rng.choice([1, 4, 25])), float(rng.choice([2, 10, 50])))
