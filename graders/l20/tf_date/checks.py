"""A check of functions that return a pose or raise: which of the two, which exception, which pose."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Failure, Rejection, fault_rejection, planned_calls_of
from graders.core.code.drawable import to_drawable_like
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, StudentFault
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.tf_date.truth import UNKNOWN_FRAME
from graders.robotics.poses import SamePose
from graders.typography import elided

SAME = SamePose()
#: Why an exception is expected: whether it is that of an unknown frame.
WHY = {
    True: "ce repère n'est pas au-dessus de l'autre, ou n'est dans aucun message",
    False: "la pose n'est pas connue à cette date",
}


@dataclass(frozen=True, kw_only=True)
class Answers(Check):
    """Compare a function with what is right: a pose, or the name of an exception.

    `expected` computes it from the arguments; `simpler` proposes simpler arguments as long as `valid` holds of them.
    """

    names: tuple[str, ...]
    cases: Callable[[np.random.Generator], Iterator[Arguments]]
    expected: Callable[..., Floats | str]
    simpler: Callable[[Arguments], Iterator[Arguments]]
    valid: Callable[[Arguments], bool]
    figure: Callable[[Arguments, Value, Value], FigureData | None]

    @property
    def function(self) -> str:
        return self.functions[0]

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        return [PlannedCalls(self.function, tuple(self.cases(bench.rng)))]

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        (asked,) = planned_calls_of(self, bench)
        for args, answer in bench.iter_answers(asked):
            failure = self._judged(args, answer)
            fault = answer if isinstance(answer, StudentFault) else None
            value = None if isinstance(answer, StudentFault) else answer.value
            bench.observe(self.function, value, ok=failure is None, fault=fault)
            first = first or failure
        if first is not None:
            self._reject(bench, first)

    def _judged(self, args: Arguments, answer: Answer) -> Failure | None:
        expected = self.expected(*args)
        if isinstance(answer, StudentFault):
            raised = answer.exception if answer.outcome is Outcome.RUNTIME_ERROR else None
            return (
                None
                if isinstance(expected, str) and raised == expected
                else Failure(args, expected, None, None, answer)
            )
        if isinstance(expected, str):
            return Failure(args, expected, answer.value, Mismatch(f"On attend une exception {expected}."), None)
        mismatch = SAME(expected, answer.value)
        return Failure(args, expected, answer.value, mismatch, None) if mismatch else None

    def _reject(self, bench: Bench, failure: Failure) -> NoReturn:
        def judge(args: Arguments, answer: Answer) -> Failure | None:
            found = self._judged(args, answer)
            return found if found is not None and fails_alike(failure, found) else None

        def fair(args: Arguments) -> bool:
            return self.valid(args) and _kind(self.expected(*args)) == _kind(failure.expected)

        shrink_and_reject(
            bench, self.function, failure, failure.args, self.simpler, judge, self._rejection,
            arguments=lambda args: args, fair=fair, stops=lambda one: one.fault is not None and one.fault.fatal,
        )  # fmt: skip

    def _rejection(self, failure: Failure) -> Rejection:
        inputs = dict(zip(self.names, failure.args, strict=True))
        call = (self.function, failure.args)
        told = _told(failure.expected)
        raised = failure.fault.exception if failure.fault else None
        if failure.fault is not None and not (isinstance(failure.expected, str) and raised):
            return fault_rejection(failure.fault, inputs=inputs, expected=told, call=call)
        figure = self.figure(failure.args, failure.expected, to_drawable_like(failure.expected, failure.got))
        if isinstance(failure.expected, str):
            got = f"elle lève {raised}" if raised else f"elle renvoie {render.text(failure.got)}"
            why = WHY[failure.expected == UNKNOWN_FRAME]
            where = f" {failure.fault.message}" if failure.fault is not None else ""
            message = f"Ici, {why} : on attend {elided('que', self.function)} lève {failure.expected}, et {got}.{where}"
            return Rejection(
                message, inputs=inputs, expected=told, got=raised or failure.got, figure=figure, call=call,
                sign=(self.function, failure.expected, raised) if raised else None,
            )  # fmt: skip
        assert failure.mismatch is not None
        wanted, found = value_text_pair(failure.expected, failure.got)
        return Rejection(
            f"On attend {wanted}, et {self.function} renvoie {found}. {failure.mismatch.message}",
            inputs=inputs,
            expected=failure.expected,
            got=failure.got,
            slip=failure.mismatch.slip,
            cause=failure.mismatch.cause,
            figure=figure,
            call=call,
        )


def _kind(expected: Floats | str) -> str:
    return expected if isinstance(expected, str) else "pose"


def _told(expected: Floats | str) -> Value:
    return f"l'exception {expected}" if isinstance(expected, str) else expected
