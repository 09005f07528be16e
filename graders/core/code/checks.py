"""Checks: one tested property of a submission, with its points.

`Cases` compares a function with its reference on inputs from the simplest to the most general. `Untouched` tests that
arguments stay unmodified. `Trial` runs any protocol: identities, statistics, closed loops.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, NoReturn

import numpy as np

from graders.core.code.batch_judging import judge_batch, take_leading_plain_answers
from graders.core.code.bench import Bench
from graders.core.code.drawable import to_drawable_like
from graders.core.code.shared_results import SHARED, find_changed_result
from graders.core.code.simplifying import fails_alike, shrink_and_reject
from graders.core.compare import words as render
from graders.core.compare.comparison import Comparator, Mismatch, compare
from graders.core.compare.python_values import to_counterexample_value
from graders.core.compare.shrinking import Shrinker, iter_simpler_arguments
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, KitSettings, PlannedCalls, Reply, StudentFault
from graders.core.contract.rows import ArrayReplies, Rows
from graders.core.contract.values import Arguments, Value, same_value

# A function that raised that often has shown enough; each fault may have cost a large part of its time limit.
MAX_FAULTS = 4
#: Calls of a random function: one that raises every second time passes one grading in four thousand.
RANDOM_CALLS = 12


class Rejection(Exception):
    """A check's finding against the submission, with inputs, expected and obtained values.

    `message` is French. `inputs` maps argument names to values; `expected` and `got` may be values or French text.
    `call`, where known, is the single call that shows the failure: a function and its arguments. Rejections of equal
    `sign` have the same reason; `neutral` is one without a fault.
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
        sign: Hashable = None,
        neutral: bool = False,
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
        self.sign = sign
        self.neutral = neutral
        self.kit: KitSettings | None = None  # of a side program, where it was made


@dataclass(frozen=True, kw_only=True)
class Check(ABC):
    """One check. `functions` are those that it tests; `points` count out of 20; `hint` is a question in French."""

    id: str
    title: str
    points: float
    functions: tuple[str, ...]
    hint: str
    requires_other_check: ClassVar[bool] = False
    """Whether its points count only if another check on the same functions passes: doing nothing earns nothing."""
    reports_call: ClassVar[bool] = False
    """Whether its rejections hold the call that shows the failure (`Rejection.call`)."""

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        """Return the calls that it makes whatever the answers, drawn by its bench before it runs."""
        return ()

    @property
    def has_unplanned_calls(self) -> bool:
        """Whether a right program gets calls besides the planned ones, for which later checks must wait."""
        return True

    @property
    def launches(self) -> int:
        """The number of side programs that it starts, as on another map."""
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
    """The functions must not modify their arguments, nor what they returned. `inputs` draws arguments of each.

    A second call must leave the first one's result alone: its arguments are drawn by `then`, or by `inputs` again.
    Functions in `chance` draw random numbers: they are first called RANDOM_CALLS times, as one may raise only rarely.
    """

    requires_other_check: ClassVar[bool] = True

    names: dict[str, tuple[str, ...]]
    inputs: Callable[[np.random.Generator], dict[str, Arguments]]
    then: Callable[[np.random.Generator], dict[str, Arguments]] | None = None
    chance: tuple[str, ...] = ()

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        batches, inputs = [], self.inputs(bench.rng)
        other = (self.then or self.inputs)(bench.rng)
        for function, args in inputs.items():
            if function in self.chance:
                batches.append(PlannedCalls(function, [args] * RANDOM_CALLS, faults=1))
            batches.append(PlannedCalls(function, [args, other[function]], return_arguments=True))
        return batches

    def run(self, bench: Bench) -> None:
        for batch in planned_calls_of(self, bench):
            answers = self._replies_or_reject(bench, batch)
            if not batch.return_arguments:
                continue
            args, after = batch.calls[0], answers[0].arguments or ()
            trio = zip(self.names[batch.function], args, after, strict=True)
            changed = [name for name, before, now in trio if not same_value(before, now, tolerance=0.0)]
            bench.observe(batch.function, ",".join(changed), ok=not changed)
            if changed:
                raise self._rejection(batch.function, changed[0], args, after)
            self._check_results_stay_unmodified(bench, batch, answers)

    def _check_results_stay_unmodified(self, bench: Bench, batch: PlannedCalls, answers: Sequence[Answer]) -> None:
        """Results that the student returned must stay as they were, whatever is called next."""
        if (found := find_changed_result(batch.calls, answers)) is None:
            return
        bench.observe(batch.function, SHARED, ok=False)
        raise Rejection(
            f"{batch.function} réécrit ce qu’elle a renvoyé : gardé, le premier résultat change à l’appel suivant.",
            inputs=dict(zip(self.names[batch.function], batch.calls[0], strict=True)),
            expected=found.before,
            got=found.after,
            slip=SHARED,
        )

    def _replies_or_reject(self, bench: Bench, batch: PlannedCalls) -> Sequence[Reply]:
        """Return the replies to all calls. Raises Rejection for a fault."""
        replies = []
        for args, answer in bench.iter_answers(batch):
            if isinstance(answer, StudentFault):
                inputs = dict(zip(self.names[batch.function], args, strict=True))
                raise fault_rejection(answer, inputs=inputs) from answer
            replies.append(answer)
        return replies

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
    """One failing case: arguments, expected and obtained values, the mismatch or the fault."""

    args: Arguments
    expected: Value
    got: Value
    mismatch: Mismatch | None
    fault: StudentFault | None


