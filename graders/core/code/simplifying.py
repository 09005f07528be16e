"""Shrinking of the counterexamples of several failed checks, in shared exchanges with the program.

It starts once all checks have run, so that it costs none of them anything (a limit, a dead process), and the searches
of all checks send their next calls together.
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
#: Inputs of one search in one exchange; seconds that the calls of one exchange may be expected to take.
MAX_PREFETCHED, MAX_BATCH_SECONDS = 24, 0.02


class FailureReason(Protocol):
    """Why an answer fails a check: a mismatch, or a fault."""

    @property
    def mismatch(self) -> Mismatch | None: ...

    @property
    def fault(self) -> StudentFault | None: ...


def fails_alike(first: FailureReason, other: FailureReason) -> bool:
    """Whether a shrunk case fails as the first one did: same exception or limit, or wrong value of the same cause."""
    if first.fault or other.fault:
        return _outcome_and_exception(first.fault) == _outcome_and_exception(other.fault)
    assert first.mismatch is not None
    assert other.mismatch is not None
    return (first.mismatch.slip, first.mismatch.cause) == (other.mismatch.slip, other.mismatch.cause)


def _outcome_and_exception(fault: StudentFault | None) -> tuple[Outcome, str | None] | None:
    return None if fault is None else (fault.outcome, fault.exception)


class PendingShrink(Exception):
    """Raised by a check that has failed on an input which may be shrunk by `search`.

    `arguments` gives the arguments of `function` for a case; `to_rejection`, the rejection for the simplest failure.
    """

    def __init__(
        self,
        function: str,
        arguments: Callable[[Any], Arguments],
        search: ShrinkSearch[Any, Answer, Any],
        to_rejection: Callable[[Any], Exception],
    ) -> None:
        super().__init__(function)
        self.function, self.search, self._arguments, self._to_rejection = function, search, arguments, to_rejection

    def next_calls(self, limit: int) -> PlannedCalls | None:
        """Return the next calls of the search, at most `limit`; None when it is over."""
        cases = self.search.next_cases(limit)
        return PlannedCalls(self.function, list(map(self._arguments, cases))) if cases else None

    def rejection(self) -> Exception:
        """Return the rejection for the simplest input found."""
        return self._to_rejection(self.search.simplest)


def shrink_and_reject(
    bench: Bench,
    function: str,
    failure: FailureT,
    case: CaseT,
    neighbours: Callable[[CaseT], Iterator[CaseT]],
    judge: Callable[[CaseT, Answer], FailureT | None],
    to_rejection: Callable[[FailureT], Exception],
    *,
    arguments: Callable[[CaseT], Arguments],
    stops: Callable[[FailureT], bool],
    fair: Callable[[CaseT], bool] = lambda case: True,
    costly: bool = False,
) -> NoReturn:
    """Raise the rejection of the simplest failure found from `failure` on `case`; see `ShrinkSearch`.

    On the main program, PendingShrink is raised and the search waits until all checks have run; on a side program it
    runs now. A re-enacted mistake is not shrunk. With `costly`, simpler cases are made one by one, when needed.
    """
    if bench.runner.reenacting or stops(failure):
        raise to_rejection(failure)
    budget, ahead = bench.runner.budget, 1 if costly else MAX_PREFETCHED
    search = ShrinkSearch(
        failure, case, neighbours, judge, budget=budget, fair=fair, stops=stops, ahead=ahead, clock=bench.runner.clock
    )
    unsimplified = PendingShrink(function, arguments, search, to_rejection)
    if bench.program is None:
        raise unsimplified
    shrink_all(bench.runner, [unsimplified], bench.answer_batches)
    raise unsimplified.rejection()


def shrink_all(
    runner: Runner,
    all_pending: Sequence[PendingShrink],
    answer_batches: Callable[[Sequence[PlannedCalls]], Sequence[Sequence[Answer]]],
) -> None:
    """Run the searches of several failed checks within their budgets; `answer_batches` makes the calls."""
    for pending in all_pending:
        pending.search.seconds *= len(all_pending)  # they share their time
    while True:
        limit = max(1, min(MAX_PREFETCHED, int(MAX_BATCH_SECONDS / runner.seconds_per_call)))
        due = [(pending, calls) for pending in all_pending if (calls := pending.next_calls(limit)) is not None]
        if not due:
            return
        for (pending, _), answers in zip(due, answer_batches([calls for _, calls in due]), strict=True):
            pending.search.store_answers(answers)


def run_and_shrink(run: Callable[[Bench], None], bench: Bench) -> None:
    """Run one check alone; its counterexample is shrunk before its rejection is raised."""
    try:
        run(bench)
    except PendingShrink as unsimplified:
        shrink_all(bench.runner, [unsimplified], bench.answer_batches)
        raise unsimplified.rejection() from None
