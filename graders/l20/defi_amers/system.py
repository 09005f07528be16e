"""The check of `systeme`: H and b at a point, no pose held, block by block.

H within 1e-4 of its largest entry, as finite differences give it; b or -b, whichever the program returns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import MAX_FAULTS, Check, Rejection, fault_rejection
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare.comparison import Mismatch, shape_mismatch, unreadable
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.defi_amers.described import described
from graders.l20.defi_amers.maps import Failure, Map
from graders.l20.defi_amers.simpler import simpler_points

FUNCTION = "systeme"
PLACE = 1e-4
#: Of b, of which the terms may cancel one another where those of H do not.
SIDE = 1e-3
COARSE = 1e4
#: What is not drawn beside the right numbers.
HUGE = 1e9
Judge = Callable[[Map, Value], Mismatch | None]


@dataclass(frozen=True)
class Answered:
    """H (s, s) and b (s,) as they came back, b with the sign of the truth."""

    H: Floats
    b: Floats


def read_system(one: Map, got: Value) -> Answered | Mismatch:
    """What came back, or what keeps it from being read."""
    H, b = one.system
    if not isinstance(got, tuple | list) or len(got) != 2:
        return Mismatch("systeme doit renvoyer deux choses, H et b : « return H, b ».", cause=Outcome.INVALID_OUTPUT)
    try:
        matrix, side = read_array(got[0]), read_array(got[1])
    except UnreadableError as error:
        return unreadable(error)
    if matrix.shape != H.shape:
        return _named("H", shape_mismatch(H, matrix))
    if side.shape not in (b.shape, (len(b), 1), (1, len(b))):
        return _named("b", shape_mismatch(b, side))
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(side))):
        return Mismatch("Le résultat contient « nan » ou l'infini.", "nan")
    side = side.ravel()
    return Answered(matrix, -side if side @ b < 0.0 else side)


def _named(name: str, mismatch: Mismatch) -> Mismatch:
    return Mismatch(f"{name} : {mismatch.message}", mismatch.slip, mismatch.cause)


def judge(one: Map, got: Value) -> Mismatch | None:
    """What is wrong with H and b, in French, or None."""
    answer = read_system(one, got)
    if isinstance(answer, Mismatch):
        return answer
    return _matrix(one, answer.H) or _side(one, answer.b)


def judge_links(one: Map, got: Value) -> Mismatch | None:
    """What is wrong with the blocks of H between two poses, to which observations add nothing; or None."""
    answer = read_system(one, got)
    if isinstance(answer, Mismatch):
        return answer
    poses = 3 * len(one.poses)
    of_one_pose = np.kron(np.eye(len(one.poses)), np.ones((3, 3))) > 0.0
    kept = one.system[0].copy()
    kept[:poses, :poses] = np.where(of_one_pose, kept[:poses, :poses], answer.H[:poses, :poses])
    return _matrix(one, kept)


def _matrix(one: Map, got: Floats) -> Mismatch | None:
    wanted = one.system[0]
    away = np.abs(got - wanted)
    if away.max() <= PLACE * np.abs(wanted).max():
        return None
    row, column = (int(k) for k in np.unravel_index(int(np.argmax(away)), away.shape))
    (first, rows), (second, columns) = node(one, row), node(one, column)
    block = wanted[rows, columns], got[rows, columns]
    expected, obtained = value_text_pair(*map(_dusted, block), digits=4)
    place = f"({first} ; {second})" if first != second else f"de {first}"
    return Mismatch(f"Dans H, le bloc {place} devait être {expected}, et il est {obtained}.")


def _side(one: Map, got: Floats) -> Mismatch | None:
    wanted = one.system[1]
    away = np.abs(got - wanted)
    if away.max() <= SIDE * max(1.0, float(np.abs(wanted).max())):
        return None
    name, rows = node(one, int(np.argmax(away)))
    expected, obtained = value_text_pair(_dusted(wanted[rows]), _dusted(got[rows]), digits=4)
    return Mismatch(f"H est juste. Dans b, la part de {name} devait être {expected}, et elle est {obtained}.")


def _dusted(part: Floats) -> Floats:
    """Without what finite differences leave where there is nothing."""
    return np.where(np.abs(part) < 1e-6, 0.0, part)


def node(one: Map, at: int) -> tuple[str, slice]:
    """The node that an unknown belongs to, in words, and all of its unknowns."""
    poses = 3 * len(one.poses)
    if at < poses:
        return f"la pose {at // 3}", slice(at // 3 * 3, at // 3 * 3 + 3)
    k = (at - poses) // 2
    return f"l'amer {k}", slice(poses + 2 * k, poses + 2 * k + 2)


def fingerprint(one: Map, got: Value) -> Value:
    """H and b as one array of coarse numbers, so that numeric Jacobians agree with exact ones; else what is wrong."""
    answer = read_system(one, got)
    if isinstance(answer, Mismatch):
        return answer.message
    return np.concatenate([answer.H.ravel(), answer.b]) / COARSE


@dataclass(frozen=True, kw_only=True)
class Systems(Check):
    """`systeme` at every point, simplest first; the simplest failing one is shown, shrunk."""

    maps: Callable[[np.random.Generator], Sequence[Map]]
    judge: Judge = judge

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        maps = self.maps(bench.rng)
        calls = [tuple(one.at.values()) for one in maps]
        for one, (_, answer) in zip(maps, bench.call_many(FUNCTION, calls, faults=MAX_FAULTS), strict=False):
            failure = failure_of(one, answer, self.judge)
            if isinstance(answer, StudentFault):
                bench.observe(FUNCTION, None, ok=False, fault=answer)
            else:
                bench.observe(FUNCTION, fingerprint(one, answer.value), ok=failure is None)
            first = first or failure
        if first is not None:
            if bench.runner.reenacting:
                raise Rejection("")
            _reject(bench, first, self.judge)


def failure_of(one: Map, answer: Answer, judge: Judge) -> Failure | None:
    if isinstance(answer, StudentFault):
        return Failure(one, None, None, answer)
    mismatch = judge(one, answer.value)
    return Failure(one, answer.value, mismatch, None) if mismatch else None


def _reject(bench: Bench, failure: Failure, judge: Judge) -> NoReturn:
    def judged(one: Map, answer: Answer) -> Failure | None:
        simpler = failure_of(one, answer, judge)
        return simpler if simpler is not None and fails_alike(failure, simpler) else None

    shrink_and_reject(
        bench, FUNCTION, failure, failure.one, simpler_points, judged, rejection,
        arguments=lambda one: tuple(one.at.values()), costly=True,
        stops=lambda one: one.fault is not None and one.fault.fatal,
    )  # fmt: skip


def rejection(failure: Failure) -> Rejection:
    """The finding in words, with the right system and what came back."""
    one = failure.one
    expected = tuple(_dusted(part) for part in one.system)
    if failure.fault:
        return fault_rejection(failure.fault, inputs=one.at, expected=expected)
    assert failure.mismatch is not None
    return Rejection(
        f"Pour {described(one)} : {failure.mismatch.message}",
        inputs=one.at,
        expected=expected,
        got=failure.got,
        slip=failure.mismatch.slip,
        cause=failure.mismatch.cause,
        figure=system_figure(one, failure.got),
    )


def system_figure(one: Map, got: Value) -> FigureData:
    """H and b as they should be, and as they came back."""
    H, b = one.system
    answer = read_system(one, got)
    shown = isinstance(answer, Answered) and bool(np.abs(answer.H).max() < HUGE and np.abs(answer.b).max() < HUGE)
    parts = (answer.H, answer.b) if isinstance(answer, Answered) and shown else None
    return {
        "kind": "systeme",
        "poses": len(one.poses),
        "expected": np.round(H, 4).tolist(),
        "b_expected": np.round(b, 4).tolist(),
        "got": None if parts is None else np.round(parts[0], 4).tolist(),
        "b": None if parts is None else np.round(parts[1], 4).tolist(),
    }
