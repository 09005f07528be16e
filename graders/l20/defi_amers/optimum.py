"""The check of `slam_amers`: from the given map, does it reach the optimum, the first pose held fixed?

Judged by where it ends, whatever the road, as `gauss_newton` is in l20/slam_graphe, whose tolerances these are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, Mismatch, shape_mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair, value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.defi_amers.described import described
from graders.l20.defi_amers.maps import Failure, Map
from graders.l20.defi_amers.simpler import simpler_maps
from graders.l20.slam_graphe.optimum import CHI2_TOLERANCE, COARSENESS, FAR, LOST, POSE_TOLERANCE, SAME_VALLEY, gaps
from graders.robotics.turned import tell_turn
from reference.se2 import wrap_angle

FUNCTION = "slam_amers"
SMALL = 4
#: A program is filmed for as many of its iterations at most, and no more once it has settled.
FILMED = 8
SETTLED = 1e-4


@dataclass(frozen=True)
class Found:
    """The poses (n, 3) and landmarks (m, 2) that came back."""

    poses: Floats
    landmarks: Floats

    def away(self, one: Map) -> tuple[Floats, Floats]:
        """How far each pose (n,) and each landmark (m,) is from its place in the optimum."""
        poses, landmarks = one.optimum
        return np.abs(gaps(poses, self.poses)).max(axis=1), np.abs(self.landmarks - landmarks).max(axis=1)


def read_map(one: Map, got: Value) -> Found | Mismatch:
    """What came back, or what keeps it from being read."""
    if not isinstance(got, tuple | list) or len(got) != 2:
        message = "slam_amers doit renvoyer deux choses, les poses et les amers : « return poses, amers »."
        return Mismatch(message, cause=Outcome.INVALID_OUTPUT)
    try:
        poses, landmarks = read_array(got[0]), read_array(got[1])
    except UnreadableError as error:
        return unreadable(error)
    for name, array, given in (("Poses", poses, one.poses), ("Amers", landmarks, one.landmarks)):
        if array.shape != given.shape:
            wrong = shape_mismatch(given, array)
            return Mismatch(f"{name} : {wrong.message}", wrong.slip, wrong.cause)
        if not np.all(np.isfinite(array)):
            return Mismatch("Le résultat contient « nan » ou l'infini.", "nan")
    return Found(poses, landmarks)


def judge(one: Map, got: Value) -> Mismatch | None:
    """What is wrong with the map that came back, in French, or None."""
    found = read_map(one, got)
    if isinstance(found, Mismatch):
        return found
    return _first_pose(one, found) or _minimum(one, found) or _angles(found)


def _first_pose(one: Map, found: Found) -> Mismatch | None:
    if np.abs(gaps(one.poses[:1], found.poses[:1])).max() <= POSE_TOLERANCE:
        return None
    return Mismatch(f"La première pose devait rester {render.text(one.poses[0])} : elle a bougé.")


def _minimum(one: Map, found: Found) -> Mismatch | None:
    poses, landmarks = found.away(one)
    worst = float(max(poses.max(), landmarks.max()))
    if worst <= POSE_TOLERANCE:
        return None
    reached, least = one.chi2(found.poses, found.landmarks), one.solution.chi2[-1]
    if worst <= SAME_VALLEY and reached <= least * (1.0 + CHI2_TOLERANCE):
        return None
    unmoved = float(np.abs(gaps(one.poses, found.poses)).max()), float(np.abs(one.landmarks - found.landmarks).max())
    if max(unmoved) <= TOLERANCE:
        return Mismatch(f"C'est la carte de départ, où χ² vaut {render.number(reached, 4)} : rien n'a bougé.")
    sums = "χ² y vaut {} ; au minimum, il vaut {}".format(*number_text_pair(reached, least, 4))
    lost = (
        f"L'amer {np.argmax(landmarks)} est le"
        if landmarks.max() > poses.max()
        else f"La pose {np.argmax(poses)} est la"
    )
    wanted = np.vstack([one.optimum[0][:, :2], one.optimum[1]])
    turn = tell_turn(wanted, np.vstack([found.poses[:, :2], found.landmarks]))
    return Mismatch(f"{sums}. {lost} plus loin de sa place : {render.number(worst, 3)}.{turn}")


def _angles(found: Found) -> Mismatch | None:
    outside = np.flatnonzero(np.abs(found.poses[:, 2]) > np.pi + TOLERANCE)
    if not outside.size:
        return None
    theta = render.angle(float(found.poses[outside[0], 2]))
    return Mismatch(f"L'angle de la pose {outside[0]}, {theta}, sort de l'intervalle [−π, π].", "angle_non_ramene")


def fingerprint(one: Map, got: Value) -> Value:
    """What a diagnosis compares: a coarse map, or `LOST` for what rounding errors decide."""
    found = read_map(one, got)
    if isinstance(found, Mismatch):
        return found.message
    numbers = np.concatenate([found.poses.ravel(), found.landmarks.ravel()])
    return numbers / COARSENESS if np.all(np.abs(numbers) < FAR) else LOST


@dataclass(frozen=True, kw_only=True)
class Optimum(Check):
    """`slam_amers` on every map, simplest first; the simplest failing one is shown, shrunk.

    `filmed`: the first map is kept as a film, one iteration after the other.
    """

    maps: Callable[[np.random.Generator], Sequence[Map]]
    filmed: bool = False

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        for k, one in enumerate(self.maps(bench.rng)):
            failure, got = failure_on(bench, one)
            if self.filmed and k == 0 and not bench.runner.reenacting:
                _film(bench, one, got, passed=failure is None)
            first = first or failure
            if failure and failure.fault and _hopeless(failure.fault):
                break
        if first is not None:
            if bench.runner.reenacting:
                raise Rejection("")
            _reject(bench, first)


def _hopeless(fault: StudentFault) -> bool:
    return fault.fatal or fault.outcome is Outcome.MISSING_FUNCTION


def failure_on(bench: Bench, one: Map) -> tuple[Failure | None, Value]:
    """How one call on one map fails, None when it does not; and what came back."""
    try:
        with np.errstate(all="ignore"):  # a mistake that diverges, run in this process for a diagnosis
            got = bench.call(FUNCTION, *one.inputs.values())
    except StudentFault as fault:
        _observe_fault(bench, fault)
        return Failure(one, None, None, fault), None
    mismatch = judge(one, got)
    bench.observe(FUNCTION, fingerprint(one, got), ok=mismatch is None)
    return (Failure(one, got, mismatch, None) if mismatch else None), got


def _observe_fault(bench: Bench, fault: StudentFault) -> None:
    """A singular system raises or gives numbers made of rounding errors, by chance: both are the same finding."""
    if fault.exception == "LinAlgError":
        bench.observe(FUNCTION, LOST, ok=False)
    else:
        bench.observe(FUNCTION, None, ok=False, fault=fault)


def _film(bench: Bench, one: Map, got: Value, *, passed: bool) -> None:
    """The program called again for one iteration at a time, each from where the last one ended."""
    frames = [_rounded(Found(one.poses, one.landmarks))]
    here: Found | Mismatch = Found(one.poses, one.landmarks)
    while len(frames) <= FILMED and isinstance(here, Found):
        before, there = here, replace(one, poses=here.poses, landmarks=here.landmarks, n_iter=1)
        try:
            here = read_map(one, bench.call(FUNCTION, *there.inputs.values()))
        except StudentFault:
            break
        if isinstance(here, Mismatch) or not _drawable(one, here):
            break
        # What a program gives back is given to it again: angles as the module's.
        here = Found(np.column_stack([here.poses[:, :2], wrap_angle(here.poses[:, 2])]), here.landmarks)
        frames.append(_rounded(here))
        moved = max(np.abs(gaps(before.poses, here.poses)).max(), np.abs(before.landmarks - here.landmarks).max())
        if moved < SETTLED:
            break
    found = None if got is None else read_map(one, got)
    if isinstance(found, Found) and _drawable(one, found):
        frames.append(_rounded(found))
    bench.record_film(
        {
            "kind": "carte",
            "frames": [[poses.tolist(), landmarks.tolist()] for poses, landmarks in frames],
            "edges": [[i, j, z.tolist(), float(w[0, 0]), float(w[2, 2])] for i, j, z, w in one.edges],
            "sightings": [[i, j, z.tolist(), float(w[0, 0])] for i, j, z, w in one.sightings],
            "ended": isinstance(found, Found),
            "passed": passed,
        }
    )


def _rounded(found: Found) -> tuple[Floats, Floats]:
    return np.round(found.poses, 3), np.round(found.landmarks, 3)


def _drawable(one: Map, found: Found) -> bool:
    return bool(np.abs(found.poses).max() < FAR and np.abs(found.landmarks).max() < FAR)


def _reject(bench: Bench, failure: Failure) -> NoReturn:
    def judged(one: Map, answer: Answer) -> Failure | None:
        if isinstance(answer, StudentFault):
            simpler = Failure(one, None, None, answer)
        elif (mismatch := judge(one, answer.value)) is not None:
            simpler = Failure(one, answer.value, mismatch, None)
        else:
            return None
        return simpler if fails_alike(failure, simpler) else None

    shrink_and_reject(
        bench, FUNCTION, failure, failure.one, simpler_maps, judged, rejection,
        arguments=lambda one: tuple(one.inputs.values()), costly=True,
        stops=lambda one: one.fault is not None and _hopeless(one.fault),
    )  # fmt: skip


def rejection(failure: Failure) -> Rejection:
    """The finding in words, with the map, its optimum and what came back."""
    one = failure.one
    poses, landmarks = (np.where(np.abs(part) < TOLERANCE, 0.0, part) for part in one.optimum)
    if failure.fault:
        return fault_rejection(failure.fault, inputs=one.inputs, expected=(poses, landmarks))
    assert failure.mismatch is not None
    iterations = "sans donner n_iter" if one.n_iter is None else f"avec n_iter = {one.n_iter}"
    answer = f"{FUNCTION} ne renvoie pas le bon résultat"
    if len(poses) + len(landmarks) <= SMALL:
        wanted, got = value_text_pair((poses, landmarks), failure.got, digits=4)
        answer = f"on attend {wanted} et {FUNCTION} renvoie {got}"
    return Rejection(
        f"Pour {described(one)}, {iterations}, {answer}. {failure.mismatch.message}",
        inputs=one.inputs,
        expected=(poses, landmarks),
        got=failure.got,
        slip=failure.mismatch.slip,
        cause=failure.mismatch.cause,
        figure=map_figure(one, failure.got),
    )


def map_figure(one: Map, got: Value) -> FigureData:
    """The map before and after, and what remains of each measurement's error: the square root of its share in chi2."""
    poses, landmarks = one.optimum
    found = read_map(one, got) if got is not None else None
    shown = isinstance(found, Found) and _drawable(one, found)
    parts = (found.poses, found.landmarks) if isinstance(found, Found) and shown else None
    return {
        "kind": "carte",
        "start": one.poses.tolist(),
        "start_landmarks": one.landmarks.tolist(),
        "edges": [[i, j] for i, j, _, _ in one.edges],
        "sightings": [[i, j] for i, j, _, _ in one.sightings],
        "expected": poses.tolist(),
        "expected_landmarks": landmarks.tolist(),
        "got": None if parts is None else parts[0].tolist(),
        "got_landmarks": None if parts is None else parts[1].tolist(),
        "errors_expected": np.sqrt(one.shares(*one.optimum)).tolist(),
        "errors_got": None if parts is None else np.sqrt(one.shares(*parts)).tolist(),
    }
