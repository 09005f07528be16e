"""Checks: one question asked of a submission, with its points.

`Cases` compares a function with its reference on inputs from the simplest to the most general. `Untouched` sees that
arguments are left alone. `Trial` runs any protocol: identities, statistics, closed loops.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, NoReturn

import numpy as np

from graders.core.code.batch_judging import judge_batch, take_plain_answers
from graders.core.code.bench import Bench
from graders.core.code.drawable import drawable_as
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare import words as render
from graders.core.compare.comparison import Comparator, Mismatch
from graders.core.compare.shrinking import Shrinker, neighbours
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, StudentFault
from graders.core.contract.rows import ArrayReplies, Rows
from graders.core.contract.values import Arguments, Value, same_value

# A function that raised that often has shown enough; each fault may have cost a large part of its time limit.
MAX_FAULTS = 4
#: A call that raises once in two is then seen to raise, but for one grading in four thousand.
RANDOM_CALLS = 12


class Rejection(Exception):
    """A check's finding against the submission, with what was given, expected and obtained.

    `message` is French. `inputs` maps argument names to values; `expected` and `got` may be values or French text.
    `call`, where it is known, is the one call that shows it: a function and its arguments.
    """

    def __init__(
        self,
        message: str,
        *,
        inputs: dict[str, Value] | None = None,
        expected: Value = None,
        got: Value = None,
        slip: str | None = None,
        cause: Outcome = Outcome.WRONG_ANSWER,
        figure: FigureData | None = None,
        call: tuple[str, Arguments] | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.inputs = inputs
        self.expected = expected
        self.got = got
        self.slip = slip
        self.cause = cause
        self.figure = figure
        self.call = call


@dataclass(frozen=True, kw_only=True)
class Check(ABC):
    """One check. `functions` are those that it judges; `points` count out of 20; `hint` is a question in French."""

    id: str
    title: str
    points: float
    functions: tuple[str, ...]
    hint: str
    requires_other_check: ClassVar[bool] = False
    """True when its points are earned only beside another check on the same functions: doing nothing earns nothing."""
    reports_call: ClassVar[bool] = False
    """True when what it rejects is told with the call that shows it (`Rejection.call`)."""

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        """What it will ask of the main program whatever is answered: drawn, before it runs, by the same bench."""
        return ()

    @property
    def has_unplanned_calls(self) -> bool:
        """Whether a right program is asked more than what is foreseen: what later checks ask must wait for that."""
        return True

    @property
    def launches(self) -> int:
        """How often it is known to start the file anew, as on another map."""
        return 0

    @abstractmethod
    def run(self, bench: Bench) -> None:
        """Return when the submission passes; raise Rejection, or let a StudentFault through, when it does not."""


@dataclass(frozen=True, kw_only=True)
class Trial(Check):
    """A check that runs one function on the bench.

    `asks` draws `bench.planned_calls` before it runs; with `no_more`, a right program gets no other call.
    """

    protocol: Callable[[Bench], None]
    asks: Callable[[Bench], Sequence[PlannedCalls]] | None = None
    no_more: bool = False

    @property
    def has_unplanned_calls(self) -> bool:
        return not self.no_more

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        return self.asks(bench) if self.asks else ()

    def run(self, bench: Bench) -> None:
        self.protocol(bench)


@dataclass(frozen=True, kw_only=True)
class Untouched(Check):
    """The functions must leave their arguments as they were. `inputs` draws the arguments of each function.

    Those of `chance` draw at random: they are called CHANCES times before, since one may raise in some calls alone.
    """

    requires_other_check: ClassVar[bool] = True

    names: dict[str, tuple[str, ...]]
    inputs: Callable[[np.random.Generator], dict[str, Arguments]]
    chance: tuple[str, ...] = ()

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        asked = []
        for function, args in self.inputs(bench.rng).items():
            if function in self.chance:
                asked.append(PlannedCalls(function, [args] * RANDOM_CALLS, faults=1))
            asked.append(PlannedCalls(function, [args], return_arguments=True))
        return asked

    def run(self, bench: Bench) -> None:
        for asked in planned_calls_of(self, bench):
            args = asked.calls[0]
            after = self._after(bench, asked)
            if not asked.return_arguments:
                continue
            trio = zip(self.names[asked.function], args, after, strict=True)
            changed = [name for name, before, now in trio if not same_value(before, now, tolerance=0.0)]
            bench.observe(asked.function, ",".join(changed), ok=not changed)
            if changed:
                raise self._rejection(asked.function, changed[0], args, after)

    def _after(self, bench: Bench, asked: PlannedCalls) -> Arguments:
        """The arguments as the last of the calls leaves them."""
        after: Arguments = ()
        for args, answer in bench.answers(asked):
            if isinstance(answer, StudentFault):
                inputs = dict(zip(self.names[asked.function], args, strict=True))
                raise fault_rejection(answer, inputs=inputs) from answer
            after = answer.arguments or ()
        return after

    def _rejection(self, function: str, name: str, args: Arguments, after: Arguments) -> Rejection:
        at = self.names[function].index(name)
        return Rejection(
            f"{function} modifie son argument {name} : après l'appel, il n'est plus ce qu'il était.",
            inputs=dict(zip(self.names[function], args, strict=True)),
            expected=args[at],
            got=after[at],
            slip="argument_modifie",
        )


@dataclass(frozen=True)
class Failure:
    """One failing case: the arguments, what was expected, what came back or the fault, and why it is wrong."""

    args: Arguments
    expected: Value
    got: Value
    mismatch: Mismatch | None
    fault: StudentFault | None


def planned_calls_of(check: Check, bench: Bench) -> Sequence[PlannedCalls]:
    """What was drawn for a check before it ran, or is drawn now."""
    return bench.planned_calls or check.planned_calls(bench)


@dataclass(frozen=True, kw_only=True)
class Cases(Check):
    """Compare one function with its reference on every case; show the simplest failing one, shrunk (but to re-enact).

    `cases` yields tuples of arguments, simplest first; `expected` computes the right answer from these;
    `shrinkers`, one for each argument, simplify a failing case as long as `valid` holds of it;
    `figure(args, expected, got)` makes the data of a drawing, or None where there is nothing to draw; `got` is None
    unless it has the expected shape, a tuple of arrays where a tuple of arrays is expected. With
    `rows`, `expected` takes arrays of arguments too, one case a row, and answers are seen to be right or wrong at once
    where `compare` is one of rows: what else `_judged` might hold against one is not asked.
    """

    reports_call: ClassVar[bool] = True

    names: tuple[str, ...]
    cases: Callable[[np.random.Generator], Iterable[Arguments]]
    expected: Callable[..., Value]
    compare: Comparator
    shrinkers: Sequence[Shrinker] = ()
    valid: Callable[[Arguments], bool] = field(default=lambda args: True)
    figure: Callable[[Arguments, Value, Any], FigureData | None] | None = None
    rows: bool = False

    @property
    def function(self) -> str:
        return self.functions[0]

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        drawn = self.cases(bench.rng)
        return [PlannedCalls(self.function, drawn if isinstance(drawn, Rows) else tuple(drawn), faults=MAX_FAULTS)]

    def run(self, bench: Bench) -> None:
        asked = planned_calls_of(self, bench)[-1]
        blocks = bench.answer_blocks(asked)
        plain = take_plain_answers(blocks) if self.rows else ()
        at_once = judge_batch(asked, plain, self.expected, self.compare)
        if isinstance(plain, ArrayReplies) and at_once and None not in at_once:
            bench.observe_all(self.function, plain.values, at_once)
            wrong = at_once.index(False) if False in at_once else None
            first = None if wrong is None else self._judged(asked.calls[wrong], plain[wrong])
        else:
            answers = itertools.chain(plain, itertools.chain.from_iterable(blocks))
            first = self._judged_in_turn(bench, asked, answers, at_once)
        if first is not None and not bench.runner.reenacting:
            self._reject(bench, first)

    def _judged_in_turn(
        self, bench: Bench, asked: PlannedCalls, answers: Iterator[Answer], at_once: Sequence[bool | None]
    ) -> Failure | None:
        """The first failure; what is seen at once of an answer is not asked again."""
        first: Failure | None = None
        judged = itertools.chain(at_once, itertools.repeat(None))
        for args, answer, right in zip(asked.calls, answers, judged, strict=False):
            bench.last_call = (self.function, args)
            failure = self._judged(args, answer) if right is None or not (right or first) else None
            if isinstance(answer, StudentFault):
                bench.observe(self.function, None, ok=False, fault=answer)
            else:
                bench.observe(self.function, answer.value, ok=failure is None if right is None else right)
            first = first or failure
        return first

    def _judged(self, args: Arguments, answer: Answer) -> Failure | None:
        expected = self.expected(*args)
        if isinstance(answer, StudentFault):
            return Failure(args, expected, None, None, answer)
        mismatch = self.compare(expected, answer.value)
        return Failure(args, expected, answer.value, mismatch, None) if mismatch else None

    def _reject(self, bench: Bench, failure: Failure) -> NoReturn:
        if not self.shrinkers:
            raise self._rejection(failure)

        def judge(args: Arguments, answer: Answer) -> Failure | None:
            simpler = self._judged(args, answer)
            return simpler if simpler is not None and fails_alike(failure, simpler) else None

        shrink_and_reject(
            bench, self.function, failure, failure.args, partial(neighbours, self.shrinkers), judge, self._rejection,
            arguments=lambda args: args, fair=self.valid, stops=lambda one: one.fault is not None and one.fault.fatal,
        )  # fmt: skip

    def _rejection(self, failure: Failure) -> Rejection:
        inputs = dict(zip(self.names, failure.args, strict=True))
        call = (self.function, failure.args)
        if failure.fault:
            return fault_rejection(failure.fault, inputs=inputs, expected=failure.expected, call=call)
        assert failure.mismatch is not None
        given = " ; ".join(f"{name} = {render.text(value)}" for name, value in inputs.items())
        wanted, got = render.text(failure.expected), render.text(failure.got)
        message = f"Pour {given}, on attend {wanted} et {self.function} renvoie {got}."
        return Rejection(
            f"{message} {failure.mismatch.message}",
            inputs=inputs,
            expected=failure.expected,
            got=failure.got,
            slip=failure.mismatch.slip,
            cause=failure.mismatch.cause,
            figure=self.figure_data(failure.args, failure.expected, failure.got),
            call=call,
        )

    def figure_data(self, args: Arguments, expected: Value, got: Value) -> FigureData | None:
        """The data of the figure for one answer; None where there is nothing to draw."""
        return None if self.figure is None else self.figure(args, expected, drawable_as(expected, got))


def fault_rejection(
    fault: StudentFault,
    *,
    inputs: dict[str, Value] | None,
    expected: Value = None,
    call: tuple[str, Arguments] | None = None,
) -> Rejection:
    """A fault of the student's program, told as the finding of a check."""
    where = "".join(f"\n  {frame}" for frame in fault.frames)
    got = f"aucune valeur ({fault.exception})" if fault.exception else "aucune valeur"
    return Rejection(fault.message + where, inputs=inputs, expected=expected, got=got, cause=fault.outcome, call=call)
