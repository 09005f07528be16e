"""Optimisation among false loop closures: reweighted least squares, and graduated non-convexity.

Only the `suspects` are doubted; by default those are the loop closures, as odometry is not mistaken about places.

Sources: kernels.py; Yang, Antonante, Tzoumas, Carlone, "Graduated Non-Convexity for Robust Spatial Perception" (RA-L
2020), truncated least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

from reference.pose_graph.errors import ParameterError, ShapeError
from reference.pose_graph.graph import BLOCK, Floats, PoseGraph, copy_checked_landmarks, copy_checked_poses
from reference.pose_graph.kernels import Kernel
from reference.pose_graph.normal_equations import LinearSystem
from reference.pose_graph.optimise import OptimisationProblem, Solution, StopLimits, run_gauss_newton

Mask = NDArray[np.bool_]

GROWTH = 1.4
INNER = StopLimits(iterations=10, step=1e-4, chi2=1e-5)


@dataclass(frozen=True)
class RobustSolution:
    """`solution`, whose chi2 is the robust cost; `weights` (m,): what each edge counted for; `rejected` (m,): which
    edges counted for less than a half."""

    solution: Solution
    weights: Floats

    @property
    def poses(self) -> Floats:
        return self.solution.poses

    @property
    def rejected(self) -> Mask:
        return np.asarray(self.weights < 0.5)


class _ReweightedProblem(OptimisationProblem):
    """A problem whose suspects go through a kernel."""

    def __init__(self, graph: PoseGraph, kernel: Kernel, suspects: Mask) -> None:
        super().__init__(graph, lambda u: np.where(suspects, kernel.weight(u), 1.0))
        self.kernel, self.suspects = kernel, suspects

    def cost(self, system: LinearSystem) -> float:
        u = system.edge_chi2
        return float(np.where(self.suspects, self.kernel.rho(u), u).sum() + system.sighting_chi2.sum())


def robust_gauss_newton(
    graph: PoseGraph,
    poses: ArrayLike,
    kernel: Kernel,
    landmarks: ArrayLike | None = None,
    *,
    suspects: Mask | None = None,
    max_iterations: int = 200,
    tolerance: float = 1e-6,
    chi2_tolerance: float = 1e-9,
) -> RobustSolution:
    """Minimise sum rho(chi2 of suspects) + chi2 of the others, by weights rho' renewed at each step of Gauss-Newton.

    `suspects` (m,): the edges that may be false, the loop closures unless given. Errors are those of `gauss_newton`.
    """
    problem = _ReweightedProblem(graph, kernel, _check_suspects(graph, suspects))
    start = problem.equations.join_state(copy_checked_poses(graph, poses), copy_checked_landmarks(graph, landmarks))
    solution = run_gauss_newton(problem, start, StopLimits(max_iterations, tolerance, chi2_tolerance))
    return _to_robust_solution(problem, solution)


def graduated_non_convexity(
    graph: PoseGraph,
    poses: ArrayLike,
    landmarks: ArrayLike | None = None,
    *,
    suspects: Mask | None = None,
    bound: float | None = None,
    max_rounds: int = 200,
) -> RobustSolution:
    """Minimise sum min(chi2, bound) over suspects + chi2 of the others, the truncation coming in slowly.

    With a control mu that starts near 0, where the cost is convex, and grows by 1.4 a round, an edge of chi2 u weighs
        w = 0 above (mu + 1)/mu bound, 1 below mu/(mu + 1) bound, sqrt(bound mu (mu + 1)/u) - mu between.   (15)
    It ends when every weight is 0 or 1. `bound`: the largest chi2 of a true edge, by default the quantile 0.99 of the
    chi2 law with 3 degrees of freedom; where the information understates how good the edges are, it must be smaller,
    or throwing out true edges costs less than believing them. `poses` and the rest are those of `robust_gauss_newton`;
    SingularSystemError when the edges that remain leave a node free.
    """
    doubted = _check_suspects(graph, suspects)
    # the 99 % quantile of the chi2 law with k degrees of freedom is 2 P^-1(k/2, 0.99), P of DLMF 8.2.4
    limit = 2.0 * float(gammaincinv(BLOCK / 2.0, 0.99)) if bound is None else bound
    if not 0.0 < limit < np.inf:
        raise ParameterError("bound", f"{limit} is not a positive number")
    weights = np.ones(len(graph.i))
    problem = OptimisationProblem(graph, lambda _: weights)
    state = problem.equations.join_state(copy_checked_poses(graph, poses), copy_checked_landmarks(graph, landmarks))
    found = run_gauss_newton(problem, state, INNER)
    mu = 0.0
    for _ in range(max_rounds):
        state = problem.equations.join_state(found.poses, found.landmarks)
        u = problem.linearise_at(state).edge_chi2
        largest = float(u[doubted].max(initial=0.0))
        if mu == 0.0:
            if 2.0 * largest <= limit:
                break
            mu = limit / (2.0 * largest - limit)
        weights = np.where(doubted, _truncated_weights(u, mu, limit), 1.0)
        found = run_gauss_newton(problem, state, INNER)
        if np.all((weights == 1.0) | (weights == 0.0)):
            break
        mu *= GROWTH
    last = run_gauss_newton(
        problem, problem.equations.join_state(found.poses, found.landmarks), StopLimits(50, 1e-9, 0.0)
    )
    return RobustSolution(replace(last, weights=weights), weights)


def _truncated_weights(u: Floats, mu: float, bound: float) -> Floats:
    """(15), for weights (m,) in [0, 1]."""
    between = np.sqrt(bound * mu * (mu + 1.0) / np.maximum(u, mu / (mu + 1.0) * bound)) - mu
    return np.where(u <= mu / (mu + 1.0) * bound, 1.0, np.where(u >= (mu + 1.0) / mu * bound, 0.0, between))


def _check_suspects(graph: PoseGraph, suspects: Mask | None) -> Mask:
    mask = graph.is_closure_mask if suspects is None else np.asarray(suspects, dtype=np.bool_)
    if mask.shape != graph.i.shape:
        raise ShapeError("suspects", f"have shape {mask.shape}, not {graph.i.shape}")
    return mask


def _to_robust_solution(problem: _ReweightedProblem, solution: Solution) -> RobustSolution:
    system = problem.linearise_at(problem.equations.join_state(solution.poses, solution.landmarks))
    weights = np.where(problem.suspects, problem.kernel.weight(system.edge_chi2), 1.0)
    return RobustSolution(replace(solution, weights=weights), weights)


def add_false_closures(graph: PoseGraph, count: int, rng: np.random.Generator) -> tuple[PoseGraph, Mask]:
    """The graph with `count` loop closures added that claim two random poses to be one, and which edges (m,) they are.

    They carry the information of an edge of the graph, drawn at random: nothing but the others gives them away.
    """
    if graph.n_poses < 3 or count < 0:
        raise ParameterError("count", "false closures need three poses, and a number of at least 0")
    i = rng.integers(0, graph.n_poses - 2, count)
    j = i + 2 + np.floor(rng.random(count) * (graph.n_poses - 2 - i)).astype(np.int64)
    noise = rng.normal(0.0, [0.3, 0.3, 0.1], (count, BLOCK))
    models = graph.information[rng.integers(0, len(graph.i), count)]
    added = replace(
        graph,
        i=np.concatenate([graph.i, i]),
        j=np.concatenate([graph.j, j]),
        z_i_j=np.concatenate([graph.z_i_j, noise]),
        information=np.concatenate([graph.information, models]),
    )
    return added, np.arange(len(added.i)) >= len(graph.i)
