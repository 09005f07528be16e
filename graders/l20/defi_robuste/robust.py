"""The check of `gauss_newton_robuste`: is the map near the truth again, and is every false edge given up?

Judged by where it ends, whatever the kernel: positions against the truth beside those of plain least squares, and the
weights that are told. That of a false edge is small, and smaller than those of most true ones, which need not be large.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, Mismatch, shape_mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.defi_robuste.graphs import DELTA, RATIO, WEIGHT, Robust
from graders.l20.slam_graphe.optimum import COARSENESS, FAR, LOST, gaps

FUNCTION = "gauss_newton_robuste"
#: A prior on the first pose, however weak, holds it better.
HELD = 1e-2
#: Every robust program that was measured moves some pose by twenty times as much at least.
STILL = 5e-3
#: Weights are compared with 0 and 1 to this.
ROUNDING = 1e-6
#: A film shows the program stopped after so many iterations.
STOPS = (1, 2, 5)


@dataclass(frozen=True)
class Found:
    """The poses (n, 3) and the weights (m,) that came back."""

    poses: Floats
    weights: Floats


def read_answer(one: Robust, got: Value) -> Found | Mismatch:
    """What came back, or what keeps it from being read."""
    if not isinstance(got, tuple | list) or len(got) != 2:
        message = f"{FUNCTION} doit renvoyer deux choses, les poses et les poids : « return poses, poids »."
        return Mismatch(message, cause=Outcome.INVALID_OUTPUT)
    try:
        poses, weights = read_array(got[0]), read_array(got[1])
    except UnreadableError as error:
        return unreadable(error)
    count = len(one.edges)
    if weights.shape in ((count, 1), (1, count)):
        weights = weights.ravel()
    for name, array, like in (("Poses", poses, one.poses), ("Poids", weights, np.zeros(count))):
        if array.shape != like.shape:
            wrong = shape_mismatch(like, array)
            return Mismatch(f"{name} : {wrong.message}", wrong.slip, wrong.cause)
        if not np.all(np.isfinite(array)):
            return Mismatch(f"{name} : le résultat contient « nan » ou l'infini.", "nan")
    return Found(poses, weights)


def judge(one: Robust, got: Value) -> Mismatch | None:
    """What is wrong with the map and the weights that came back, in French, or None."""
    found = read_answer(one, got)
    if isinstance(found, Mismatch):
        return found
    return _first_pose(one, found) or _map(one, found) or _angles(found) or _weights(one, found)


def _first_pose(one: Robust, found: Found) -> Mismatch | None:
    if np.abs(gaps(one.poses[:1], found.poses[:1])).max() <= HELD:
        return None
    return Mismatch(f"La première pose devait rester {render.text(one.poses[0], digits=4)} : elle a bougé.")


def _map(one: Robust, found: Found) -> Mismatch | None:
    moved = float(np.abs(gaps(one.poses, found.poses))[:, :2].max())
    if moved <= STILL:
        return Mismatch(
            "Ce sont les poses de départ, celles de l'odométrie seule : rien n'a bougé, ou bien toutes les fermetures "
            "de boucle ont été rejetées, les vraies avec les fausses."
        )
    with np.errstate(over="ignore", invalid="ignore"):
        ratio = one.ratio(found.poses)
    if ratio < RATIO:
        return None
    plain, reached = number_text_pair(one.error(one.plain), one.error(found.poses), 3)
    best = render.number(one.error(one.without_false), 3)
    return Mismatch(
        f"L'écart quadratique moyen à la vérité est de {reached}. Les moindres carrés ordinaires, que la fausse arête "
        f"tord, donnent {plain} ; sans elle, on aurait {best}. Il faut descendre sous 0,4 × {plain}."
    )


def _angles(found: Found) -> Mismatch | None:
    outside = np.flatnonzero(np.abs(found.poses[:, 2]) > np.pi + TOLERANCE)
    if not outside.size:
        return None
    theta = render.angle(float(found.poses[outside[0], 2]))
    return Mismatch(f"L'angle de la pose {outside[0]}, {theta}, sort de l'intervalle [−π, π].", "angle_non_ramene")


def _weights(one: Robust, found: Found) -> Mismatch | None:
    weights = found.weights
    outside = np.flatnonzero((weights < -ROUNDING) | (weights > 1.0 + ROUNDING))
    if outside.size:
        return Mismatch(
            f"La carte est bonne, mais le poids de {_edge(one, int(outside[0]))} vaut "
            f"{render.number(float(weights[outside[0]]), 4)} : il sort de l'intervalle [0, 1]."
        )
    usual = float(np.median(weights[~one.false]))
    for k in np.flatnonzero(one.false):
        weight = float(weights[k])
        where = f"la fausse arête, {_edge(one, int(k))}, a pour poids {render.number(weight, 3)}"
        if weight >= WEIGHT:
            return Mismatch(f"La carte est bonne, mais {where} : on attend moins de 0,1.")
        if weight >= usual:
            return Mismatch(f"La carte est bonne, mais {where}, et la moitié des vraies n'ont pas plus.")
    return None


def _edge(one: Robust, k: int) -> str:
    return f"l'arête numéro {k} ({one.edges[k][0]} → {one.edges[k][1]})"


@dataclass(frozen=True, kw_only=True)
class Robustness(Check):
    """`gauss_newton_robuste` on every graph. What fails is filmed; where `filmed`, the first graph in any case."""

    graphs: Callable[[np.random.Generator], Sequence[Robust]]
    filmed: bool = False

    def run(self, bench: Bench) -> None:
        rejected: Rejection | None = None
        for k, one in enumerate(self.graphs(bench.rng)):
            found, rejection = self._asked(bench, one)
            if not bench.runner.reenacting and ((self.filmed and k == 0) or (rejection and rejected is None)):
                _film(bench, one, found)
            rejected = rejected or rejection
            if rejection is not None and found is None:
                break
        if rejected is not None:
            raise rejected

    def _asked(self, bench: Bench, one: Robust) -> tuple[Found | None, Rejection | None]:
        try:
            with np.errstate(all="ignore"):  # a mistake that diverges, run in this process for a diagnosis
                got = bench.call(FUNCTION, *one.inputs.values())
        except StudentFault as fault:
            bench.observe(FUNCTION, None, ok=False, fault=fault)
            return None, fault_rejection(fault, inputs=one.inputs)
        mismatch = judge(one, got)
        bench.observe(FUNCTION, fingerprint(one, got), ok=mismatch is None)
        found = read_answer(one, got)
        return (None if isinstance(found, Mismatch) else found), (rejection(one, got, mismatch) if mismatch else None)


def fingerprint(one: Robust, got: Value) -> Value:
    """What a diagnosis compares: coarse poses and weights, or `LOST` for what rounding errors decide."""
    found = read_answer(one, got)
    if isinstance(found, Mismatch):
        return found.message
    if not np.all(np.abs(found.poses) < FAR):
        return LOST
    return np.concatenate([found.poses.ravel(), found.weights]) / COARSENESS


def rejection(one: Robust, got: Value, mismatch: Mismatch) -> Rejection:
    """The finding in words, with the map that the true edges make."""
    lies = int(one.false.sum())
    count = "une fausse arête" if lies == 1 else f"{lies} fausses arêtes"
    given = f"{len(one.poses)} poses et {len(one.edges)} arêtes, dont {count}, δ = {render.number(DELTA)}"
    trusted = np.where(one.false, 0.0, 1.0)
    return Rejection(
        f"Pour {given}, avec n_iter = {one.n_iter} : {mismatch.message}",
        inputs=one.inputs,
        expected=(np.round(one.without_false, 3), trusted),
        got=got,
        slip=mismatch.slip,
        cause=mismatch.cause,
        figure=robust_figure(one, got),
    )


def robust_figure(one: Robust, got: Value) -> FigureData:
    """The true places, those of plain least squares and those obtained, and the weight of each edge."""
    found = read_answer(one, got)
    shown = isinstance(found, Found) and bool(np.abs(found.poses).max() < FAR and np.abs(found.weights).max() < FAR)
    return {
        "kind": "robuste",
        "truth": np.round(one.truth, 3).tolist(),
        "plain": np.round(one.plain, 3).tolist(),
        "edges": [[i, j] for i, j, _, _ in one.edges],
        "false": one.false.tolist(),
        "got": np.round(found.poses, 3).tolist() if isinstance(found, Found) and shown else None,
        "weights": np.round(found.weights, 4).tolist() if isinstance(found, Found) and shown else None,
    }


def _film(bench: Bench, one: Robust, judged: Found | None) -> None:
    """The program stopped after a few iterations, then as it was judged."""
    frames = []
    for stop in STOPS if judged is not None else ():
        try:
            found = read_answer(one, bench.call(FUNCTION, *replace(one, n_iter=stop).inputs.values()))
        except StudentFault:
            break
        if not isinstance(found, Found) or not np.all(np.abs(found.poses) < FAR):
            break
        frames.append(_frame(stop, found))
    if judged is not None and np.all(np.abs(judged.poses) < FAR):
        frames.append(_frame(one.n_iter, judged))
    bench.record_film(
        {
            "kind": "robuste",
            "start": np.round(one.poses, 3).tolist(),
            "truth": np.round(one.truth, 3).tolist(),
            "edges": [[i, j, np.round(z, 4).tolist(), w[0, 0], w[2, 2]] for i, j, z, w in one.edges],
            "false": one.false.tolist(),
            "frames": frames,
        }
    )


def _frame(stop: int, found: Found) -> list[Value]:
    return [stop, np.round(found.poses, 3).tolist(), np.round(np.clip(found.weights, 0.0, 1.0), 3).tolist()]
