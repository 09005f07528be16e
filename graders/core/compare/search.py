"""Greedy search for the simplest failing input, with speculative batches: an exchange costs more than a call.

The result is that of the sequential search: simpler inputs are tried in order, and the search continues from the first
that fails. Each batch also holds the inputs that are likely to come next: simpler ones of the current input in case it
fails, its neighbours in case it passes.
"""

from __future__ import annotations

import heapq
import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from graders.core.compare.shrinking import Budget

CaseT = TypeVar("CaseT")
AnswerT = TypeVar("AnswerT")
FailureT = TypeVar("FailureT")

#: Probability that a simpler input fails; the same for one that passed before another simplification.
FAILS, FAILS_THEN = 0.7, 0.02
#: Least probability at which an input is tried speculatively.
LEAST = 0.06
#: Inputs called in all, as a multiple of the budget; inputs considered for one speculative call.
ASKED_FOR_ONE, LOOKED_AT_FOR_ONE = 2, 4


@dataclass(slots=True)
class _TriedCase(Generic[CaseT, AnswerT, FailureT]):
    """An input, its simpler inputs as far as enumerated, and its answer and failure once known.

    `passed` is the number of its parent's neighbours before it, all of which passed.
    """

    case: CaseT
    passed: int
    more: Iterator[CaseT]
    simpler: list[_TriedCase[CaseT, AnswerT, FailureT]] = field(default_factory=list)
    fair: bool | None = None
    answers: Sequence[AnswerT] = ()
    failures: Sequence[FailureT | None] = ()


class ShrinkSearch(Generic[CaseT, AnswerT, FailureT]):
    """Shrinks one failing input. `simplest` is the failure on the simplest input found so far.

    `neighbours` gives simpler inputs, the simplest first; `fair` tells whether an input is valid; `judge` gives the
    failure of an answer, None where it is no example of the same mistake; `stops` tells whether the search ends after
    a failure. `ahead` bounds the inputs of one batch. `clock` gives the seconds that the budget bounds.
    """

    def __init__(
        self,
        failure: FailureT,
        case: CaseT,
        neighbours: Callable[[CaseT], Iterator[CaseT]],
        judge: Callable[[CaseT, AnswerT], FailureT | None],
        *,
        budget: Budget,
        fair: Callable[[CaseT], bool] = lambda case: True,
        stops: Callable[[FailureT], bool] = lambda failure: False,
        ahead: int = 1,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.simplest, self.case = failure, case
        self._neighbours, self._judge, self._fair, self._stops = neighbours, judge, fair, stops
        self._budget, self._ahead, self._clock = budget, ahead, clock
        #: From the first question on.
        self.seconds = budget.seconds
        self._here: _TriedCase[CaseT, AnswerT, FailureT] = self._make_tried_case(case, 0)
        self._at = self._spent = self._asked = 0
        self._over, self._arrived = False, False
        self._deadline: float | None = None
        self._questions: list[_TriedCase[CaseT, AnswerT, FailureT]] = []

    def next_cases(self, limit: int = 1 << 30) -> list[CaseT]:
        """Return the next batch of inputs, at most `limit`; empty when the search is over."""
        if self._deadline is None:
            self._deadline = self._clock() + self.seconds
        due = self._next_unanswered()
        if due is None:
            return []
        limit = min(limit, self._ahead, self._budget.calls - self._spent)
        if self._asked >= ASKED_FOR_ONE * self._budget.calls:
            limit = 1
        self._questions = self._likely_unanswered(max(1, limit))
        self._asked += len(self._questions)
        return [question.case for question in self._questions]

    def store_answers(self, answers: Sequence[AnswerT]) -> None:
        """Store the answers to the last batch, in order; without any answer, the search is over."""
        for question, answer in zip(self._questions, answers, strict=False):
            question.answers = (answer,)
        self._over = self._over or not answers

    def _next_unanswered(self) -> _TriedCase[CaseT, AnswerT, FailureT] | None:
        """Advance over known answers; return the next input without an answer, None when the search is over."""
        while not self._over:
            candidate = self._simpler_case(self._here, self._at)
            if candidate is None or not (self._arrived or self._is_within_budget()):
                self._over = True
                break
            self._arrived = True
            if self._is_fair_case(candidate) and not candidate.answers:
                return candidate
            self._arrived = False
            self._spent += 1
            failure = self._find_failure(candidate) if candidate.fair else None
            if failure is None:
                self._at += 1
            else:
                self.simplest, self.case, self._here, self._at = failure, candidate.case, candidate, 0
                self._over = self._stops(failure)
        return None

    def _is_within_budget(self) -> bool:
        assert self._deadline is not None
        return self._spent < self._budget.calls and self._clock() <= self._deadline

    def _likely_unanswered(self, limit: int) -> list[_TriedCase[CaseT, AnswerT, FailureT]]:
        """Return the unanswered inputs that are most likely to be reached, the current one first."""
        numbers, looked = itertools.count(), itertools.count()
        ways = [(-1.0, next(numbers), self._here, self._at)]
        candidates: list[_TriedCase[CaseT, AnswerT, FailureT]] = []
        while ways and len(candidates) < limit and next(looked) < LOOKED_AT_FOR_ONE * limit:
            chance, _, parent, k = heapq.heappop(ways)
            candidate = self._simpler_case(parent, k)
            if candidate is None:
                continue
            fails = FAILS if k >= parent.passed else FAILS_THEN
            if not self._is_fair_case(candidate):
                fails = 0.0
            elif not candidate.answers:
                candidates.append(candidate)
            else:
                fails = 0.0 if self._find_failure(candidate) is None else 1.0
            if -chance * fails >= LEAST:
                heapq.heappush(ways, (chance * fails, next(numbers), candidate, 0))
            if -chance * (1.0 - fails) >= LEAST:
                heapq.heappush(ways, (chance * (1.0 - fails), next(numbers), parent, k + 1))
        return candidates

    def _make_tried_case(self, case: CaseT, passed: int) -> _TriedCase[CaseT, AnswerT, FailureT]:
        return _TriedCase(case, passed, iter(self._neighbours(case)))

    def _simpler_case(
        self, parent: _TriedCase[CaseT, AnswerT, FailureT], k: int
    ) -> _TriedCase[CaseT, AnswerT, FailureT] | None:
        """Return the k-th simpler input of a parent; None where there are fewer."""
        simpler = parent.simpler
        while len(simpler) <= k:
            for case in parent.more:
                simpler.append(self._make_tried_case(case, len(simpler)))
                break
            else:
                return None
        return simpler[k]

    def _is_fair_case(self, tried: _TriedCase[CaseT, AnswerT, FailureT]) -> bool:
        if tried.fair is None:
            tried.fair = self._fair(tried.case)
        return tried.fair

    def _find_failure(self, tried: _TriedCase[CaseT, AnswerT, FailureT]) -> FailureT | None:
        if not tried.failures:
            tried.failures = (self._judge(tried.case, tried.answers[0]),)
        return tried.failures[0]
