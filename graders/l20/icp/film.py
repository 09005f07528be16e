"""Two scans of one room, registered by the student's program with one iteration, two, three…: a film of its way."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from graders.core.code.bench import Bench
from graders.core.contract.local import initial_globals
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.icp.checks import FUNCTION, Failure, answer_to, judged, rejection
from graders.l20.icp.descent import DEFAULT, Registration, Step, descend
from graders.l20.icp.judge import misplaced, read, unread

RAYS = 60
FIRST, SECOND = np.array([11.4, 3.3, 0.0]), np.array([12.3, 3.9, 0.35])
#: Iterations that are watched, of the many that it takes until nothing moves.
WATCHED = 8
#: The whole error may stay above the least by that much, since honest programs stop where it hardly falls.
LEFT = 0.05
SHOWN = 1e3


@lru_cache(maxsize=1)
def scans() -> tuple[Floats, Floats]:
    """The points of the second scan, which move, and those of the first, to three decimals."""
    lidar = initial_globals(world.STILL)["lidar"]
    second, first = (_points(np.asarray(lidar(pose, RAYS))) for pose in (SECOND, FIRST))
    return second, first


def _points(ranges: Floats) -> Floats:
    angles = 2.0 * np.pi * np.arange(len(ranges)) / len(ranges)
    seen = ranges < world.RANGE
    return np.round(np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])[seen], 3)


@lru_cache(maxsize=1)
def path() -> Sequence[Step]:
    """Every iteration until nothing moves."""
    return descend(*scans(), np.eye(2), np.zeros(2), 100)


def watch(bench: Bench) -> None:
    """Ask for 1, 2, 3… iterations: each must lead where the reference is; then for 30, which must end as low."""
    P, Q = scans()
    places: list[tuple[Floats, Floats]] = []
    first: tuple[int, Failure] | None = None
    for n_iter in range(1, WATCHED + 1):
        case = Registration(P, Q, np.eye(2), np.zeros(2), n_iter)
        answer = answer_to(bench, case)
        failure = judged(case, answer, misplaced)
        value = None if isinstance(answer, StudentFault) else answer.value
        bench.observe(FUNCTION, value, ok=failure is None, fault=failure.fault if failure else None)
        first = first or ((n_iter, failure) if failure else None)
        if value is None or unread(value) is not None or not _shown(read(value).R, read(value).t):
            break
        places.append((read(value).R, read(value).t))
    bench.record_film(
        {
            "kind": "iterations",
            "P": P,
            "Q": Q,
            "R": [np.round(R, 5) for R, _ in places],
            "t": [np.round(t, 5) for _, t in places],
            "wrong": None if first is None else first[0],
        }
    )
    if first is not None:
        raise rejection(first[1], misplaced)
    _must_end_low(bench, Registration(P, Q, np.eye(2), np.zeros(2), DEFAULT))


def _shown(R: Floats, t: Floats) -> bool:
    return bool(np.all(np.abs(R) < SHOWN) and np.all(np.abs(t) < SHOWN))


def _must_end_low(bench: Bench, case: Registration) -> None:
    value = bench.call(FUNCTION, *case.arguments)
    mismatch = unread(value)
    if mismatch is None:
        answer = read(value)
        least = descend(*case[:4], DEFAULT)[-1].after
        if cost(case.P, case.Q, answer.R, answer.t) <= (1.0 + LEFT) * least:
            bench.observe(FUNCTION, value, ok=True)
            return
        mismatch = misplaced(case, value)
    bench.observe(FUNCTION, value, ok=mismatch is None)
    if mismatch is not None:
        raise rejection(Failure(case, value, mismatch, None), misplaced)


def cost(P: Floats, Q: Floats, R: Floats, t: Floats) -> float:
    """The sum of squares from each point of P, moved, to the nearest of Q; infinite if R is no rotation."""
    if not np.allclose(R.T @ R, np.eye(2), atol=1e-6) or np.linalg.det(R) < 0.0:
        return float("inf")
    return float(np.sum(np.min(np.sum((P @ R.T + t - Q[:, None]) ** 2, axis=2), axis=0)))
