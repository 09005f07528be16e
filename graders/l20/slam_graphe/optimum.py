"""The check of `gauss_newton`: from the given poses, does it reach the optimum, the first pose held fixed?

Judged by where it ends, whatever the road: numeric or exact Jacobians, dense or sparse, rows removed or a prior on the
first pose, additive or composed steps all end within the tolerances below; the mistakes end farther by ten and more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection, planned_calls_of
from graders.core.code.drawable import to_drawable_array
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, Mismatch, shape_mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair, value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.slam_graphe.filming import STEPS, film
from graders.l20.slam_graphe.graphs import EIGHTH, QUARTER, Graph, settles
from graders.robotics.turned import tell_turn
from reference.pose_graph import DisconnectedGraphError
from reference.se2 import wrap_angle

FUNCTION = "gauss_newton"

# Forward differences with a step of 1e-4 end 8e-5 away, and 3e-5 away for the first pose under a prior of weight 1.
POSE_TOLERANCE = 1e-4
# A step of 1e-3 ends 7e-4 away, but 3e-7 above the least chi2: as good a map.
CHI2_TOLERANCE = 2e-6
SAME_VALLEY = 1e-2

LARGE = 8
LOST = "perdu"
FAR = 1e3
# A diagnosis compares numbers to 1e-7: divided by this, to 1e-5, so that numeric Jacobians agree with exact ones.
COARSENESS = 100.0


def gaps(wanted: Floats, got: Floats) -> Floats:
    """Differences (n, 3) between poses, angles modulo 2 pi."""
    difference = got - wanted
    return np.column_stack([difference[:, :2], wrap_angle(difference[:, 2])])


def judge(graph: Graph, got: Value) -> Mismatch | None:
    """What is wrong with the poses that came back, in French, or None."""
    try:
        poses = read_array(got)
    except UnreadableError as error:
        return unreadable(error)
    if poses.shape != graph.poses.shape:
        return shape_mismatch(graph.poses, poses)
    if not np.all(np.isfinite(poses)):
        return Mismatch("Le résultat contient « nan » ou l'infini.", "nan")
    return _first_pose(graph, poses) or _minimum(graph, poses) or _angles(poses)


def _first_pose(graph: Graph, poses: Floats) -> Mismatch | None:
    moved = np.abs(gaps(graph.poses[:1], poses[:1])).max()
    if moved <= POSE_TOLERANCE:
        return None
    return Mismatch(f"La première pose devait rester {render.text(graph.poses[0])} : elle a bougé.")


def _minimum(graph: Graph, poses: Floats) -> Mismatch | None:
    away = np.abs(gaps(graph.optimum, poses)).max(axis=1)
    worst = int(np.argmax(away))
    if away[worst] <= POSE_TOLERANCE:
        return None
    reached, least = graph.chi2(poses), graph.solution.chi2[-1]
    if away[worst] <= SAME_VALLEY and reached <= least * (1.0 + CHI2_TOLERANCE):
        return None
    if not np.isfinite(reached):
        far = render.number(float(np.abs(poses).max()), 3)
        return Mismatch(f"Les poses se sont envolées, jusqu'à {far} : χ² n'y est plus calculable.")
    if np.abs(gaps(graph.poses, poses)).max() <= TOLERANCE:
        return Mismatch(f"Ce sont les poses de départ, où χ² vaut {render.number(reached, 4)} : rien n'a bougé.")
    sums = "χ² y vaut {} ; au minimum, il vaut {}".format(*number_text_pair(reached, least, 4))
    lost = f"La pose {worst} est la plus loin de sa place : {render.number(float(away[worst]), 3)}."
    return Mismatch(f"{sums}. {lost}{tell_turn(graph.optimum[:, :2], poses[:, :2])}")


def _angles(poses: Floats) -> Mismatch | None:
    outside = np.flatnonzero(np.abs(poses[:, 2]) > np.pi + TOLERANCE)
    if not outside.size:
        return None
    theta = render.angle(float(poses[outside[0], 2]))
    return Mismatch(f"L'angle de la pose {outside[0]}, {theta}, sort de l'intervalle [−π, π].", "angle_non_ramene")


def half_way(graph: Graph, got: Value) -> bool:
    """Did a single step, which is not judged, win at least half of what there was to win?"""
    poses = to_drawable_array(got, graph.poses.shape)
    if poses is None or _first_pose(graph, poses):
        return False
    start, least = graph.chi2(graph.poses), graph.solution.chi2[-1]
    return graph.chi2(poses) <= (start + least) / 2.0


def fingerprint(graph: Graph, got: Value) -> Value:
    """What a diagnosis compares: coarse poses, or `LOST` for what rounding errors decide.

    A divergence magnifies the small differences between two programs that make the same mistake.
    """
    try:
        poses = read_array(got)
    except UnreadableError:
        return got
    if poses.shape != graph.poses.shape:
        return got
    at_origin = bool(np.all(np.abs(poses[0]) <= TOLERANCE))
    if not np.all(np.abs(poses) < FAR) or (_first_pose(graph, poses) and not at_origin):
        return LOST
    return LOST if diverged(graph, poses) else poses / COARSENESS


def diverged(graph: Graph, poses: Floats) -> bool:
    """After more than one step, is chi2 well above that of the start?"""
    return graph.n_iter != 1 and graph.chi2(poses) > 2.0 * graph.chi2(graph.poses) + 1e-3


@dataclass(frozen=True)
class Answered:
    """A graph that was asked for: what came back and why it is wrong (None: it is not), or the fault."""

    graph: Graph
    got: Value
    mismatch: Mismatch | None
    fault: StudentFault | None

    @property
    def failed(self) -> bool:
        return self.mismatch is not None or self.fault is not None


@dataclass(frozen=True, kw_only=True)
class Optimum(Check):
    """`gauss_newton` on every graph, simplest first; the simplest failing one is shown, shrunk."""

    graphs: Callable[[np.random.Generator], Sequence[Graph]]

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        graphs = self.graphs(bench.rng)
        return [PlannedCalls(FUNCTION, [tuple(graph.inputs.values()) for graph in graphs], context=graphs)]

    def run(self, bench: Bench) -> None:
        right: list[Answered] = []
        first: Answered | None = None
        graphs = planned_calls_of(self, bench)[0].context
        for graph in _brief(graphs) if bench.runner.reenacting else graphs:
            answer = answered(bench, graph)
            if answer.failed and graph.judged:
                first = first or answer
            elif graph.judged:
                right.append(answer)
            if answer.fault and _hopeless(answer.fault):
                break
        if bench.runner.reenacting:
            # Nobody reads what a re-enacted mistake finds: only its observations count.
            if first is not None:
                raise Rejection("")
        elif first is None:
            largest = max(right, key=lambda answer: len(answer.graph.edges))
            bench.record_film(film(largest.graph, largest.got, [], right=True))
        else:
            _reject(bench, first)


def _brief(graphs: Sequence[Graph]) -> Sequence[Graph]:
    """Without the last graph when it is a large one: a known mistake shows on the others, in half the time."""
    return graphs[:-1] if len(graphs[-1].poses) > LARGE else graphs


def _hopeless(fault: StudentFault) -> bool:
    return fault.fatal or fault.outcome is Outcome.MISSING_FUNCTION


def answered(bench: Bench, graph: Graph) -> Answered:
    """What one call on one graph gives, and how it fails if it does."""
    try:
        with np.errstate(all="ignore"):  # a mistake that diverges, run in this process for a diagnosis
            got = bench.call(FUNCTION, *graph.inputs.values())
    except StudentFault as fault:
        _observe_fault(bench, fault)
        return Answered(graph, None, None, fault)
    mismatch = judge(graph, got)
    right = mismatch is None if graph.judged else half_way(graph, got)
    bench.observe(FUNCTION, fingerprint(graph, got), ok=right)
    return Answered(graph, got, mismatch, None)


def _first_steps(bench: Bench, graph: Graph) -> list[Value]:
    """Where the first iterations lead, one more each time, as far as they give anything."""
    found: list[Value] = []
    try:
        for steps in STEPS:
            found.append(bench.call(FUNCTION, *replace(graph, n_iter=steps).inputs.values()))
    except StudentFault:
        return found
    return found


def _observe_fault(bench: Bench, fault: StudentFault) -> None:
    """A singular system raises or gives numbers made of rounding errors, by chance: both are the same finding."""
    if fault.exception == "LinAlgError":
        bench.observe(FUNCTION, LOST, ok=False)
    else:
        bench.observe(FUNCTION, None, ok=False, fault=fault)


def _reject(bench: Bench, failure: Answered) -> NoReturn:
    def judged(graph: Graph, answer: Answer) -> Answered | None:
        if isinstance(answer, StudentFault):
            simpler = Answered(graph, None, None, answer)
        else:
            simpler = Answered(graph, answer.value, judge(graph, answer.value), None)
        return simpler if simpler.failed and fails_alike(failure, simpler) else None

    def told(shown: Answered) -> Rejection:
        steps = [] if shown.fault else _first_steps(bench, shown.graph)
        bench.record_film(film(shown.graph, shown.got, steps, right=False))
        return rejection(shown)

    shrink_and_reject(
        bench, FUNCTION, failure, failure.graph, simpler_graphs, judged, told,
        arguments=lambda graph: tuple(graph.inputs.values()), costly=True,
        stops=lambda one: one.fault is not None and _hopeless(one.fault),
    )  # fmt: skip


def simpler_graphs(graph: Graph) -> Iterator[Graph]:
    """The graph without its last pose, without one edge, with all weights 1, with rounder numbers."""
    for candidate in _candidates(graph):
        try:
            sound = bool(candidate.edges) and settles(candidate)
        except DisconnectedGraphError:
            sound = False
        if sound:
            yield candidate


def _candidates(graph: Graph) -> Iterator[Graph]:
    last = len(graph.poses) - 1
    if last > 1:
        yield replace(graph, poses=graph.poses[:last], edges=tuple(e for e in graph.edges if last not in e[:2]))
    for k in range(len(graph.edges)):
        yield replace(graph, edges=graph.edges[:k] + graph.edges[k + 1 :])
    if any(np.any(omega != np.eye(3)) for _, _, _, omega in graph.edges):
        yield replace(graph, edges=tuple((i, j, z, np.eye(3)) for i, j, z, _ in graph.edges))
    for decimals in (0, 1):
        poses = rounded(graph.poses, decimals)
        edges = tuple((i, j, rounded(z, decimals), omega) for i, j, z, omega in graph.edges)
        if np.any(poses != graph.poses) or any(np.any(a[2] != b[2]) for a, b in zip(edges, graph.edges, strict=True)):
            yield replace(graph, poses=poses, edges=edges)


def rounded(poses: Floats, decimals: int) -> Floats:
    """Poses (..., 3) in fewer decimals; eighths of a turn stay what they are, no decimals makes quarters of a turn."""
    theta = poses[..., 2]
    eighths = np.round(theta / EIGHTH) * EIGHTH
    quarters = np.clip(np.round(theta / QUARTER), -1, 2) * QUARTER
    angles = np.where(np.isclose(theta, eighths), theta, np.round(theta, decimals) if decimals else quarters)
    return np.concatenate([np.round(poses[..., :2], decimals), angles[..., None]], axis=-1)


def rejection(failure: Answered) -> Rejection:
    """The finding in words, with the graph, its optimum and what came back."""
    graph = failure.graph
    expected = np.where(np.abs(graph.optimum) < TOLERANCE, 0.0, graph.optimum)
    if failure.fault:
        return fault_rejection(failure.fault, inputs=graph.inputs, expected=expected)
    assert failure.mismatch is not None
    iterations = "sans donner n_iter" if graph.n_iter is None else f"avec n_iter = {graph.n_iter}"
    wanted, got = value_text_pair(expected, failure.got, digits=4)
    answer = (
        f"on attend {wanted} et {FUNCTION} renvoie {got}"
        if len(expected) <= 4
        else f"{FUNCTION} ne renvoie pas le bon résultat"
    )
    return Rejection(
        f"Pour {described(graph)}, {iterations}, {answer}. {failure.mismatch.message}",
        inputs=graph.inputs,
        expected=expected,
        got=failure.got,
        slip=failure.mismatch.slip,
        cause=failure.mismatch.cause,
        figure=graph_figure(graph, failure.got),
    )


def described(graph: Graph) -> str:
    """A small graph in full, a larger one by its size."""
    if len(graph.edges) > 4:
        return f"un graphe de {len(graph.poses)} poses et {len(graph.edges)} arêtes"
    edges = " ; ".join(_edge_text(*edge) for edge in graph.edges)
    return f"les poses {render.text(graph.poses)} et les arêtes {edges}"


def _edge_text(i: int, j: int, z: Floats, omega: Floats) -> str:
    a, b = omega[0, 0], omega[2, 2]
    numbers = " ; ".join(render.number(float(w)) for w in (a, a, b))
    weight = "" if a == b == 1.0 else f" de poids diag({numbers})"
    return f"{i} → {j} mesurée {render.text(z)}{weight}"


def graph_figure(graph: Graph, got: Value) -> FigureData:
    """The graph before and after, and what remains of each edge's error: the square root of its share in chi2."""
    poses = to_drawable_array(got, graph.poses.shape)
    return {
        "kind": "graph",
        "start": graph.poses.tolist(),
        "ends": [[i, j] for i, j, _, _ in graph.edges],
        "expected": graph.optimum.tolist(),
        "got": None if poses is None else poses.tolist(),
        "errors_expected": np.sqrt(graph.shares(graph.optimum)).tolist(),
        "errors_got": None if poses is None else np.sqrt(graph.shares(poses)).tolist(),
    }
