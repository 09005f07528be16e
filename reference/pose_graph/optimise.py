"""Least squares on a pose graph: Gauss-Newton, and Levenberg-Marquardt with the gain ratio.

Sources: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010), algorithm 1; Madsen, Nielsen,
Tingleff, "Methods for Non-Linear Least Squares Problems" (2004), algorithm 3.16 and equations 3.13 to 3.15.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from reference.pose_graph.errors import ParameterError, SingularSystemError
from reference.pose_graph.factor import Factorisation, factorise, is_positive_definite
from reference.pose_graph.graph import POINT, Floats, PoseGraph, copy_checked_landmarks, copy_checked_poses
from reference.pose_graph.normal_equations import LinearSystem, NormalEquations, Weights
from reference.se2 import wrap_angle

STEP_TOLERANCE = 1e-9
# Of the largest diagonal entry of H. GTSAM begins at 1e-5 as it is, which on the published sets, whose largest entries
# are 8e4 and more, is 1e-10 and less; a thousand times as much leaves ringCity and city10000 in local minima.
FIRST_DAMPING = 1e-8
MOST_DAMPING = 1e16
ROUNDING = 1e-14


class StopReason(StrEnum):
    """Why an optimisation ended."""

    SMALL_STEP = "the last step was below the tolerance"
    SMALL_DECREASE = "chi2 has no more to lose than its tolerance, or than rounding"
    ITERATIONS = "the iterations were used up"
    NOT_FINITE = "the numbers left the finite ones"
    NO_DECREASE = "no damping gives a decrease"
    NOTHING_FREE = "every node is fixed"


@dataclass(frozen=True)
class Gauge:
    """What held the frame, and what was left to find.

    `rank` is that of H: all of the `unknowns`, as connected poses with full information always have it; with landmarks,
    partial information or robust weights the pivots of the first factor are looked at, and less is a
    SingularSystemError.
    """

    fixed: tuple[int, ...]
    unknowns: int
    rank: int


@dataclass(frozen=True)
class Solution:
    """How an optimisation ended. `chi2` holds its value at the start and after each of the `iterations` steps.

    `poses` (n, 3), angles in ]-pi, pi]; `landmarks` (l, 2). `converged`: a tolerance was met, as `reason` says.
    `damping`: that of each step of Levenberg-Marquardt. `weights` (m,): what each edge counted for at the end.
    """

    poses: Floats
    chi2: tuple[float, ...]
    converged: bool
    reason: StopReason
    gauge: Gauge
    landmarks: Floats = field(default_factory=lambda: np.zeros((0, POINT)))
    damping: tuple[float, ...] = ()
    weights: Floats | None = None

    @property
    def iterations(self) -> int:
        return len(self.chi2) - 1


@dataclass(frozen=True)
class StopLimits:
    """When to stop: `step` bounds the largest component of a step, `chi2` the relative decrease of chi2."""

    iterations: int
    step: float
    chi2: float

    def __post_init__(self) -> None:
        if self.iterations < 0:
            raise ParameterError("max_iterations", "is negative")
        if not (self.step >= 0.0 and self.chi2 >= 0.0):
            raise ParameterError("tolerance", "is not a positive number")

    def reason_to_stop(self, step: Floats, system: LinearSystem, before: float, after: float) -> StopReason | None:
        """The reason to stop after a step that brought chi2 from `before`, where `system` was solved, to `after`.

        The decrease that the step promised is -b' step.
        """
        longest = float(np.abs(step).max())  # not finite where some component is not
        if not (math.isfinite(after) and math.isfinite(longest)):
            return StopReason.NOT_FINITE
        if longest < self.step:
            return StopReason.SMALL_STEP
        if abs(before - after) < self.chi2 * after or abs(system.b @ step) < ROUNDING * before:
            return StopReason.SMALL_DECREASE
        return None


class OptimisationProblem:
    """A graph under optimisation: its normal equations, and a factor that keeps what the pattern decides."""

    def __init__(self, graph: PoseGraph, weights: Weights | None = None) -> None:
        self.graph, self.weights = graph, weights
        self.equations = NormalEquations(graph)
        self._factor: Factorisation | None = None

    def linearise_at(self, state: Floats) -> LinearSystem:
        return self.equations.assemble(state, self.weights)

    def cost(self, system: LinearSystem) -> float:
        """What the search reports: chi2, every edge in full."""
        return system.chi2

    def solve_step(self, system: LinearSystem, damping: float = 0.0) -> Floats:
        """The step (s,): (H + damping I) step = -b. Raises SingularSystemError."""
        data = system.upper_entries
        if damping:
            data = data.copy()
            data[self.equations.pattern.starts[1:] - 1] += damping
        if self._factor is None:
            upper = self.equations.pattern.upper_triangle(data)
            self._factor = factorise(upper)
            if not self.is_surely_regular and not is_positive_definite(upper, self._factor.lower()):
                raise SingularSystemError("the normal equations are singular: some unknown is free")
        else:
            self._factor.update(data)
        return -self._factor.solve(system.b)

    @property
    def is_surely_regular(self) -> bool:
        """Connected poses and full information make H positive definite; all else needs a look."""
        return not self.graph.n_landmarks and self.weights is None and self.graph.is_fully_informed

    def make_solution(self, state: Floats, history: list[float], reason: StopReason, **more: object) -> Solution:
        poses, landmarks = self.equations.split_state(state)
        poses[:, 2] = wrap_angle(poses[:, 2])
        size = self.equations.pattern.size
        gauge = Gauge(self.graph.fixed, size, size)
        met = reason in (StopReason.SMALL_STEP, StopReason.SMALL_DECREASE, StopReason.NOTHING_FREE)
        return Solution(poses, tuple(history), met, reason, gauge, landmarks, **more)  # type: ignore[arg-type]


def gauss_newton(
    graph: PoseGraph,
    poses: ArrayLike,
    landmarks: ArrayLike | None = None,
    *,
    max_iterations: int = 50,
    tolerance: float = STEP_TOLERANCE,
    chi2_tolerance: float = 0.0,
) -> Solution:
    """Minimise chi2 from `poses` (n, 3) and `landmarks` (l, 2), the graph's fixed poses held.

    Converged: the largest component of the last step was below `tolerance`, or chi2 changed by less than
    `chi2_tolerance`, relatively, or the step promised a decrease below rounding. An
    iteration that leaves the finite numbers ends the search, not converged. Raises a
    PoseGraphError for a start that does not fit the graph, SingularSystemError when something is not determined.
    """
    limits = StopLimits(max_iterations, tolerance, chi2_tolerance)
    problem = OptimisationProblem(graph)
    state = problem.equations.join_state(copy_checked_poses(graph, poses), copy_checked_landmarks(graph, landmarks))
    return run_gauss_newton(problem, state, limits)


def run_gauss_newton(problem: OptimisationProblem, state: Floats, limits: StopLimits) -> Solution:
    """Steps of Gauss-Newton from a state, until a limit is reached."""
    system = problem.linearise_at(state)
    history = [problem.cost(system)]
    if not problem.equations.pattern.size:
        return problem.make_solution(state, history, StopReason.NOTHING_FREE)
    for _ in range(limits.iterations):
        before, step = system, problem.solve_step(system)
        state = problem.equations.apply_step(state, step)
        system = problem.linearise_at(state)
        history.append(problem.cost(system))
        reason = limits.reason_to_stop(step, before, *history[-2:])
        if reason is not None:
            return problem.make_solution(state, history, reason)
    return problem.make_solution(state, history, StopReason.ITERATIONS)


def levenberg_marquardt(
    graph: PoseGraph,
    poses: ArrayLike,
    landmarks: ArrayLike | None = None,
    *,
    max_iterations: int = 100,
    tolerance: float = STEP_TOLERANCE,
    chi2_tolerance: float = 0.0,
    first_damping: float = FIRST_DAMPING,
) -> Solution:
    """Minimise chi2 by damped steps, (H + mu I) step = -b, each of which decreases it.

    The gain ratio compares the decrease with the one that the linear model promised,
        rho = (chi2(x) - chi2(x + h)) / (h' (mu h - b)),                                                  (9)
    and rules the damping: a step is taken when rho > 0, with mu <- mu max(1/3, 1 - (2 rho - 1)^3); otherwise mu grows
    by 2, then 4, 8... `first_damping` is relative to the largest diagonal entry of H. Arguments, results and errors are
    those of `gauss_newton`; chi2 lists accepted steps.
    """
    limits = StopLimits(max_iterations, tolerance, chi2_tolerance)
    problem = OptimisationProblem(graph)
    state = problem.equations.join_state(copy_checked_poses(graph, poses), copy_checked_landmarks(graph, landmarks))
    system = problem.linearise_at(state)
    history, dampings = [system.chi2], []
    if not problem.equations.pattern.size:
        return problem.make_solution(state, history, StopReason.NOTHING_FREE)
    damping, growth = first_damping * float(system.upper_entries[problem.equations.pattern.starts[1:] - 1].max()), 2.0
    reason = None
    while reason is None and len(history) <= max_iterations:
        step = problem.solve_step(system, damping)
        there = problem.equations.apply_step(state, step)
        trial = problem.linearise_at(there)
        gain = (system.chi2 - trial.chi2) / float(step @ (damping * step - system.b))
        if gain > 0.0:
            reason = limits.reason_to_stop(step, system, system.chi2, trial.chi2)
            state, system = there, trial
            history.append(system.chi2)
            dampings.append(damping)
            damping, growth = damping * max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3), 2.0
        elif np.max(np.abs(step)) < tolerance:
            reason = StopReason.SMALL_STEP
        else:
            damping, growth = damping * growth, 2.0 * growth
            reason = StopReason.NO_DECREASE if damping > MOST_DAMPING else None
    return problem.make_solution(state, history, reason or StopReason.ITERATIONS, damping=tuple(dampings))