def planned_calls_of(check: Check, bench: Bench) -> Sequence[PlannedCalls]:
    """Return the planned calls of a check, drawn before it ran or now."""
    return bench.planned_calls or check.planned_calls(bench)


@dataclass(frozen=True, kw_only=True)
class Cases(Check):
    """Compare one function with its reference on every case; report the simplest failing one, shrunk.

    `cases` yields tuples of arguments, simplest first; `expected` computes the right answer from these;
    `shrinkers`, one for each argument, simplify a failing case as long as `valid` holds of it;
    `figure(args, expected, got)` makes the data of a drawing, or None where there is nothing to draw; `got` is None
    unless it has the expected shape, a tuple of arrays where a tuple of arrays is expected. With `rows`, `expected`
    accepts arrays of arguments, one case a row, and a RowComparator judges all answers at once.
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
        batch = planned_calls_of(self, bench)[-1]
        blocks = bench.answer_blocks(batch)
        plain = take_leading_plain_answers(blocks) if self.rows else ()
        at_once = judge_batch(batch, plain, self.expected, self.compare)
        if isinstance(plain, ArrayReplies) and at_once and None not in at_once:
            bench.observe_all(self.function, plain.values, at_once)
            wrong = at_once.index(False) if False in at_once else None
            first = None if wrong is None else self._find_failure(batch.calls[wrong], plain[wrong])
        else:
            answers = itertools.chain(plain, itertools.chain.from_iterable(blocks))
            first = self._observe_and_find_failure(bench, batch, answers, at_once)
        if first is not None and not bench.runner.reenacting:
            self._raise_shrunk_rejection(bench, first)

    def _observe_and_find_failure(
        self, bench: Bench, batch: PlannedCalls, answers: Iterator[Answer], at_once: Sequence[bool | None]
    ) -> Failure | None:
        """Record all observations and return the first failure; answers judged in the batch are not compared again."""
        first: Failure | None = None
        judged = itertools.chain(at_once, itertools.repeat(None))
        for args, answer, right in zip(batch.calls, answers, judged, strict=False):
            bench.last_call = (self.function, args)
            failure = self._find_failure(args, answer) if right is None or not (right or first) else None
            if isinstance(answer, StudentFault):
                bench.observe(self.function, None, ok=False, fault=answer)
            else:
                bench.observe(self.function, answer.value, ok=failure is None if right is None else right)
            first = first or failure
        return first

    def _find_failure(self, args: Arguments, answer: Answer) -> Failure | None:
        expected = self.expected(*args)
        if isinstance(answer, StudentFault):
            return Failure(args, expected, None, None, answer)
        mismatch = compare(self.compare, expected, answer.value)
        return Failure(args, expected, answer.value, mismatch, None) if mismatch else None

    def _raise_shrunk_rejection(self, bench: Bench, failure: Failure) -> NoReturn:
        if not self.shrinkers:
            raise self._rejection(failure)

        def judge(args: Arguments, answer: Answer) -> Failure | None:
            simpler = self._find_failure(args, answer)
            return simpler if simpler is not None and fails_alike(failure, simpler) else None

        simpler_args = partial(iter_simpler_arguments, self.shrinkers)
        shrink_and_reject(
            bench, self.function, failure, failure.args, simpler_args, judge, self._rejection,
            arguments=lambda args: args, fair=self.valid, stops=lambda it: it.fault is not None and it.fault.fatal,
        )  # fmt: skip

    def _rejection(self, failure: Failure) -> Rejection:
        inputs = dict(zip(self.names, failure.args, strict=True))
        shown = {name: to_counterexample_value(value) for name, value in inputs.items()}
        expected, call = to_counterexample_value(failure.expected), (self.function, failure.args)
        if failure.fault:
            return fault_rejection(failure.fault, inputs=shown, expected=expected, call=call)
        assert failure.mismatch is not None
        inputs_text = " ; ".join(f"{name} = {render.text(value)}" for name, value in inputs.items())
        expected_text, got_text = value_text_pair(failure.expected, failure.got)
        message = f"Pour {inputs_text}, on attend {expected_text} et {self.function} renvoie {got_text}."
        return Rejection(
            f"{message} {failure.mismatch.message}".rstrip(),
            inputs=shown,
            expected=expected,
            got=to_counterexample_value(failure.got),
            slip=failure.mismatch.slip,
            cause=failure.mismatch.cause,
            figure=self.figure_data(failure.args, failure.expected, failure.got),
            call=call,
            # What a function returns cannot be read, for a reason that has nothing to do with these arguments.
            sign=(self.function, failure.mismatch.message)
            if failure.mismatch.cause is Outcome.INVALID_OUTPUT
            else None,
        )

    def figure_data(self, args: Arguments, expected: Value, got: Value) -> FigureData | None:
        """Return the data of the figure for one answer; None where there is nothing to draw."""
        return None if self.figure is None else self.figure(args, expected, to_drawable_like(expected, got))


def fault_rejection(
    fault: StudentFault,
    *,
    inputs: dict[str, Value] | None,
    expected: Value = None,
    call: tuple[str, Arguments] | None = None,
) -> Rejection:
    """Return the rejection that reports a fault of the student's program."""
    where = "".join(f"\n  {frame}" for frame in fault.frames)
    got = f"aucune valeur ({fault.exception})" if fault.exception else "aucune valeur"
    sign = (fault.outcome, fault.exception, fault.line) if fault.line else (fault.outcome, fault.message)
    return Rejection(
        fault.message + where, inputs=inputs, expected=expected, got=got, cause=fault.outcome, call=call, sign=sign
    )
