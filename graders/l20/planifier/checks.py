"""A check of `planifier` on maps: any cheapest path is right; the simplest failing map is simplified and drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import MAX_FAULTS, Check, Failure, Rejection, fault_rejection, planned_calls_of
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare import words as render
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, StudentFault
from graders.core.contract.values import Arguments, Value
from graders.l20.planifier.judge import mismatch_of, simpler
from graders.l20.planifier.pictures import path_figure
from graders.l20.planifier.truth import best_path, right_price

FUNCTION = "planifier"
NAMES = ("permises", "couts", "depart", "but")


@dataclass(frozen=True, kw_only=True)
class Paths(Check):
    """Judge the path on each of the maps that `cases` draws."""

    cases: Callable[[np.random.Generator], Iterator[Arguments]]

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        return [PlannedCalls(FUNCTION, tuple(self.cases(bench.rng)), faults=MAX_FAULTS)]

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        (asked,) = planned_calls_of(self, bench)
        for args, answer in bench.iter_answers(asked):
            failure = judged(args, answer)
            fault = answer if isinstance(answer, StudentFault) else None
            value = None if isinstance(answer, StudentFault) else answer.value
            bench.observe(FUNCTION, value, ok=failure is None, fault=fault)
            first = first or failure
        if first is not None:
            _reject(bench, first)


def judged(args: Arguments, answer: Answer) -> Failure | None:
    expected = told(args)
    if isinstance(answer, StudentFault):
        return Failure(args, expected, None, None, answer)
    mismatch = mismatch_of(args, answer.value)
    return Failure(args, expected, answer.value, mismatch, None) if mismatch else None


def told(args: Arguments) -> Value:
    """One of the best paths, and its price; in words, since others may be as good."""
    best = best_path(*args)
    if not best:
        return "une liste vide : il n'y a pas de chemin"
    return f"un chemin de prix {render.number(right_price(best, args[1]))}, par exemple {best}"


def _reject(bench: Bench, failure: Failure) -> NoReturn:
    def judge(args: Arguments, answer: Answer) -> Failure | None:
        found = judged(args, answer)
        return found if found is not None and fails_alike(failure, found) else None

    shrink_and_reject(
        bench, FUNCTION, failure, failure.args, simpler, judge, _rejection,
        arguments=lambda args: args, fair=_is_same_kind(failure), stops=_stops,
    )  # fmt: skip


def _is_same_kind(failure: Failure) -> Callable[[Arguments], bool]:
    """A simpler map must have a path, or none, as the one that failed."""
    possible = bool(best_path(*failure.args))
    return lambda args: bool(best_path(*args)) == possible


def _stops(failure: Failure) -> bool:
    fault = failure.fault
    return fault is not None and (fault.fatal or fault.outcome is Outcome.MISSING_FUNCTION)


def _rejection(failure: Failure) -> Rejection:
    inputs = dict(zip(NAMES, failure.args, strict=True))
    call = (FUNCTION, failure.args)
    if failure.fault is not None:
        return fault_rejection(failure.fault, inputs=inputs, expected=failure.expected, call=call)
    assert failure.mismatch is not None
    permitted, _, start, goal = failure.args
    height, width = permitted.shape
    return Rejection(
        f"Sur une grille de {height} × {width} cases, de {start} à {goal} : {failure.mismatch.message}",
        inputs=inputs,
        expected=failure.expected,
        got=failure.got,
        slip=failure.mismatch.slip,
        cause=failure.mismatch.cause,
        figure=path_figure(failure.args, failure.got),
        call=call,
    )
