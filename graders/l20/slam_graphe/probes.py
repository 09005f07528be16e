"""What `erreur` and `gauss_newton` are asked by hand: any edges; then one step, and all of them, on small graphs."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from graders.core.code.probes import (
    ProbeResults,
    Probes,
    ProgramTrial,
    experiment_rule,
    measurement_rule,
    to_finite_array,
    undo_rule,
)
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.poses.probes import only_angle, only_position, only_turns, position
from graders.l20.poses.probes import read as read_three
from graders.l20.slam_graphe.graphs import Edge, Graph, edge, rows
from graders.l20.slam_graphe.optimum import COARSENESS, FAR, LOST, diverged, gaps
from graders.robotics.turned import is_detached_from_first
from reference.se2 import relative, wrap_angle

TRIPLES = (
    ((1.3, -2.1, 0.6), (2.7, 0.4, -0.8), (1.2, 0.7, 0.4)),
    ((-3.2, 1.4, -2.3), (1.1, 2.6, -1.2), (0.3, -1.9, 1.5)),
    ((0.5, 0.7, 2.9), (-1.6, 2.2, -2.6), (2.1, 0.2, 0.9)),
    ((4.1, -0.3, -2.8), (0.9, -1.7, 2.7), (-0.8, 0.5, -1.1)),
    ((2.2, 3.1, -0.3), (-1.4, -0.6, 2.4), (1.0, 1.4, -2.1)),
    ((-1.7, 0.8, 0.4), (2.3, 3.6, -2.2), (0.6, -2.2, 2.3)),
    ((0.0, 0.0, 0.0), (3.0, 1.0, 0.0), (2.0, 0.0, 0.0)),
)
EDGES: tuple[Arguments, ...] = tuple(tuple(np.array(pose) for pose in triple) for triple in TRIPLES)

TRUTH = rows((1.0, 2.0, 0.3), (3.1, 2.4, 0.9), (3.6, 4.5, -0.7), (1.2, 4.2, -1.1))
START = TRUTH + rows((0, 0, 0), (0.3, -0.2, 0.1), (-0.2, 0.4, -0.15), (0.4, 0.1, 0.2))
ROUND = rows((0.5, -1.0, 2.6), (-1.4, 0.1, -3.05), (-1.0, -1.9, -1.3), (0.9, -2.2, 1.2))
NOISE = rows((0.1, -0.05, 0.06), (-0.08, 0.12, -0.05), (0.06, 0.07, 0.04), (-0.12, 0.05, -0.07), (0.07, -0.1, 0.05))


def _edges(truth: Floats, ends: tuple[tuple[int, int], ...], weights: tuple[tuple[float, float], ...]) -> list[Edge]:
    """Measurements of these pairs, each with its own error and its own weights."""
    made = []
    for k, ((i, j), (a, b)) in enumerate(zip(ends, weights, strict=True)):
        z = relative(truth[i], truth[j]) + NOISE[k]
        made.append(edge(i, j, (z[0], z[1], float(wrap_angle(z[2]))), a, b))
    return made


ENDS = ((0, 1), (1, 2), (2, 3), (3, 0), (2, 0))
WEIGHTS = ((4.0, 10.0), (1.0, 2.0), (9.0, 30.0), (2.0, 5.0), (6.0, 3.0))
LOOP = _edges(TRUTH, ENDS, WEIGHTS)
TURNING = _edges(ROUND, ENDS, WEIGHTS)
TWICE = [*LOOP[:4], edge(0, 1, relative(TRUTH[0], TRUTH[1]) - (0.2, -0.3, 0.1), 5.0, 7.0)]
AROUND = ROUND + rows((0, 0, 0), (0.2, -0.1, -0.3), (-0.1, 0.2, 0.2), (0.1, 0.1, 0.1))
AROUND[:, 2] = wrap_angle(AROUND[:, 2])
CHAIN = [edge(0, 1, (2.0, 0.5, 0.4)), edge(1, 2, (1.0, -0.3, 0.7))]
TRIANGLE = [LOOP[0], LOOP[1], LOOP[4]]
GRAPHS = (
    Graph(START[:3], tuple(TRIANGLE), 1, judged=False),
    Graph(START, tuple(LOOP), 1, judged=False),
    Graph(AROUND, tuple(TURNING), 1, judged=False),
    Graph(START, tuple(LOOP), 2, judged=False),
    Graph(START, tuple(TWICE), 1, judged=False),
    Graph(START, tuple(LOOP)),
    Graph(AROUND, tuple(TURNING)),
    Graph(START[:3], tuple(CHAIN)),
    Graph(START, tuple(TWICE)),
    Graph(START, tuple(LOOP), None),
)
STEPS, ENDED = range(5), range(5, 10)
PLAIN, WRAPPING, DOUBLED = 5, 6, 8


def read(args: Arguments, value: Value) -> Value:
    """The poses, coarse: a numeric Jacobian gives nearly the same ones; in words what is none, or is lost.

    A divergence magnifies what rounds otherwise from one version of numpy to the next.
    """
    try:
        poses = read_array(value)
    except UnreadableError as error:
        return str(error)
    if poses.shape != args[0].shape:
        return f"forme {poses.shape}"
    lost = not np.all(np.abs(poses) < FAR) or diverged(_asked(args), poses)
    return LOST if lost else poses / COARSENESS


def _asked(args: Arguments) -> Graph:
    poses, edges, *n_iter = args
    return Graph(poses, tuple(edges), n_iter[0] if n_iter else None)


def _poses(shown: ProbeResults, k: int) -> Floats | None:
    found = to_finite_array(shown.got[k])
    return None if found is None else found * COARSENESS


def _reached(poses: Floats | None, graph: Graph) -> bool:
    return poses is not None and _gap(graph, poses) < 1e-3


@measurement_rule
def singular(shown: ProbeResults) -> str | None:
    """The first pose goes along, wherever the system has a solution; elsewhere it has none, or any, far away.

    Poses that run away alone tell nothing, nor do systems none of which can be solved: a wrong sign has the first do
    so, a derivative that is zero the second, whatever is held.
    """
    moved = [_first_moved(shown, k, columns=2) for k in range(len(GRAPHS))]
    unsolved = [isinstance(one, str) and one == LOST for one in shown.got]
    drawn = any(unsolved) or any(moved[k] and _is_lost(shown, k) for k in STEPS)
    astray = all(left or gone for left, gone in zip(moved, unsolved, strict=True))
    return "jauge_libre" if astray and any(moved) and drawn else None


def _first_moved(shown: ProbeResults, k: int, columns: int = 3) -> bool:
    poses = _poses(shown, k)
    return poses is not None and float(np.abs(gaps(GRAPHS[k].poses[:1], poses[:1])[:, :columns]).max()) > 1e-2


@measurement_rule
def at_the_origin(shown: ProbeResults) -> str | None:
    """The first pose ends at (0, 0, 0), wherever it was given."""
    found = [_poses(shown, k) for k in range(len(GRAPHS))]
    there = [poses is not None and bool(np.all(np.abs(poses[0]) < 1e-6)) for poses in found]
    return "premiere_pose_a_l_origine" if sum(there) >= len(there) - 3 else None


@measurement_rule
def first_moves(shown: ProbeResults) -> str | None:
    """The first pose is not where it was given."""
    moved = [_first_moved(shown, k) for k in range(len(GRAPHS))]
    return "premiere_pose_bouge" if sum(moved) >= len(moved) - 2 else None


@measurement_rule
def detached(shown: ProbeResults) -> str | None:
    """The optimum, moved as a whole, but for the first pose, which is where it was given."""
    found = [(GRAPHS[k].optimum, _poses(shown, k)) for k in (PLAIN, WRAPPING, DOUBLED)]
    apart = [poses is not None and is_detached_from_first(optimum, poses) for optimum, poses in found]
    return "carte_detachee" if all(apart) else None


@measurement_rule
def never_moves(shown: ProbeResults) -> str | None:
    found = [(_poses(shown, k), GRAPHS[k]) for k in range(len(GRAPHS))]
    still = [p is not None and float(np.abs(gaps(g.poses, p)).max()) < 1e-6 for p, g in found]
    return "poses_de_depart" if all(still) else None


@measurement_rule
def turns_only(shown: ProbeResults) -> str | None:
    """The optimum, with headings out of the interval."""
    found = [_poses(shown, k) for k in ENDED]
    out = [p is not None and float(np.abs(p[:, 2]).max()) > math.pi + 1e-6 for p in found]
    return "angles_jamais_ramenes" if any(out) and all(map(_reached, found, [GRAPHS[k] for k in ENDED])) else None


@measurement_rule
def weights_ignored(shown: ProbeResults) -> str | None:
    """What is reached is the optimum of equal weights."""
    equal = [
        Graph(g.poses, tuple((i, j, z, np.eye(3)) for i, j, z, _ in g.edges)) for g in (GRAPHS[PLAIN], GRAPHS[WRAPPING])
    ]
    found = [_poses(shown, PLAIN), _poses(shown, WRAPPING)]
    return "omega_ignoree" if all(map(_reached, found, equal)) else None


#: What may stand in the place of the weight of an edge, (3, 3).
MISUSES: tuple[Callable[[Floats], Floats], ...] = (
    lambda omega: omega**2,
    lambda omega: omega**0.5,
    lambda omega: np.asarray(np.linalg.inv(omega), dtype=float),
    lambda omega: omega[0, 0] * np.eye(3),
)


@measurement_rule
def weights_misused(shown: ProbeResults) -> str | None:
    """What is reached is the optimum of other weights: the squares, the roots, the inverses, or one number an edge."""
    found, graphs = [_poses(shown, PLAIN), _poses(shown, WRAPPING)], [GRAPHS[PLAIN], GRAPHS[WRAPPING]]
    if any(map(_reached, found, graphs)):
        return None
    for change in MISUSES:
        changed = [Graph(g.poses, tuple((i, j, z, change(omega)) for i, j, z, omega in g.edges)) for g in graphs]
        if all(map(_reached, found, changed)):
            return "omega_mal_employee"
    return None


def goes_on_from_its_end(trial: ProgramTrial) -> bool:
    """Asked again from where it ended, the program comes nearer to each optimum: it had stopped before it.

    One that has converged to something else stays there.
    """
    shown = trial.ask_probes()
    if len(shown.got) < len(shown.calls):
        return False
    ends = [_poses(shown, k) for k in (PLAIN, WRAPPING, DOUBLED)]
    graphs = [GRAPHS[k] for k in (PLAIN, WRAPPING, DOUBLED)]
    calls = [(end, *shown.calls[k][1:]) for end, k in zip(ends, (PLAIN, WRAPPING, DOUBLED), strict=True)]
    if any(end is None for end in ends):
        return False
    again = [to_finite_array(answer) for answer in trial.ask(calls)]
    if len(again) < len(calls):
        return False
    return all(
        after is not None and end is not None and _gap(graph, after * COARSENESS) < 0.7 * _gap(graph, end)
        for graph, end, after in zip(graphs, ends, again, strict=True)
    )


def _gap(graph: Graph, poses: Floats) -> float:
    return float(np.abs(gaps(graph.optimum, poses)).max())


@experiment_rule(goes_on_from_its_end)
def one_step_only(shown: ProbeResults) -> str | None:
    """Ten iterations give what one gives."""
    pairs = [(_poses(shown, k), _poses(shown, one)) for k, one in ((PLAIN, 1), (WRAPPING, 2), (DOUBLED, 4))]
    same = [a is not None and b is not None and np.allclose(a, b, atol=1e-6) for a, b in pairs]
    moved = first_moves(shown) is None and never_moves(shown) is None
    return "une_seule_iteration" if all(same) and moved and not _reached(pairs[0][0], GRAPHS[PLAIN]) else None


def _missed(shown: ProbeResults) -> set[int]:
    """The graphs that are not at their optimum in the end."""
    return {k for k in ENDED if not _reached(_poses(shown, k), GRAPHS[k])}


@measurement_rule
def one_of_a_pair(shown: ProbeResults) -> str | None:
    """Where a pair is measured twice, what is reached is the optimum with one of the two measurements."""
    single = [Graph(START, tuple(edge for edge in TWICE if edge is not left)) for left in (TWICE[0], TWICE[-1])]
    reached = any(_reached(_poses(shown, DOUBLED), graph) for graph in single)
    return "aretes_par_paire" if reached and _missed(shown) == {DOUBLED} else None


@undo_rule
def wraps_badly(shown: ProbeResults) -> str | None:
    """Where headings pass the half turn, and only there, neither the first step nor the end is right."""
    first = [k for k in shown.wrong_indices() if k in STEPS]
    return "erreur_non_ramenee_dans_gn" if first == [2] and _missed(shown) == {WRAPPING} else None


@measurement_rule
def elsewhere(shown: ProbeResults) -> str | None:
    """It ends near the optimum, though not there."""
    poses = [_poses(shown, k) for k in (PLAIN, WRAPPING)]
    near = [
        p is not None and float(np.abs(gaps(GRAPHS[k].optimum, p)).max()) < 2.0
        for p, k in zip(poses, (PLAIN, WRAPPING), strict=True)
    ]
    missed = not any(map(_reached, poses, (GRAPHS[PLAIN], GRAPHS[WRAPPING])))
    return "pas_le_minimum" if all(near) and missed else None


@measurement_rule
def runs_away(shown: ProbeResults) -> str | None:
    """From a start near the optimum, it ends far from it, and the first steps lead away: they are not all unsolved."""
    steps = [(_poses(shown, k), GRAPHS[k]) for k in STEPS]
    worse = any(poses is not None and graph.chi2(poses) > graph.chi2(graph.poses) for poses, graph in steps)
    return "diverge" if worse and all(_is_lost(shown, k) for k in (PLAIN, WRAPPING, DOUBLED)) else None


def _is_lost(shown: ProbeResults, k: int) -> bool:
    poses = _poses(shown, k)
    if poses is None:
        return isinstance(shown.got[k], str) and shown.got[k] == LOST
    return float(np.abs(gaps(GRAPHS[k].optimum, poses)[:, :2]).max()) > 2.0


PROBES = (
    Probes(
        function="erreur",
        calls=EDGES,
        unique=False,
        kit=world.STILL,
        read=read_three,
        facet=position,
        rules=(only_turns, only_angle("erreur_angle"), only_position("erreur_position")),
    ),
    Probes(
        function="gauss_newton",
        calls=tuple(tuple(graph.inputs.values()) for graph in GRAPHS),
        unique=False,
        kit=world.STILL,
        read=read,
        faults={"LinAlgError": LOST},
        rules=(
            never_moves,
            at_the_origin,
            singular,
            first_moves,
            turns_only,
            detached,
            weights_ignored,
            weights_misused,
            one_step_only,
            one_of_a_pair,
            wraps_badly,
            elsewhere,
            runs_away,
        ),
    ),
)
