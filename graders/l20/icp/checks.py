"""A check of `icp` on pairs of clouds: R and t, or the errors; the simplest failing case is shrunk and drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import MAX_FAULTS, Check, Rejection, fault_rejection, planned_calls_of
from graders.core.code.simplifying import shrink_and_reject
from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, Reply, StudentFault
from graders.core.contract.values import Floats, Value
from graders.l20.icp.cases import NOWHERE, STILL, Draw
from graders.l20.icp.descent import Registration, descend, fair, staircase
from graders.l20.icp.judge import misjudged, misplaced, read, unread

FUNCTION = "icp"
FUNCTIONS = (FUNCTION,)
NAMES = ("P", "Q", "R0", "t0", "n_iter")
FEWEST_POINTS = 3
DRAWN_WITHIN = 20.0
Judge = Callable[[Registration, Value], Mismatch | None]


@dataclass(frozen=True)
class Failure:
    """A registration that a program fails on: what it answered, and why that is wrong; or the fault."""

    case: Registration
    value: Value
    mismatch: Mismatch | None
    fault: StudentFault | None

    @property
    def kind(self) -> object:
        """What a simpler failure must have in common with this one."""
        if self.fault is not None:
            return self.fault.exception, self.fault.outcome
        return self.mismatch and (self.mismatch.slip, self.mismatch.cause)

    @property
    def stops(self) -> bool:
        """Is it useless to go on?"""
        return self.fault is not None and (self.fault.fatal or self.fault.outcome is Outcome.MISSING_FUNCTION)


@dataclass(frozen=True, kw_only=True)
class Registrations(Check):
    """Judge each of the registrations that `cases` draws, by `judge`."""

    cases: Draw
    judge: Judge = misplaced

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        cases = list(self.cases(bench.rng))
        return [PlannedCalls(FUNCTION, [case.arguments for case in cases], faults=MAX_FAULTS, context=cases)]

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        (asked,) = planned_calls_of(self, bench)
        for case, (_, answer) in zip(asked.context, bench.iter_answers(asked), strict=False):
            failure = judged(case, answer, self.judge)
            fault = answer if isinstance(answer, StudentFault) else None
            value = None if isinstance(answer, StudentFault) else answer.value
            bench.observe(FUNCTION, value, ok=failure is None, fault=fault)
            first = first or failure
        if first is not None:
            self._reject(bench, first)

    def _reject(self, bench: Bench, failure: Failure) -> NoReturn:
        def judge(case: Registration, answer: Answer) -> Failure | None:
            simpler = judged(case, answer, self.judge)
            return simpler if simpler is not None and simpler.kind == failure.kind else None

        shrink_and_reject(
            bench, FUNCTION, failure, failure.case, simpler_cases, judge, lambda one: rejection(one, self.judge),
            arguments=lambda case: case.arguments, fair=long_enough, stops=lambda one: one.stops, costly=True,
        )  # fmt: skip


def long_enough(case: Registration) -> bool:
    """Is it fair, and is one step not enough where several are asked for?"""
    too_short = case.iterations > 1 and len(descend(*case[:4], case.iterations)) < 2
    return not too_short and fair(case)


def answer_to(bench: Bench, case: Registration) -> Answer:
    """What the program answers to one registration."""
    try:
        return Reply(bench.call(FUNCTION, *case.arguments))
    except StudentFault as fault:
        return fault


def judged(case: Registration, answer: Answer, judge: Judge) -> Failure | None:
    """How the program fails on it; None when its answer is right."""
    if isinstance(answer, StudentFault):
        return Failure(case, None, None, answer)
    mismatch = judge(case, answer.value)
    return Failure(case, answer.value, mismatch, None) if mismatch else None


def simpler_cases(case: Registration) -> Iterator[Registration]:
    """No start, whole coordinates, one point fewer."""
    if np.any(case.R0 != STILL) or np.any(case.t0):
        yield case._replace(R0=STILL, t0=NOWHERE)
    whole = case._replace(P=np.round(case.P) + 0.0, Q=np.round(case.Q) + 0.0)
    if np.any(whole.P != case.P) or np.any(whole.Q != case.Q):
        yield whole
    for name in ("P", "Q"):
        points = getattr(case, name)
        if len(points) > FEWEST_POINTS:
            yield from (case._replace(**{name: np.delete(points, k, axis=0)}) for k in reversed(range(len(points))))


def rejection(failure: Failure, judge: Judge) -> Rejection:
    """A failure as the finding of a check, with its figure."""
    case = failure.case
    inputs: dict[str, Value] = dict(zip(NAMES, case.arguments, strict=False))
    steps = descend(*case[:4], case.iterations)
    last = steps[-1]
    expected: Value = (last.R, last.t)
    if judge is misjudged:
        stairs = [render.number(float(cost), 5) for cost in staircase(steps)]
        expected = f"des sommes de carrés qui descendent, parmi {' ; '.join(stairs[:12])}"
    if failure.fault is not None:
        return fault_rejection(failure.fault, inputs=inputs, expected=expected)
    assert failure.mismatch is not None
    return Rejection(
        f"{_asked(case)} {failure.mismatch.message}",
        inputs=inputs,
        expected=expected,
        got=_got(failure.value, judge),
        slip=failure.mismatch.slip,
        cause=failure.mismatch.cause,
        figure=clouds_figure(case, failure.value),
    )


def _asked(case: Registration) -> str:
    count = "sans n_iter, donc 30 itérations" if case.n_iter is None else f"n_iter = {case.n_iter}"
    start = "départ R0 = I, t0 = 0"
    if np.any(case.R0 != STILL) or np.any(case.t0):
        degrees = render.number(float(np.degrees(np.arctan2(case.R0[1, 0], case.R0[0, 0]))), 4)
        start = f"départ R0 de {degrees}°, t0 = {render.text(case.t0, digits=4)}"
    return f"P de {len(case.P)} points, Q de {len(case.Q)}, {start}, {count} :"


def _got(value: Value, judge: Judge) -> Value:
    if unread(value) is not None:
        return value
    answer = read(value)
    return answer.errors if judge is misjudged else (answer.R, answer.t)


def clouds_figure(case: Registration, value: Value) -> FigureData:
    """What is drawn: both clouds, P where it starts, where it must end and where it has ended, with the pairs there."""
    P, Q, R0, t0, _ = case
    last = descend(P, Q, R0, t0, case.iterations)[-1]
    moved: Floats | None = None
    if unread(value) is None:
        answer = read(value)
        with np.errstate(over="ignore", invalid="ignore"):
            moved = P @ answer.R.T + answer.t
        reach = DRAWN_WITHIN * max(1.0, float(np.max(np.abs(P))), float(np.max(np.abs(Q))))
        moved = moved if bool(np.all(np.abs(moved) <= reach)) else None
    return {
        "kind": "clouds",
        "P": P @ R0.T + t0,
        "Q": Q,
        "expected": P @ last.R.T + last.t,
        "got": moved,
        "pairs": last.pairs,
    }
