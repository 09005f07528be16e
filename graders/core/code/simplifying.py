"""Simplifying what several checks have failed on: what each of them asks next travels together.

A check that has failed says what it looks for; it is looked for once all checks have been run, so that what is asked
meanwhile costs none of them anything, and so that as few exchanges as possible are waited for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NoReturn, Protocol, TypeVar

from graders.core.code.bench import Bench
from graders.core.code.runner import Runner
from graders.core.compare.comparison import Mismatch
from graders.core.compare.search import ShrinkSearch
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, StudentFault
from graders.core.contract.values import Arguments

CaseT = TypeVar("CaseT")
FailureT = TypeVar("FailureT")
#: Inputs that are asked together, of a program that answers in no time; seconds of calls that a slow one is asked.
MAX_PREFETCHED, MAX_BATCH_SECONDS = 24, 0.02


class FailureReason(Protocol):
    """Why an answer is held against a submission: a mismatch, or a fault."""

    @property
    def mismatch(self) -> Mismatch | None: ...

    @property
    def fault(self) -> StudentFault | None: ...


def fails_alike(first: FailureReason, other: FailureReason) -> bool:
    """A shrunk case must fail as the first one did: by the same exception or limit, or by a value of the same cause."""
    if first.fault or other.fault:
        return _end(first.fault) == _end(other.fault)
    assert first.mismatch is not None
    assert other.mismatch is not None
    return (first.mismatch.slip, first.mismatch.cause) == (other.mismatch.slip, other.mismatch.cause)


def _end(fault: StudentFault | None) -> tuple[Outcome, str | None] | None:
    return None if fault is None else (fault.outcome, fault.exception)


class PendingShrink(Exception):
    """A check has failed on an input that may be simplified: `search` seeks a simpler one, which `function` is called
    on with the `arguments` of it, and `told` says what is shown of the simplest."""

    def __init__(
        self,
        function: str,
        arguments: Callable[[Any], Arguments],
        search: ShrinkSearch[Any, Answer, Any],
        told: Callable[[Any], Exception],
    ) -> None:
        super().__init__(function)
        self.function, self.search, self._arguments, self._told = function, search, arguments, told

    def next_calls(self, most: int) -> PlannedCalls | None:
        """What is to be asked next; None when the simplest is found."""
        cases = self.search.questions(most)
        return PlannedCalls(self.function, list(map(self._arguments, cases))) if cases else None

    def rejection(self) -> Exception:
        """What is held against the program, on the simplest input found."""
        return self._told(self.search.simplest)


def shrink_and_reject(
    bench: Bench,
    function: str,
    failure: FailureT,
    case: CaseT,
    neighbours: Callable[[CaseT], Iterator[CaseT]],
    judge: Callable[[CaseT, Answer], FailureT | None],
    told: Callable[[FailureT], Exception],
    *,
    arguments: Callable[[CaseT], Arguments],
    stops: Callable[[FailureT], bool],
    fair: Callable[[CaseT], bool] = lambda case: True,
    costly: bool = False,
) -> NoReturn:
    """Raises what `told` says of the simplest failure that is found, `failure` being the one on `case`; see `Search`.

    On the main program it is looked for once all checks are run; on another, which goes with its check, at once. A
    re-enacted mistake has nobody to show a simple case to. Where it is `costly` to make a simpler case, none is made
    that may not be needed.
    """
    if bench.runner.reenacting or stops(failure):
        raise told(failure)
    budget, ahead = bench.runner.budget, 1 if costly else MAX_PREFETCHED
    search = ShrinkSearch(failure, case, neighbours, judge, budget=budget, fair=fair, stops=stops, ahead=ahead)
    unsimplified = PendingShrink(function, arguments, search, told)
    if bench.program is None:
        raise unsimplified
    shrink_all(bench.runner, [unsimplified], bench.answer_batches)
    raise unsimplified.rejection()


def shrink_all(
    runner: Runner,
    failed: Sequence[PendingShrink],
    answered: Callable[[Sequence[PlannedCalls]], Sequence[Sequence[Answer]]],
) -> None:
    """Looks for the simplest input of each, as far as their budgets go; `answered` has several calls made."""
    for one in failed:
        one.search.seconds *= len(failed)  # they share their time
    while True:
        most = max(1, min(MAX_PREFETCHED, int(MAX_BATCH_SECONDS / runner.seconds_per_call)))
        due = [(one, asked) for one in failed if (asked := one.next_calls(most)) is not None]
        if not due:
            return
        for (one, _), answers in zip(due, answered([asked for _, asked in due]), strict=True):
            one.search.take(answers)


def run_and_shrink(run: Callable[[Bench], None], bench: Bench) -> None:
    """Runs a check by itself: what it fails on is simplified before it raises what it finds."""
    try:
        run(bench)
    except PendingShrink as unsimplified:
        shrink_all(bench.runner, [unsimplified], bench.answer_batches)
        raise unsimplified.rejection() from None
